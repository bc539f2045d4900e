// Tracking in a run, live or replayed: ideal observations in, estimates and reports of the filter out.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/estimators/estimators.h"
#include "sim/scenario/scenario.h"
#include "sim/sensor_errors/sensor_errors.h"
#include "slam/filter.h"

namespace sim::tracking {

/// The estimate after a frame, and the filter's report of it; of another estimator its health alone.
struct TrackedFrame {
  estimators::PoseEstimate estimate;
  slam::FrameReport report;
};

/// A time over which tracking was lost, or a sensor was suspect.
struct TrackingFault {
  slam::Stamp from{0};
  std::optional<slam::Stamp> to;  ///< absent where it did not end
  std::string cause;
};

/// The map at a time.
struct TimedMap {
  slam::Stamp t{0};
  std::vector<slam::MapPoint> points;
};

/// All that a filter or another estimator gave in a run.
struct Tracked {
  std::vector<TrackedFrame> frames;  ///< up to and including the one in which it diverged, if it did
  std::vector<slam::MapPoint> map;   ///< at the end
  std::vector<TimedMap> maps;        ///< one each second
  std::vector<slam::Stamp>
      after_divergence;  ///< of the observations that it was not given any more, or failed at
  std::optional<std::string> failed = {};  ///< why it failed as a program: it crashed, hung or gave no answer
  std::string log = {};                    ///< what an estimator outside wrote to its standard error
  /// The filter diverged, or was still lost when the run ended.
  bool diverged() const;
  std::string cause() const;  ///< of the divergence
  /// The estimates, each once: a refused observation makes no new one.
  std::vector<estimators::PoseEstimate> estimates() const;
  std::vector<TrackingFault> losses() const;
  /// When a sensor contradicted all others; the cause is the last one of each time. Where several sensors
  /// were suspect in turns, it names each with its share of the frames.
  std::vector<TrackingFault> suspicions() const;
};

/// Sensor errors, then the filter or the estimator that the scenario names: the same for a live run and a
/// replay, so that both give the same bits.
class Tracking {
 public:
  /// The scenario must have a slam section. Throws std::invalid_argument where a program or library that is
  /// to be the estimator cannot be started at all.
  Tracking(const scenario::Scenario& scenario, const slam::Calibration& calibration,
           const Eigen::Isometry3d& X_WC_start);

  /// The same with an estimator in the place of the one that the scenario names.
  Tracking(const scenario::Scenario& scenario, const slam::Calibration& calibration,
           const Eigen::Isometry3d& X_WC_start, estimators::Estimator estimator);

  /// Applies the scenario's sensor errors to an ideal observation and gives the filter what arrives by then.
  /// A filter that has diverged and an estimator that has failed get no more observations.
  void take(slam::Observation ideal);

  /// Gives the filter an observation to which sensor errors are already applied.
  void step(const slam::Observation& arrived);

  /// The newest frame; nullptr before the first.
  const TrackedFrame* newest() const { return tracked_.frames.empty() ? nullptr : &tracked_.frames.back(); }

  /// The estimator has failed; its newest frame is the last that it answered.
  bool failed() const { return tracked_.failed.has_value(); }

  /// CPU time (ms) that answers took in another process since the last call.
  double take_outside_cpu_ms() { return std::exchange(outside_cpu_ms_, 0); }

  /// In the filter's map after the last observation.
  int landmarks() const { return tracked_.frames.empty() ? 0 : tracked_.frames.back().report.landmarks; }

  /// The map after the last observation; of another estimator the newest that it told.
  std::vector<slam::MapPoint> map() const { return estimator_.step ? tracked_.map : filter_.map(); }

  /// Gives the filter the observations that are still delayed, ends the tracking and returns its result.
  Tracked finish();

 private:
  void step_filter(const slam::Observation& arrived);
  void step_estimator(const slam::Observation& arrived);
  void keep_map(slam::Stamp t, std::vector<slam::MapPoint> map);
  template <class Action>
  void guarded(const Action& action);

  sensor_errors::SensorErrors errors_;
  slam::Filter filter_;
  estimators::Estimator estimator_;  ///< in the filter's place; without a step where the filter runs
  slam::Stamp newest_{0};            ///< of the observations that the estimator was given
  double outside_cpu_ms_ = 0;
  Tracked tracked_;
};

}  // namespace sim::tracking
