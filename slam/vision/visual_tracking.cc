#include "slam/vision/visual_tracking.h"

#include <cmath>
#include <numbers>

namespace slam {
namespace {

constexpr double kLongestInterval_s = 0.5;  // between frames; in a longer interval, frames are missing
constexpr double kLargestTurn_rad = 0.05;   // 1σ; beyond it an update is too far from linear
constexpr double kLargestShift_m = 0.1;     // 1σ; beyond it, a match near a prediction may be wrong
// Time before matching fails during which landmarks may be initialized wrongly.
constexpr double kDoubtful_s = 0.2;

// Standard deviations of a told start in a loaded map; poses within five of them agree with it.
constexpr double kKnownTurn_rad = 0.03, kKnownShift_m = 0.03;
constexpr double kRoughTurn_rad = 0.2, kRoughShift_m = 0.3;
constexpr double kMapTurn_rad = 0.02, kMapShift_m = 0.05;  // added to the first pose in a loaded map
constexpr double kLongestSearch_s = 20, kLargestSearch_rad = 60 * std::numbers::pi / 180;

/// The covariance of a pose with these standard deviations of orientation and position.
Matrix6d diagonal(double turn_rad, double shift_m) {
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(turn_rad), Eigen::Vector3d::Constant(shift_m);
  return sigma.cwiseAbs2().asDiagonal();
}

// The paper's standard deviation of the height, to judge the height with.
constexpr double kRoughHeight_m = 0.03;

/// The NIS of the height with the paper's standard deviation: floor and soles may differ by centimeters.
std::optional<double> rough_nis(const std::optional<Nis>& height) {
  if (!height) return std::nullopt;
  const double S = std::exp(height->log_determinant);
  return height->value * S / (S + kRoughHeight_m * kRoughHeight_m);
}

bool knows_turn(const Estimate& pose) {
  return pose.covariance.diagonal().head<3>().maxCoeff() < kLargestTurn_rad * kLargestTurn_rad;
}
bool knows_place(const Estimate& pose) {
  return pose.covariance.diagonal().tail<3>().maxCoeff() < kLargestShift_m * kLargestShift_m;
}

}  // namespace

bool knows_pose(const Estimate& pose) { return knows_turn(pose) && knows_place(pose); }

Estimate pose_estimate(const State& state, Stamp t) {
  Eigen::Vector4d inverse = state.orientation();
  inverse.tail<3>() *= -1;
  // Jacobian of (orientation, position) errors.
  Eigen::Matrix<double, 6, 7> J = Eigen::Matrix<double, 6, 7>::Zero();
  J.block<3, 4>(0, kOrientation) = 2 * left_matrix(inverse).bottomRows<3>();
  J.block<3, 3>(3, kPosition).setIdentity();
  const Matrix6d covariance = J * state.marginal<7>(0) * J.transpose();
  return {t, state.X_WC(), (covariance + covariance.transpose()) / 2};
}

VisualTracking::VisualTracking(const Options& options, const Camera& camera, std::uint64_t seed)
    : enabled_(options.vision.enabled),
      sigma_px_(options.vision.sigma_px),
      lost_after_s_(options.tracking.lost_after_s),
      camera_(camera),
      vision_(options.vision, options.bounds, camera),
      map_(options, camera, seed) {}

void VisualTracking::start_from(const SavedMap& map, MapStart start, Kalman& kalman) {
  map_.load(map, kalman);
  loaded_ = {MapUse::searching, start, Stamp(0), {}};
}

VisualResult VisualTracking::step(const VisualInput& in) {
  result_ = {};
  if (!enabled_) return result_;
  if (map_use() == MapUse::searching) refuse_if_not_recognized(in);
  if (in.image.empty()) {
    blind(in, "no image arrives");
    return result_;
  }
  if (const auto defect = image_check_.defect(in.image, in.stands_still)) {
    in.report.refused.add(defect->reason);
    if (defect->blinds) blind(in, defect->reason);
  } else {
    track(in);
  }
  in.report.note(SensorIndex::vision, in.report.matched.empty() ? SensorUse::readings : SensorUse::accepted);
  return result_;
}

void VisualTracking::blind(const VisualInput& in, const std::string& why) {
  const Estimate pose = pose_estimate(in.kalman.state(), in.t);
  in.tracking.blind(in.interval, why, knows_pose(pose));
}

/// Measures the landmarks of the map in a usable image, and searches for the map if the filter is lost.
void VisualTracking::track(const VisualInput& in) {
  result_.good_image = !(seconds(in.interval) > kLongestInterval_s);
  const bool was_lost = in.tracking.health() == Health::lost, was_blind = in.tracking.is_blind();
  if (!result_.good_image) blind(in, "no frame arrives");
  if (map_use() == MapUse::searching) return relocalize(in);
  const Estimate pose = pose_estimate(in.kalman.state(), in.t);
  if (in.tracking.health() == Health::lost && !knows_turn(pose)) {
    if (was_lost) relocalize(in);  // a loss is reported at least once
    return;
  }
  if (in.tracking.health() == Health::lost && !(in.tracking.is_blind() && knows_place(pose))) {
    const std::chrono::duration<double> doubtful(lost_after_s_ + kDoubtful_s);
    const Stamp before =
        in.t - in.interval - in.tracking.lost_for() - std::chrono::duration_cast<Stamp>(doubtful);
    if (!vision_.recognizes(in.image, in.t, map_.landmarks(), before, in.kalman)) {
      record_searches(in, false);
      return relocalize(in);
    }
    recovered(in);
  }
  if (const auto unseen = measure(in)) {
    in.tracking.blind(in.interval, *unseen);
    if (was_blind) relocalize(in);
  } else if (was_blind) {
    recovered(in);
  } else if (!in.tracking.is_blind()) {
    in.tracking.sees();
  }
}

/// Returns the reason if no landmark was seen. uncertain: see Vision::update.
std::optional<std::string> VisualTracking::measure(const VisualInput& in,
                                                   const std::optional<RobotState>& uncertain) {
  const std::size_t before = map_.landmarks().size();
  if (!map_.initialize_known(in.image, in.t, in.kalman))
    in.report.refused.add("a known landmark is not seen in the first image");
  report_initialized(before, in.report);
  const bool doubted = in.tracking.in_doubt();
  const VisionResult& vision = vision_.update(in.image, in.t, map_.landmarks(), in.kalman, uncertain,
                                              doubted && in.tracking.is_blind() ? kLeastInDoubt : 1);
  in.report.predicted = static_cast<int>(vision.visible.size());
  in.report.measured = vision.matches;
  if (!vision.inliers.empty()) {
    if (!vision.updated) in.tracking.diverge("the vision innovation covariance is not positive definite");
    refine_landmarks(in, vision);
  }
  in.report.searched = vision.searched;
  for (const Search& s : vision.searched)
    if (s.used) in.report.matched.push_back({s.landmark, *s.match});
  in.report.accepted = static_cast<int>(in.report.matched.size());
  const auto vision_nis = vision.gate ? std::optional(vision.gate->value / vision.gate->dof) : std::nullopt;
  result_.statistics = {
      seconds(in.interval), vision.tested, vision.inliers.size(),
      vision.coverage,      vision_nis,    rough_nis(nis_of(in.report.innovations, "height"))};
  if (vision.update) in.report.innovations.push_back({"vision", *vision.update});
  const bool failed = matching_failed(*result_.statistics);
  record_searches(in, !failed);  // otherwise the image or the pose is wrong, not the landmarks
  for (const std::size_t index : vision.visible_indices) map_.record_visible(index, in.t);
  result_.deleted_young = map_.prune(in.kalman, in.report.deleted);
  in.tracking.judge(*result_.statistics);
  if (!in.tracking.in_doubt()) map_.end_trial(false, in.kalman, in.report.deleted);
  const bool may_initialize = !failed && in.tracking.in_doubt() == doubted;
  const InitializationCount initialized = manage_map(in, vision, may_initialize);
  if (failed) return "almost no landmarks were found";
  const bool passed = in.tracking.in_doubt() && try_new_landmarks(in);
  if (passed || !vision.inliers.empty() || !in.report.lines.empty()) return std::nullopt;
  if (in.tracking.in_doubt() || !vision.searched.empty()) return "no landmark was found";
  const bool dead_reckons = in.has_plan && map_.landmarks().empty();  // no map for the images to contradict
  if (initialized.wanted > 0 && initialized.added == 0 && !dead_reckons)
    return "the image has no corner for a landmark";
  return std::nullopt;
}

/// Keeps the landmarks initialized in doubt once they prove to be part of the room; returns whether they did.
bool VisualTracking::try_new_landmarks(const VisualInput& in) {
  const auto passed = vision_.passes_trial(in.image, in.t, map_.landmarks(), in.kalman);
  if (passed) map_.end_trial(*passed, in.kalman, in.report.deleted);
  return passed.value_or(false);
}

/// counts: see Map::record_search.
void VisualTracking::record_searches(const VisualInput& in, bool counts) {
  const VisionResult& vision = vision_.result();
  for (std::size_t i = 0; i < vision.searched.size(); ++i)
    map_.record_search(vision.searched_indices[i], vision.searched[i], counts, in.t, in.kalman);
}

/// Improves the surface normal of one matched landmark, and inflates the covariances of all for the change of
/// view.
void VisualTracking::refine_landmarks(const VisualInput& in, const VisionResult& vision) {
  const std::size_t chosen = vision.inliers[static_cast<std::size_t>(in.frame) % vision.inliers.size()];
  map_.refine_surface(vision.searched_indices[chosen], in.image, *vision.searched[chosen].match,
                      in.kalman.state());
  for (const std::size_t i : vision.inliers)
    map_.inflate_for_view_change(vision.searched_indices[i], in.kalman);
}

InitializationCount VisualTracking::manage_map(const VisualInput& in, const VisionResult& vision,
                                               bool may_initialize) {
  map_.convert_to_points(in.t, in.kalman);
  map_.search_lines(in.image, in.kalman, in.report.deleted, in.report.lines);
  InitializationCount initialized;
  if (may_initialize)
    initialized = map_.initialize(in.image, in.depth, in.t, vision.visible, in.kalman, in.report.deleted,
                                  in.tracking.in_doubt());
  const std::size_t first = map_.landmarks().size() - static_cast<std::size_t>(initialized.added);
  for (std::size_t i = first; i < map_.landmarks().size(); ++i)
    vision_.biases().add(map_.landmarks()[i].id, true, in.kalman);
  report_initialized(first, in.report);
  return initialized;
}

/// Reports the landmarks starting at index `first` as initialized in this frame.
void VisualTracking::report_initialized(std::size_t first, FrameReport& report) {
  for (std::size_t i = first; i < map_.landmarks().size(); ++i)
    report.initialized.push_back({map_.landmarks()[i].id, map_.landmarks()[i].pixel_first});
}

void VisualTracking::relocalize(const VisualInput& in) {
  const Estimate predicted = pose_estimate(in.kalman.state(), in.t);
  auto found =
      slam::relocalize(in.image, map_.landmarks(), in.kalman.state(), headings_.next(), camera_, sigma_px_);
  if (!found || !knows_pose(*found)) return;
  found->t = in.t;
  const Eigen::Matrix3d turn = found->X_WC.linear() * predicted.X_WC.linear().transpose();
  headings_.begin_with(std::atan2(turn(1, 0), turn(0, 0)));
  const bool in_loaded_map = map_use() == MapUse::searching;
  // A pose that is known is mostly more accurate than the one found.
  const bool known = in.tracking.is_blind() && knows_pose(predicted);
  if (!(in_loaded_map ? confirms(in, *found, predicted)
        : known       ? confirmer_.moves_alike(*found, predicted, in.has_plan)
                      : confirmer_.confirms(*found, predicted, in.has_plan)))
    return;
  in.kalman.reset_robot(relocalized_state(*found, in.kalman.state()));
  vision_.biases().clear(in.kalman);
  recovered(in);
  in.report.relocalized = true;
  if (!in_loaded_map) return;
  loaded_.use = MapUse::found;
  // The pose rejects landmarks that moved. It shares its error with the map, which the update shows only to
  // an uncertain pose.
  found->covariance += diagonal(kMapTurn_rad, kMapShift_m);
  measure(in, relocalized_state(*found, in.kalman.state()));
}

/// Returns whether a pose in a loaded map is accepted. A told start must agree with it; without one, it must
/// move as predicted for a second, and no other pose may show as much of the map.
bool VisualTracking::confirms(const VisualInput& in, const Estimate& found, const Estimate& predicted) {
  if (loaded_.start == MapStart::unknown)
    return confirmer_.moves_alike(found, predicted, in.has_plan) && !is_ambiguous(in, found);
  Estimate told = predicted;
  told.covariance += loaded_.start == MapStart::known ? diagonal(kKnownTurn_rad, kKnownShift_m)
                                                      : diagonal(kRoughTurn_rad, kRoughShift_m);
  return agree(found, told);
}

bool VisualTracking::is_ambiguous(const VisualInput& in, const Estimate& found) const {
  Headings all;
  for (int k = 0; k < Headings::kCount; ++k) {
    const auto other =
        slam::relocalize(in.image, map_.landmarks(), in.kalman.state(), all.next(), camera_, sigma_px_);
    if (other && !is_same_view(other->X_WC, found.X_WC)) return true;
  }
  return false;
}

/// Starts a new map if the loaded one was not recognized within a time, or while the camera has turned.
void VisualTracking::refuse_if_not_recognized(const VisualInput& in) {
  const Eigen::Matrix3d R = in.kalman.state().X_WC().linear();
  if (!loaded_.R_first) loaded_.R_first = R;
  loaded_.searched += in.interval;
  if (seconds(loaded_.searched) < kLongestSearch_s &&
      Eigen::AngleAxisd(loaded_.R_first->transpose() * R).angle() < kLargestSearch_rad)
    return;
  map_.clear(in.kalman);
  loaded_.use = MapUse::refused;
  recovered(in);
}

void VisualTracking::recovered(const VisualInput& in) {
  confirmer_.clear();
  headings_ = {};
  map_.forget_misses();
  in.tracking.relocalized();
}

}  // namespace slam
