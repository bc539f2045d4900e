#include "sim/score/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/score/run.h"

namespace sim::score {
namespace {

constexpr double kFirstMotion_m = 0.001;

/// Beginnings of the metrics that compare orientations, or poses without alignment.
constexpr std::array kOfPoses{"rmse_m", "rotation_",  "rpe_",      "end_",  "drift_",
                              "nees_",  "poses_with", "landmark_", "plan_", "true_height_"};

std::optional<Stamp> first_motion(const Run& run) {
  if (run.plan_waist.empty() && !run.truth_camera.empty()) return run.truth_camera.front().t;
  for (const TimedPose& pose : run.plan_waist)
    if ((pose.X.translation() - run.plan_waist.front().X.translation()).norm() > kFirstMotion_m)
      return pose.t;
  return std::nullopt;
}

std::optional<Absent> why_no_estimate(const ScoreContext& c) {
  if (!c.run.estimate) return Absent{"the filter was not run"};
  if (c.run.failed) return Absent{"the estimator failed: " + *c.run.failed};
  if (c.run.diverged) return Absent{"the estimator diverged: " + *c.run.diverged};
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
  return loop_landmarks(run, *marks);
}

// "at 3.4 s, 8 % of 43.0 s" if the last moment is not the end of the plan and of the truth.
std::string note_of_end(const MetricDefinition& definition, const ScoreContext& context) {
  const Trajectory &camera = context.run.truth_camera, &waist = context.run.truth_waist;
  const bool of_walk = definition.needs == Needs::walk;
  if (camera.size() < 2 || (of_walk ? waist.empty() : context.pairs.empty())) return "";
  const Stamp last = of_walk ? waist.back().t : context.pairs.back().t, interval = camera[1].t - camera[0].t,
              end = std::max(context.run.plan_end.value_or(Stamp(0)), camera.back().t);
  if (last + 2 * interval >= end || last >= end / 100 * 99) return "";
  const double last_s = 1e-9 * static_cast<double>(last.count()),
               end_s = 1e-9 * static_cast<double>(end.count());
  return fmt::format("at {:.1f} s, {:.0f} % of {:.1f} s", last_s, 100 * last_s / end_s, end_s);
}

Metric compute(const MetricDefinition& definition, const ScoreContext& context) {
  const auto absent = [&](const std::string& reason) {
    return Metric{std::nullopt, definition.unit, reason};
  };
  const auto starts_name = [&](const char* beginning) { return definition.name.starts_with(beginning); };
  if (!context.run.truth_has_poses && std::ranges::any_of(kOfPoses, starts_name))
    return absent("the truth has positions only: see the errors after alignment, ate_...");
  if (definition.needs == Needs::scale && context.run.no_scale) return absent(*context.run.no_scale);
  if (definition.needs != Needs::walk && context.no_estimate) return absent(context.no_estimate->reason);
  const Value found = definition.compute(context);
  if (const auto* const none = std::get_if<Absent>(&found)) return absent(none->reason);
  const double number = std::get<double>(found);
  if (!std::isfinite(number)) return absent("the value is not finite");
  return {number, definition.unit, "", definition.at_end ? note_of_end(definition, context) : ""};
}

}  // namespace

ScoreContext::ScoreContext(const Run& run_) : run(run_), start(first_motion(run_)) {
  if (start)
    for (const TimedPose& pose : run.truth_camera)
      if (pose.t >= *start) truth_camera.push_back(pose);
  if (start && run.estimate)
    for (const files::TumRow& pose : *run.estimate)
      if (pose.t >= *start) estimate.push_back(pose);
  pairs = pair_by_stamp(truth_camera, estimate);
  nees = nees_of(pairs, run);
  no_estimate = why_no_estimate(*this);
  loop = loop_of(*this);
}

const MetricDefinitions& metric_definitions() {
  static const MetricDefinitions definitions = [] {
    MetricDefinitions all;
    for (const auto group : {estimate_metrics, walk_metrics, loop_metrics, consistency_metrics,
                             completion_metrics, timeliness_metrics})
      for (MetricDefinition& definition : group()) all.push_back(std::move(definition));
    return all;
  }();
  return definitions;
}

const MetricDefinition* find_metric(std::string_view name) {
  const auto& all = metric_definitions();
  const auto found = std::ranges::find(all, name, &MetricDefinition::name);
  return found == all.end() ? nullptr : &*found;
}

Direction direction_of(std::string_view name) {
  const MetricDefinition* defined = find_metric(name);
  return defined ? defined->direction : Direction();
}

Metrics evaluate(const Run& run) { return evaluate(ScoreContext(run)); }

Metrics evaluate(const ScoreContext& context) {
  Metrics metrics;
  for (const MetricDefinition& defined : metric_definitions())
    metrics.emplace(defined.name, compute(defined, context));
  return metrics;
}

}  // namespace sim::score
