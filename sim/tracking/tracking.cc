#include "sim/tracking/tracking.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <new>
#include <stdexcept>
#include <utility>

namespace sim::tracking {
namespace {

constexpr slam::Stamp kMapEvery = std::chrono::seconds(1);

/// The calibration as the filter is told it.
slam::Calibration miscalibrated(slam::Calibration calibration, const sensor_errors::ErrorOptions& errors) {
  if (auto* lens = std::get_if<slam::OneParameterRadial>(&calibration.camera.lens))
    lens->k1_px2 *= 1 + errors.calibration.distortion_fraction;
  return calibration;
}

/// What was suspect in the frames of one time: each sensor with the last that was said of it.
class Suspects {
 public:
  void take(const std::string& cause) {
    const std::string sensor = cause.substr(0, cause.find(','));
    auto found = std::find_if(said_.begin(), said_.end(), [&](const Said& s) { return s.sensor == sensor; });
    if (found == said_.end()) found = said_.insert(found, {sensor, "", 0});
    found->cause = cause;
    ++found->frames, ++frames_;
  }
  bool empty() const { return said_.empty(); }
  /// With the share of the frames of each, where there are several.
  std::string text() const {
    if (said_.size() == 1) return said_.front().cause;
    std::string text;
    for (const Said& said : said_)
      text += (text.empty() ? "" : "; ") + said.cause + " (" +
              std::to_string(std::lround(100 * said.frames / frames_)) + " % of these frames)";
    return text;
  }

 private:
  struct Said {
    std::string sensor, cause;
    double frames;
  };
  std::vector<Said> said_;
  double frames_ = 0;
};

}  // namespace

bool Tracked::diverged() const { return !frames.empty() && frames.back().report.health != slam::Health::ok; }

std::string Tracked::cause() const {
  const slam::FrameReport& last = frames.back().report;
  return last.cause +
         (last.health == slam::Health::lost ? "; the map was not found again before the end" : "");
}

std::vector<estimators::PoseEstimate> Tracked::estimates() const {
  std::vector<estimators::PoseEstimate> all;
  for (const TrackedFrame& frame : frames)
    if (all.empty() || frame.estimate.t > all.back().t) all.push_back(frame.estimate);
  return all;
}

std::vector<TrackingFault> Tracked::losses() const {
  std::vector<TrackingFault> all;
  bool ok = true;
  for (const TrackedFrame& frame : frames) {
    const slam::FrameReport& report = frame.report;
    if (ok && report.health != slam::Health::ok) all.push_back({report.t, std::nullopt, report.cause});
    if (!ok && report.health == slam::Health::ok) all.back().to = report.t;
    ok = report.health == slam::Health::ok;
    if (!ok) all.back().cause = report.cause;
  }
  return all;
}

std::vector<TrackingFault> Tracked::suspicions() const {
  std::vector<TrackingFault> all;
  Suspects suspects;
  for (const TrackedFrame& frame : frames) {
    const slam::FrameReport& report = frame.report;
    if (report.suspect.empty()) {
      if (!suspects.empty()) all.back().to = report.t;
      suspects = Suspects();
      continue;
    }
    if (suspects.empty()) all.push_back({report.t, std::nullopt, ""});
    suspects.take(report.suspect);
    all.back().cause = suspects.text();
  }
  return all;
}

Tracking::Tracking(const scenario::Scenario& scenario, const slam::Calibration& calibration,
                   const Eigen::Isometry3d& X_WC_start, estimators::Estimator estimator)
    : errors_(scenario.errors, scenario.seed),
      filter_(*scenario.slam, miscalibrated(calibration, scenario.errors), X_WC_start, scenario.seed),
      estimator_(std::move(estimator)) {}

Tracking::Tracking(const scenario::Scenario& scenario, const slam::Calibration& calibration,
                   const Eigen::Isometry3d& X_WC_start)
    : Tracking(scenario, calibration, X_WC_start, {}) {
  try {
    estimator_ = estimators::make_estimator(
        scenario.estimator, {miscalibrated(calibration, scenario.errors), X_WC_start, scenario.seed});
  } catch (const estimators::EstimatorFailed& failure) {
    tracked_.failed = failure.what();
    tracked_.log = failure.log;
  }
}

// What somebody else's code throws is its failure. That there is no memory left is this program's.
template <class Action>
void Tracking::guarded(const Action& action) {
  try {
    action();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& failure) {
    tracked_.failed = failure.what();
  } catch (...) {
    tracked_.failed = "it threw what is no exception of the standard library";
  }
}

void Tracking::take(slam::Observation ideal) {
  for (const slam::Observation& arrived : errors_.process(std::move(ideal))) step(arrived);
}

void Tracking::step(const slam::Observation& arrived) {
  const auto& frames = tracked_.frames;
  const bool diverged = !frames.empty() && frames.back().report.health == slam::Health::diverged;
  if (!diverged && !tracked_.failed)
    guarded([&] { estimator_.step ? step_estimator(arrived) : step_filter(arrived); });
  if (diverged || tracked_.failed) tracked_.after_divergence.push_back(arrived.t);
}

void Tracking::step_filter(const slam::Observation& arrived) {
  const slam::FrameReport& report = filter_.step(arrived);
  const slam::Estimate& estimate = filter_.estimate();
  tracked_.frames.push_back({{estimate.t, estimate.X_WC, estimate.covariance}, report});
  const auto& maps = tracked_.maps;
  if (maps.empty() || report.t - maps.back().t >= kMapEvery) keep_map(report.t, filter_.map());
}

void Tracking::step_estimator(const slam::Observation& arrived) {
  newest_ = std::max(newest_, arrived.t);
  estimators::Answer answer = estimator_.step(arrived);
  outside_cpu_ms_ += answer.outside_cpu_ms;
  estimators::require_sound(
      answer, tracked_.frames.empty() ? slam::Stamp(0) : tracked_.frames.back().estimate.t, newest_);
  if (!answer.map.empty()) keep_map(arrived.t, std::move(answer.map));
  slam::FrameReport report;
  report.t = arrived.t;
  report.health = answer.health;
  report.cause = answer.cause;
  report.landmarks = static_cast<int>(tracked_.map.size());
  tracked_.frames.push_back({answer.estimate, report});
}

// Of another estimator the newest that it told is also the one at the end.
void Tracking::keep_map(slam::Stamp t, std::vector<slam::MapPoint> map) {
  auto& maps = tracked_.maps;
  if (estimator_.step) tracked_.map = map;
  if (maps.empty() || t - maps.back().t >= kMapEvery) maps.push_back({t, std::move(map)});
}

Tracked Tracking::finish() {
  for (const slam::Observation& arrived : errors_.flush()) step(arrived);
  if (estimator_.step)
    tracked_.log = estimator_.finish();
  else if (!tracked_.failed)
    tracked_.map = filter_.map();
  return std::move(tracked_);
}

}  // namespace sim::tracking
