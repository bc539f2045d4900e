#include "sim/score/scored.h"

namespace sim::score {
namespace {

constexpr double kFirstMotion_m = 0.001;

std::optional<Stamp> first_motion(const Trajectory& plan_waist) {
  for (const StampedPose& pose : plan_waist)
    if ((pose.X.translation() - plan_waist.front().X.translation()).norm() > kFirstMotion_m) return pose.t;
  return std::nullopt;
}

Trajectory from(Stamp begin, const Trajectory& all) {
  Trajectory rest;
  for (const StampedPose& pose : all)
    if (pose.t >= begin) rest.push_back(pose);
  return rest;
}

Trajectory poses(const std::vector<EstimatedPose>& estimate) {
  Trajectory all;
  for (const EstimatedPose& pose : estimate) all.push_back({pose.t, pose.X_WC});
  return all;
}

std::string why_no_estimate(const Scored& s) {
  if (!s.run.estimate) return "the filter was not run";
  if (s.run.failed) return "the estimator failed: " + *s.run.failed;
  if (s.run.diverged) return "the filter diverged: " + *s.run.diverged;
  if (!s.begin) return s.run.plan_waist.empty() ? "there is no truth" : "the plan never moves";
  if (s.pairs.empty()) return "no estimate has the stamp of a true pose";
  return "";
}

// Of the pairs' estimates, up to the first without, and why that one has none.
std::vector<PoseNees> nees_of(const std::vector<PosePair>& pairs, const Run& run, std::string& why_none) {
  std::vector<PoseNees> all;
  if (pairs.empty()) return all;
  auto pose = run.estimate->begin();
  for (const PosePair& pair : pairs) {
    while (pose->t != pair.t) ++pose;
    if (!pose->covariance) {
      why_none = "the estimator states no covariance";
      break;
    }
    const auto nees = pose_nees(pair.X_true, pair.X_estimate, *pose->covariance);
    if (!nees) {
      why_none = "a covariance of the estimate is not positive definite";
      break;
    }
    all.push_back(*nees);
  }
  return all;
}

}  // namespace

Scored::Scored(const Run& run_) : run(run_), begin(first_motion(run_.plan_waist)) {
  if (run.plan_waist.empty() && !run.truth_camera.empty()) begin = run.truth_camera.front().t;
  if (begin) truth_camera = from(*begin, run.truth_camera);
  if (begin && run.estimate) estimate = from(*begin, poses(*run.estimate));
  pairs = pair_by_stamp(truth_camera, estimate);
  nees = nees_of(pairs, run, no_nees);
  no_estimate = no_loop = why_no_estimate(*this);
  // Corrections turn the plan of a steered walk; its commands turn as often as the robot.
  const auto marks = turn_marks(run.steered && run.desired ? run.desired->waist : run.plan_waist);
  if (no_loop.empty() && !marks) no_loop = "what was walked of the plan turns by less than 350 degrees";
  if (no_loop.empty() && run.surfaces.empty()) no_loop = "the surfaces of the room are not known";
  if (no_loop.empty())
    loop = loop_landmarks(run.landmarks, *marks, run.truth_camera, run.surfaces, run.camera);
}

}  // namespace sim::score
