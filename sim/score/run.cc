#include "sim/score/run.h"

#include <algorithm>

namespace sim::score {
namespace {

constexpr Stamp kOutOfView = std::chrono::seconds(5);
constexpr double kTolerance_px = 3, kFar_m = 1000;

// Returns the true pose at exactly that time, or null.
const Eigen::Isometry3d* pose_at(const Run& run, Stamp t) {
  const auto at = std::ranges::lower_bound(run.truth_camera, t, {}, &TimedPose::t);
  return at != run.truth_camera.end() && at->t == t ? &at->X : nullptr;
}

/// Returns whether the first surface on a ray belongs to one of these actors.
bool shows(const std::vector<Surface>& actors, const Run& run, const Eigen::Vector3d& origin,
           const Eigen::Vector3d& direction) {
  const auto distance = first_hit(actors, origin, direction);
  return distance && *distance < first_hit(run.surfaces, origin, direction).value_or(kFar_m);
}

/// Returns whether the pixel shows an actor; nothing if the true pose is unknown.
std::optional<bool> shows_actor(const Run& run, const StampedPixel& seen) {
  const Eigen::Isometry3d* const X_WC = pose_at(run, seen.t);
  if (!X_WC) return std::nullopt;
  return run.actors &&
         shows(run.actors(seen.t), run, X_WC->translation(), X_WC->linear() * run.camera.bearing(seen.pixel));
}

std::optional<Eigen::Vector3d> surface_point(const Run& run, const StampedPixel& seen) {
  if (shows_actor(run, seen).value_or(true)) return std::nullopt;
  const Eigen::Isometry3d& X_WC = *pose_at(run, seen.t);
  const Eigen::Vector3d direction = X_WC.linear() * run.camera.bearing(seen.pixel);
  const auto distance = first_hit(run.surfaces, X_WC.translation(), direction);
  if (!distance) return std::nullopt;
  return X_WC.translation() + *distance * direction;
}

// The points of the room that the camera at X_WC sees on its grid; far away if it sees none.
std::vector<Eigen::Vector3d> view_from(const Run& run, const Eigen::Isometry3d& X_WC) {
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3d& bearing : run.camera.grid) {
    const Eigen::Vector3d direction = X_WC.linear() * bearing;
    const double distance = first_hit(run.surfaces, X_WC.translation(), direction).value_or(kFar_m);
    points.push_back(X_WC.translation() + distance * direction);
  }
  return points;
}

// Returns when a point in view at `start` is in view again after the camera has been elsewhere.
std::optional<Stamp> return_to(const Run& run, const Eigen::Vector3d& p_W, Stamp start) {
  const auto in_view = [&](const TimedPose& pose, const Eigen::Vector3d& p) {
    return run.camera.project(pose.X, p).has_value();
  };
  const auto& poses = run.truth_camera;
  auto last_view = std::ranges::lower_bound(poses, start, {}, &TimedPose::t);
  std::vector<Eigen::Vector3d> view;  // from last_view; the point in view most recently is last
  Stamp out_since = start;
  bool was_elsewhere = false;
  for (auto pose = last_view; pose != poses.end(); ++pose) {
    if (in_view(*pose, p_W)) {
      if (was_elsewhere && pose->t - out_since > kOutOfView) return pose->t;
      last_view = pose, was_elsewhere = false;
      view.clear();
      continue;
    }
    if (pose == last_view + 1) out_since = pose->t;
    if (was_elsewhere) continue;
    if (view.empty()) view = view_from(run, last_view->X);
    const auto seen = std::ranges::find_if(view, [&](const auto& p) { return in_view(*pose, p); });
    was_elsewhere = seen == view.end();
    if (!was_elsewhere) std::iter_swap(seen, view.begin());  // probably still in view in the next frame
  }
  return std::nullopt;
}

std::optional<Stamp> first_match(const Run& run, const LandmarkHistory& landmark, const Eigen::Vector3d& p_W,
                                 Stamp from) {
  const auto found = std::ranges::find_if(landmark.accepted, [&](const StampedPixel& match) {
    const Eigen::Isometry3d* const X_WC = match.t >= from ? pose_at(run, match.t) : nullptr;
    const auto pixel = X_WC ? run.camera.project(*X_WC, p_W) : std::nullopt;
    return pixel && (*pixel - match.pixel).norm() <= kTolerance_px;
  });
  return found == landmark.accepted.end() ? std::nullopt : std::optional(found->t);
}

using Eigen::Vector3d;

constexpr double kTouch = 0.01, kCarries = 0.4;   // fractions of the weight
constexpr std::chrono::milliseconds kBounce{30};  // shorter lifts do not count

// The vectors below are poses on the ground: x, y, yaw.
Vector3d difference(const Vector3d& a, const Vector3d& b) {
  return {a.x() - b.x(), a.y() - b.y(), std::remainder(a.z() - b.z(), 2 * std::numbers::pi)};
}
Vector3d product(const Vector3d& a, const Vector3d& b) {
  const double c = std::cos(a.z()), s = std::sin(a.z());
  return {a.x() + c * b.x() - s * b.y(), a.y() + s * b.x() + c * b.y(), a.z() + b.z()};
}
// Returns the pose of p after the motion from `from` to `to`.
Vector3d carried(const Vector3d& p, const Vector3d& from, const Vector3d& to) {
  const double c = std::cos(from.z()), s = std::sin(from.z());
  const Vector3d inverse(-c * from.x() - s * from.y(), s * from.x() - c * from.y(), -from.z());
  return product(product(to, inverse), p);
}

/// The samples of a foot on the ground, up to but not including `end`, and its planned place.
struct Stance {
  bool left = false;
  std::size_t begin = 0, end = 0;
  Vector3d plan = Vector3d::Zero();
  std::size_t carries = 0, carried = 0;  // first, and one past last, sample carrying enough weight
};

class DriftDecomposition {
 public:
  DriftDecomposition(const std::vector<TrueFeet>& samples, double weight_n, const Vector3d& waist_truth,
                     const Vector3d& waist_plan)
      : samples_(samples),
        last_(samples.size() - 1),
        weight_n_(weight_n),
        waist_truth_(waist_truth),
        waist_plan_(waist_plan) {}

