#include "slam/filter.h"

#include <algorithm>
#include <utility>

#include "slam/initial_state.h"
#include "slam/relocalisation.h"

namespace slam {
namespace {

constexpr double kLongestStep_s = 10;         // a later time is taken for a broken clock
constexpr double kLongestInterval_s = 0.5;    // between frames; in a longer one, frames are missing
constexpr int kFramesBetweenFullChecks = 30;  // of the whole covariance
constexpr int kMostChecked = 600;             // parameters of it, because the cost grows with their cube
constexpr double kLargestTurn_rad = 0.1;      // 1σ; beyond it an update is too far from linear
constexpr Stamp kDoubtful{
    3'000'000'000};  // before a loss, in which landmarks may have been initialised wrongly

/// The pose part of the state; its covariance is symmetric to the last bit.
Estimate pose_estimate(const State& state, Stamp t) {
  Eigen::Vector4d inverse = state.orientation();
  inverse.tail<3>() *= -1;
  Eigen::Matrix<double, 6, 7> J = Eigen::Matrix<double, 6, 7>::Zero();  // of (orientation, position) errors
  J.block<3, 4>(0, kOrientation) = 2 * left_matrix(inverse).bottomRows<3>();
  J.block<3, 3>(3, kPosition).setIdentity();
  const Matrix6d covariance = J * state.marginal<7>(0) * J.transpose();
  return {t, state.X_WC(), (covariance + covariance.transpose()) / 2};
}

/// Whether landmarks can be searched for where they are predicted, and their matches correct the pose.
bool is_oriented(const State& state, Stamp t) {
  return pose_estimate(state, t).covariance.diagonal().head<3>().maxCoeff() <
         kLargestTurn_rad * kLargestTurn_rad;
}

std::optional<double> per_degree_of_freedom(const std::optional<Nis>& nis) {
  return nis ? std::optional(nis->value / nis->dof) : std::nullopt;
}

}  // namespace

Filter::Filter(const Options& options, const Calibration& calibration, const Eigen::Isometry3d& X_WC_start,
               std::uint64_t seed)
    : options_(options),
      camera_(calibration.camera),
      kalman_(initial_state(X_WC_start, options),
              options.consistency.observability_constrained && options.known_landmarks.at_m.empty(),
              MatchErrors::places(options.vision, options.bounds)),
      internal_(options, calibration.X_CG),
      vision_(options.vision, options.bounds, camera_),
      map_(options, camera_, seed),
      tracking_(options.tracking),
      sensor_watch_(options) {
  publish();
}

/// One cycle of the filter of the paper's sections III and IV.
const FrameReport& Filter::step(const Observation& o) {
  clear_report(o.t);
  report_.refused = objection(o);
  if (!report_.refused.empty()) {
    refuse_whole();
    return report_;
  }
  tracking_.accepts();
  const Stamp interval = now_ ? o.t - *now_ : Stamp(0);
  const bool was_lost = tracking_.health() == Health::lost;
  const auto planned = internal_.advance_plan(o, seconds(interval));
  if (now_) predict_and_measure_internally(o, planned);  // eq. (6) and section IV
  good_image_ = false;
  if (options_.vision.enabled) look(o, interval, planned);
  judge_sensors(o, seconds(interval));
  if (was_lost) tracking_.remains_lost(interval);
  if (now_) interval_ = interval;
  now_ = o.t;
  publish();
  return report_;
}

/// An observation that is refused changes nothing of the state; the health knows of it.
void Filter::refuse_whole() {
  tracking_.refuses(interval_, report_.refused);
  report_health();
}

/// Uses the image of an observation, if it can be used, and tells the health what was seen.
void Filter::look(const Observation& o, Stamp interval, const std::optional<PlannedVelocity>& planned) {
  if (o.image.empty()) return tracking_.blind(interval, "no image arrives");
  const ImageDefect defect = image_check_.defect(o.image, stands_still(o, planned, options_));
  refuse(defect.reason);
  if (defect.blinds) tracking_.blind(interval, defect.reason);
  if (!defect.reason.empty()) return;
  good_image_ = !(seconds(interval) > kLongestInterval_s);
  const bool was_lost = tracking_.health() == Health::lost, was_blind = tracking_.is_blind();
  if (seconds(interval) > kLongestInterval_s) tracking_.blind(interval, "no frame arrives");
  if (tracking_.health() == Health::lost && !is_oriented(kalman_.state(), o.t)) {
    if (was_lost) relocalise_in(o);  // a loss is reported once at least
    return;
  }
  if (tracking_.health() == Health::lost && !tracking_.is_blind()) {
    const Stamp before = o.t - interval - tracking_.lost_for() - kDoubtful;
    if (!vision_.recognises(o.image, map_.landmarks(), before, kalman_)) return relocalise_in(o);
    recognition_.clear();
    tracking_.relocalised();
  }
  const std::string unseen = measure_visually(o, seconds(interval));  // section III-A
  if (unseen.empty()) {
    if (was_blind || !tracking_.is_blind()) tracking_.sees();
  } else {
    tracking_.blind(interval, unseen);
    if (was_blind) relocalise_in(o);
  }
}

void Filter::judge_sensors(const Observation& o, double dt) {
  report_.evidence = kalman_.take_evidence();
  sensor_watch_.gyro().take(o.gyro);
  sensor_watch_.images().take_health(dt, tracking_.health() != Health::ok, good_image_);
  if (report_.relocalised) return sensor_watch_.reset();
  sensor_watch_.take(report_.evidence, dt);
}

void Filter::predict_and_measure_internally(const Observation& o,
                                            const std::optional<PlannedVelocity>& planned) {
  const GatedPrediction gated = internal_.predict(o, *now_, planned, kalman_.state());
  if (gated.accelerometer_rejected) refuse("accelerometer is beyond its gate");
  kalman_.predict(gated.prediction.x, gated.prediction.F, gated.prediction.Q);
  vision_.errors().predict(seconds(o.t - *now_), kalman_);
  const InternalResult internal = internal_.update(o, *now_, planned, kalman_);
  refuse(internal.rejected);
  if (!internal.updated) tracking_.diverge("the internal innovation covariance is not positive definite");
  report_.gyro = internal.gyro;
  report_.plan_velocity = internal.plan_velocity;
  report_.height = internal.height;
}

/// Returns why nothing of the map was seen; empty if something was.
std::string Filter::measure_visually(const Observation& o, double dt) {
  const std::size_t before = map_.landmarks().size();
  if (!map_.initialise_known(o.image, o.t, kalman_))
    refuse("a known landmark is not seen in the first image");
  report_initialised(before);
  const VisionResult& vision = vision_.update(o.image, map_.landmarks(), kalman_);
  if (!vision.inliers.empty()) use_matches(o.image, vision);
  report_vision(vision);
  const TrackingStatistics statistics{dt,
                                      vision.searched.size(),
                                      vision.inliers.size(),
                                      vision.coverage,
                                      per_degree_of_freedom(vision.nis),
                                      per_degree_of_freedom(report_.height)};
  const bool failed = matching_failed(statistics);
  if (!failed)  // otherwise the image or the pose is at fault, not the landmarks
    for (const SearchedLandmark& s : vision.searched) map_.record_search(s.index, s.inlier);
  for (const std::size_t index : vision.visible_indices) map_.record_visible(index, o.t);
  const std::size_t young = map_.prune(kalman_, report_.deleted);
  sensor_watch_.images().take(dt, statistics.searched, statistics.accepted, young);
  const InitialisationCount initialised = manage_map(o, vision, !failed && !tracking_.in_doubt());
  tracking_.judge(statistics);
  if (failed) return "almost no landmark found";
  if (!vision.inliers.empty() || !report_.lines.empty()) return "";
  if (!vision.searched.empty()) return "no landmark found";
  return initialised.wanted > 0 && initialised.added == 0 ? "the image has no corner for a landmark" : "";
}

void Filter::use_matches(const cv::Mat& image, const VisionResult& vision) {
  if (!vision.updated) tracking_.diverge("the vision innovation covariance is not positive definite");
  const std::size_t turn = static_cast<std::size_t>(frames_) % vision.inliers.size();
  const SearchedLandmark& chosen = vision.searched[vision.inliers[turn]];  // one a frame bounds the cost
  map_.refine_surface(chosen.index, image, *chosen.match, kalman_.state());
  for (const std::size_t i : vision.inliers) map_.inflate_for_view_change(vision.searched[i].index, kalman_);
}

InitialisationCount Filter::manage_map(const Observation& o, const VisionResult& vision, bool may_initialise) {
  map_.convert_to_points(kalman_);
  map_.search_lines(o.image, kalman_, report_.deleted, report_.lines);
  InitialisationCount initialised;
  if (may_initialise)
    initialised = map_.initialise(o.image, o.t, vision.visible, kalman_, report_.deleted);
  const auto& landmarks = map_.landmarks();
  for (std::size_t i = landmarks.size() - static_cast<std::size_t>(initialised.added); i < landmarks.size(); ++i)
    vision_.errors().add(landmarks[i].id, true, kalman_);
  report_initialised(map_.landmarks().size() - static_cast<std::size_t>(initialised.added));
  report_.landmarks = static_cast<int>(map_.landmarks().size());
  return initialised;
}

void Filter::relocalise_in(const Observation& o) {
  if (!recognition_.is_due(o.t)) return;
  const auto found =
      relocalise(o.image, map_.landmarks(), kalman_.state(), camera_, options_.vision.sigma_px);
  if (!found || !recognition_.believes(o.t, *found, pose_estimate(kalman_.state(), o.t), o.plan.has_value()))
    return;
  recognition_.clear();
  kalman_.reset_robot(relocalised_state(*found, kalman_.state()));
  vision_.errors().clear(kalman_);
  tracking_.relocalised();
  report_.relocalised = true;
}

/// Resets the report without releasing the memory of its lists.
void Filter::clear_report(Stamp t) {
  FrameReport last;
  std::swap(last, report_);
  const auto reuse_memory = [](auto& list, auto& previous) {
    list.swap(previous);
    list.clear();
  };
  reuse_memory(report_.initialised, last.initialised);
  reuse_memory(report_.matched, last.matched);
  reuse_memory(report_.searched, last.searched);
  reuse_memory(report_.deleted, last.deleted);
  reuse_memory(report_.lines, last.lines);
  report_.t = t;
  report_.landmarks = static_cast<int>(map_.landmarks().size());
  report_health();
}

void Filter::report_health() {
  report_.health = tracking_.health();
  report_.cause = tracking_.cause();
  report_.suspect = sensor_watch_.suspect();
}

/// Why the observation cannot be used at all; empty if it can.
std::string Filter::objection(const Observation& o) const {
  if (tracking_.health() == Health::diverged) return "the filter has stopped: " + tracking_.cause();
  if (now_ && o.t <= *now_) return "its time is not after the last one's";
  if (now_ && seconds(o.t - *now_) > kLongestStep_s) return "its time is more than 10 s after the last one's";
  return malformation(o, camera_.intrinsics());
}

void Filter::refuse(const std::string& reason) {
  if (!reason.empty()) add_reason(report_.refused, reason);
}

void Filter::report_vision(const VisionResult& vision) {
  report_.predicted = static_cast<int>(vision.visible.size());
  report_.measured = vision.matches;
  report_.accepted = static_cast<int>(vision.inliers.size());
  report_.vision = vision.nis;
  report_.update = vision.update_nis;
  for (const SearchedLandmark& s : vision.searched) {
    const int id = map_.landmarks()[s.index].id;
    report_.searched.push_back({id, s.predicted, s.S, s.inlier, s.match});
    if (s.inlier) report_.matched.push_back({id, *s.match});
  }
}

/// Reports the landmarks from index `first` on as initialised in this frame.
void Filter::report_initialised(std::size_t first) {
  for (std::size_t i = first; i < map_.landmarks().size(); ++i)
    report_.initialised.push_back({map_.landmarks()[i].id, map_.landmarks()[i].pixel_first});
}

void Filter::publish() {
  const State& state = kalman_.state();
  if (!kalman_.is_valid(++frames_ % kFramesBetweenFullChecks == 0 ? std::min(state.size, kMostChecked) : kRobot))
    tracking_.diverge("the state is not finite or its covariance not positive definite");
  estimate_ = pose_estimate(state, now_.value_or(Stamp{0}));
  report_health();
}

}  // namespace slam
