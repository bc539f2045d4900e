// One run scored: everything that is known of it in, all metrics with units and reasons out.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/score/consistency.h"
#include "sim/score/feet.h"
#include "sim/score/landmark_accuracy.h"
#include "sim/score/loop_closure.h"
#include "sim/score/statistics.h"
#include "sim/score/surfaces.h"
#include "sim/score/trajectory.h"

namespace sim::score {

/// Where the filter believed the camera was. covariance: see pose_nees.
struct EstimatedPose {
  Stamp t{0};
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Identity();
};

/// The sensors whose innovations are scored, in the order of Run::innovations.
inline constexpr std::array kSensors{std::string_view("vision"), std::string_view("gyro"),
                                     std::string_view("plan_velocity"), std::string_view("height")};

/// One sensor's innovation in the frame of that time.
struct StampedInnovation {
  Stamp t{0};
  Innovation innovation;
};

/// What the plan as a whole says of time: when it ends, and when feet come down.
struct PlannedTimes {
  Stamp end{0};
  std::vector<Stamp> footsteps;
};

/// Everything that is scored, at the stamps of the frames. W is the plan's world P at t = 0.
struct Run {
  Trajectory truth_camera, plan_camera;                ///< X_WC, X_PC
  Trajectory truth_waist, plan_waist;                  ///< X_WB, X_PB
  std::vector<FootRow> feet;                           ///< the account of the feet, see account()
  std::optional<std::vector<EstimatedPose>> estimate;  ///< absent: the filter was not run
  std::array<std::vector<StampedInnovation>, kSensors.size()> innovations;
  std::vector<LandmarkHistory> landmarks;
  std::vector<MappedPoint> map;  ///< at the end
  std::vector<Surface> surfaces;
  TrueCamera camera;
  std::optional<PlannedTimes> planned;
  std::string no_scale = {};  ///< why the estimate's scale means nothing; empty if it does
  std::optional<std::string> diverged;  ///< the cause, if the filter gave up
};

/// A number with its unit ("1" for a count or a ratio), or the reason why there is none.
struct Metric {
  std::optional<double> value;
  std::string unit;
  std::string reason;  ///< of a value's absence
};
using Metrics = std::map<std::string, Metric, std::less<>>;

/// What a metric is, in words: for the README, for --help, for reports.
struct MetricDefinition {
  std::string name, unit, definition;
  Worst worst = Worst::largest;  ///< which of several seeds is the worst
  bool headline = false;         ///< in the short table too
};
/// All metrics in the order in which they are to be shown.
const std::vector<MetricDefinition>& metric_definitions();
/// The one of that name, or nullptr.
const MetricDefinition* find_metric(std::string_view name);

struct Scored;

/// All metrics of metric_definitions(), each with a value or a reason.
Metrics evaluate(const Run& run);
Metrics evaluate(const Scored& scored);

}  // namespace sim::score