  std::vector<FootRow> rows() {
    std::vector<Stance> all;
    for (const bool left : {true, false}) add_stances(left, all);
    std::ranges::stable_sort(all, {}, &Stance::begin);
    find_anchors(all);
    add_jumps();
    for (const Stance& stance : all) {
      add(stance, FootPhase::landing, stance.begin, stance.carries);
      add(stance, FootPhase::support, stance.carries, stance.carried);
      add(stance, FootPhase::lift_off, std::max(stance.carries, stance.carried), stance.end);
    }
    std::ranges::stable_sort(rows_, {}, &FootRow::begin);
    return rows_;
  }

 private:
  // Successive stances carry the robot's motion, each starting at sample `from`.
  struct Anchor {
    Stance stance;
    std::size_t from = 0;
  };

  const TrueFoot& at(bool left, std::size_t i) const { return left ? samples_[i].left : samples_[i].right; }
  double load(bool left, std::size_t i) const { return at(left, i).load_n / weight_n_; }

  /// Returns the final waist if everything follows the plan after sample i, as seen from the stance foot.
  Vector3d end_seen_from(const Stance& stance, std::size_t i) const {
    return carried(waist_plan_, stance.plan, at(stance.left, i).truth);
  }

  /// Returns the contact as a stance, or nothing if the foot only scuffs the ground in mid-swing.
  std::optional<Stance> stance(bool left, std::size_t begin, std::size_t end) const {
    Stance found{left, begin, end, Vector3d::Zero(), end, end};
    bool planned = false;
    for (std::size_t i = begin; i < end; ++i) {
      const TrueFoot& sample = at(left, i);
      if (sample.planned_down && !planned) found.plan = sample.plan;
      planned |= sample.planned_down;
      if (load(left, i) < kCarries) continue;
      if (found.carries == end) found.carries = i;
      found.carried = i + 1;
    }
    if (begin == 0) found.carries = 0;
    if (!planned) return std::nullopt;
    return found;
  }

  void add_stances(bool left, std::vector<Stance>& all) const {
    for (std::size_t i = 0; i <= last_; ++i) {
      if (i != 0 && load(left, i) <= kTouch) continue;
      std::size_t end = i + 1;  // after the contact's last sample
      for (std::size_t k = end; k <= last_ && samples_[k].t - samples_[end - 1].t <= kBounce; ++k)
        if (load(left, k) > kTouch) end = k + 1;
      if (const auto found = stance(left, i, end)) all.push_back(*found);
      i = end - 1;
    }
  }

  /// Between two landings, the foot that does not land next stands the whole time, so the robot's motion is
  /// relative to it.
  void find_anchors(const std::vector<Stance>& landings) {
    for (std::size_t k = 0; k < landings.size(); ++k) {
      const bool last = k + 1 == landings.size(), begins = landings[k].begin == 0;
      if (begins && !last && landings[k + 1].begin == 0) continue;
      if (last || landings[k + 1].left != landings[k].left) {
        anchors_.push_back({landings[k], landings[k].begin});
      } else if (begins && k > 0) {
        anchors_.push_back({landings[k - 1], 0});
      }
    }
  }

