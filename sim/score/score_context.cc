#include "sim/score/score_context.h"

namespace sim::score {
namespace {

constexpr double kFirstMotion_m = 0.001;

std::optional<Stamp> first_motion(const Run& run) {
  if (run.plan_waist.empty() && !run.truth_camera.empty()) return run.truth_camera.front().t;
  for (const TimedPose& pose : run.plan_waist)
    if ((pose.X.translation() - run.plan_waist.front().X.translation()).norm() > kFirstMotion_m)
      return pose.t;
  return std::nullopt;
}

Trajectory from(Stamp start, const Trajectory& all) {
  Trajectory rest;
  for (const TimedPose& pose : all)
    if (pose.t >= start) rest.push_back(pose);
  return rest;
}

Trajectory poses(const std::vector<EstimatedPose>& estimate) {
  Trajectory all;
  for (const EstimatedPose& pose : estimate) all.push_back({pose.t, pose.X_WC});
  return all;
}

std::optional<Absent> why_no_estimate(const ScoreContext& c) {
  if (!c.run.estimate) return Absent{"the filter was not run"};
  if (c.run.failed) return Absent{"the estimator failed: " + *c.run.failed};
  if (c.run.diverged) return Absent{"the filter diverged: " + *c.run.diverged};
  if (!c.start) return Absent{c.run.plan_waist.empty() ? "the run has no true pose" : "the plan never moves"};
  if (c.run.estimate->empty()) return Absent{"the estimator never tracked"};
  if (c.pairs.empty()) return Absent{"no estimate has the stamp of a true pose"};
  return std::nullopt;
}

OrAbsent<std::vector<PoseNees>> nees_of(const std::vector<PosePair>& pairs, const Run& run) {
  std::vector<PoseNees> all;
  if (pairs.empty()) return all;
  auto pose = run.estimate->begin();
  for (const PosePair& pair : pairs) {
    while (pose->t != pair.t) ++pose;
    if (!pose->covariance) continue;
    const auto nees = pose_nees(pair.X_true, pair.X_estimate, *pose->covariance);
    if (!nees) return Absent{"a covariance of the estimate is not positive definite"};
    all.push_back(*nees);
  }
  if (all.empty()) return Absent{"the estimator states no covariance"};
  return all;
}

OrAbsent<std::vector<LoopLandmark>> loop_of(const ScoreContext& c) {
  if (c.no_estimate) return *c.no_estimate;
  if (c.run.no_matches) return Absent{*c.run.no_matches};
  // Corrections turn the plan of a steered walk; its commands turn as often as the robot.
  const Run& run = c.run;
  const auto marks = turn_marks(run.steered && run.desired ? run.desired->waist : run.plan_waist);
  if (!marks) return Absent{"the executed part of the plan turns by less than 350 degrees"};
  if (run.surfaces.empty()) return Absent{"the surfaces of the room are not known"};
  return loop_landmarks(run.landmarks, *marks, run.truth_camera, run.surfaces, run.camera);
}

}  // namespace

ScoreContext::ScoreContext(const Run& run_) : run(run_), start(first_motion(run_)) {
  if (start) truth_camera = from(*start, run.truth_camera);
  if (start && run.estimate) estimate = from(*start, poses(*run.estimate));
  pairs = pair_by_stamp(truth_camera, estimate);
  nees = nees_of(pairs, run);
  no_estimate = why_no_estimate(*this);
  loop = loop_of(*this);
}

}  // namespace sim::score
