#include "sim/tracking/tracking.h"

#include <utility>

namespace sim::tracking {
namespace {

constexpr slam::Stamp kMapEvery = std::chrono::seconds(1);

// Empty for the filter itself.
estimators::Estimator make_estimator(const std::string& name, const slam::Calibration& calibration,
                                     const Eigen::Isometry3d& X_WC_start) {
  for (const estimators::NamedEstimator& estimator : estimators::estimators())
    if (estimator.name == name) return estimator.make(calibration, X_WC_start);
  return {};
}

/// The calibration as the filter is told it.
slam::Calibration miscalibrated(slam::Calibration calibration, const sensor_errors::ErrorOptions& errors) {
  if (auto* lens = std::get_if<slam::OneParameterRadial>(&calibration.camera.lens))
    lens->k1_px2 *= 1 + errors.calibration.distortion_fraction;
  return calibration;
}

}  // namespace

bool Tracked::diverged() const { return !frames.empty() && frames.back().report.health != slam::Health::ok; }

const std::string& Tracked::cause() const { return frames.back().report.cause; }

std::vector<slam::Estimate> Tracked::estimates() const {
  std::vector<slam::Estimate> all;
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
  bool trusted = true;
  for (const TrackedFrame& frame : frames) {
    const slam::FrameReport& report = frame.report;
    if (trusted && !report.suspect.empty()) all.push_back({report.t, std::nullopt, ""});
    if (!trusted && report.suspect.empty()) all.back().to = report.t;
    trusted = report.suspect.empty();
    if (!trusted) all.back().cause = report.suspect;
  }
  return all;
}

Tracking::Tracking(const scenario::Scenario& scenario, const slam::Calibration& calibration,
                   const Eigen::Isometry3d& X_WC_start)
    : errors_(scenario.errors, scenario.seed),
      filter_(*scenario.slam, miscalibrated(calibration, scenario.errors), X_WC_start, scenario.seed),
      estimator_(make_estimator(scenario.estimator, miscalibrated(calibration, scenario.errors), X_WC_start)) {}

void Tracking::take(slam::Observation ideal) {
  for (const slam::Observation& arrived : errors_.take(std::move(ideal))) step(arrived);
}

void Tracking::step(const slam::Observation& arrived) {
  if (estimator_) {
    slam::FrameReport report;
    report.t = arrived.t;
    tracked_.frames.push_back({estimator_(arrived), report});
    return;
  }
  const auto& frames = tracked_.frames;
  if (!frames.empty() && frames.back().report.health == slam::Health::diverged) {
    tracked_.after_divergence.push_back(arrived.t);
    return;
  }
  const slam::FrameReport& report = filter_.step(arrived);
  tracked_.frames.push_back({filter_.estimate(), report});
  auto& maps = tracked_.maps;
  if (maps.empty() || report.t - maps.back().t >= kMapEvery) maps.push_back({report.t, filter_.map()});
}

Tracked Tracking::finish() {
  for (const slam::Observation& arrived : errors_.flush()) step(arrived);
  tracked_.map = filter_.map();
  return std::move(tracked_);
}

}  // namespace sim::tracking