  void add(const Stance& stance, FootPhase phase, std::size_t begin, std::size_t end) {
    if (begin >= end) return;
    const std::size_t last = std::min(end, last_);
    FootRow row{samples_[begin].t, samples_[last].t, stance.left, phase};
    row.moved = difference(at(stance.left, last).truth, at(stance.left, begin).truth);
    for (std::size_t i = begin + 1; i <= last; ++i) row.creep += at(stance.left, i).creep;
    for (std::size_t k = 0; k < anchors_.size(); ++k) {
      if (anchors_[k].stance.left != stance.left || anchors_[k].stance.begin != stance.begin) continue;
      const std::size_t until = k + 1 < anchors_.size() ? anchors_[k + 1].from : last_;
      const std::size_t from = std::max(begin, anchors_[k].from), to = std::min(last, until);
      if (from < to) row.drift += difference(end_seen_from(stance, to), end_seen_from(stance, from));
    }
    rows_.push_back(row);
  }

  /// Adds the start, each landing error, and the body over the last foot.
  void add_jumps() {
    if (anchors_.empty()) return;
    const auto jump = [&](FootPhase phase, bool left, std::size_t i, const Vector3d& drift,
                          const Vector3d& moved) {
      rows_.push_back({samples_[i].t, samples_[i].t, left, phase, moved, Vector3d::Zero(), drift});
    };
    const Stance &first = anchors_.front().stance, &end = anchors_.back().stance;
    const Vector3d start = difference(end_seen_from(first, 0), waist_plan_),
                   body = difference(waist_truth_, end_seen_from(end, last_));
    jump(FootPhase::start, first.left, 0, start, start);
    for (std::size_t k = 1; k < anchors_.size(); ++k) {
      const auto& [stance, from] = anchors_[k];
      const Stance& before = anchors_[k - 1].stance;
      const Vector3d wanted = carried(stance.plan, before.plan, at(before.left, from).truth);
      jump(FootPhase::put_down, stance.left, from,
           difference(end_seen_from(stance, from), end_seen_from(before, from)),
           difference(at(stance.left, from).truth, wanted));
    }
    jump(FootPhase::body, end.left, last_, body, body);
  }

  const std::vector<TrueFeet>& samples_;
  std::size_t last_;
  double weight_n_;
  Vector3d waist_truth_, waist_plan_;
  std::vector<Anchor> anchors_;
  std::vector<FootRow> rows_;
};

}  // namespace

OrAbsent<std::vector<LoopLandmark>> loop_landmarks(const Run& run) {
  if (run.surfaces.empty()) return Absent{"the surfaces of the room are unknown"};
  std::vector<LoopLandmark> all;
  bool returned = false;
  for (const LandmarkHistory& landmark : run.landmarks) {
    const auto p_W = surface_point(run, landmark.first_seen);
    const auto back = p_W ? return_to(run, *p_W, landmark.first_seen.t) : std::nullopt;
    returned = returned || back;
    const auto found = back ? first_match(run, landmark, *p_W, *back) : std::nullopt;
    if (found) all.push_back({landmark.id, *found});
  }
  if (!returned) return Absent{"the camera never returned to a landmark after it had been elsewhere"};
  std::ranges::stable_sort(all, {}, &LoopLandmark::found);
  return all;
}

double moving_fraction(const Run& run, const Eigen::Isometry3d& X_WC, Stamp t) {
  const std::vector<Surface> actors = run.actors(t);
  const auto moving = std::ranges::count_if(run.camera.grid, [&](const Eigen::Vector3d& bearing) {
    return shows(actors, run, X_WC.translation(), X_WC.linear() * bearing);
  });
  return double(moving) / double(run.camera.grid.size());
}

std::optional<double> moving_landmarks_fraction(const Run& run) {
  double known = 0, moving = 0;
  for (const LandmarkHistory& landmark : run.landmarks)
    if (const auto on_actor = shows_actor(run, landmark.first_seen)) ++known, moving += *on_actor;
  return known > 0 ? std::optional(moving / known) : std::nullopt;
}

std::vector<double> landmark_errors(const Run& run) {
  std::vector<double> errors;
  for (const MappedPoint& point : run.map) {
    const auto history = std::ranges::find(run.landmarks, point.id, &LandmarkHistory::id);
    if (history == run.landmarks.end()) continue;
    if (const auto p_W = surface_point(run, history->first_seen)) errors.push_back((*p_W - point.p_W).norm());
  }
  return errors;
}

Vector3d ground_pose(const Eigen::Isometry3d& X) {
  return {X.translation().x(), X.translation().y(), std::atan2(X.linear()(1, 0), X.linear()(0, 0))};
}

std::vector<FootRow> decompose_drift(const std::vector<TrueFeet>& samples, double weight_n,
                                     const Vector3d& waist_truth, const Vector3d& waist_plan) {
  return DriftDecomposition(samples, weight_n, waist_truth, waist_plan).rows();
}

}  // namespace sim::score
