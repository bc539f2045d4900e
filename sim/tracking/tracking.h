// Tracking in a run, live or replayed: ideal observations in, estimates and reports of the filter out.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "sim/estimators/estimators.h"
#include "sim/scenario/scenario.h"
#include "sim/sensor_errors/sensor_errors.h"
#include "slam/filter.h"

namespace sim::tracking {

/// The estimate after a frame, and the filter's report of it.
struct TrackedFrame {
  slam::Estimate estimate;
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

/// All that a filter gave in a run.
struct Tracked {
  std::vector<TrackedFrame> frames;  ///< up to and including the one in which it diverged, if it did
  std::vector<slam::MapPoint> map;   ///< at the end
  std::vector<TimedMap> maps;        ///< one each second
  std::vector<slam::Stamp> after_divergence;  ///< of the observations that it was not given any more
  /// The filter diverged, or was still lost when the run ended.
  bool diverged() const;
  const std::string& cause() const;  ///< of the divergence
  /// The estimates, each once: a refused observation makes no new one.
  std::vector<slam::Estimate> estimates() const;
  std::vector<TrackingFault> losses() const;
  /// When a sensor contradicted all others; the cause is that of the last frame of each time.
  std::vector<TrackingFault> suspicions() const;
};

/// Sensor errors, then the filter or the estimator that the scenario names: the same for a live run and a
/// replay, so that both give the same bits.
class Tracking {
 public:
  /// The scenario must have a slam section.
  Tracking(const scenario::Scenario& scenario, const slam::Calibration& calibration,
           const Eigen::Isometry3d& X_WC_start);

  /// Applies the scenario's sensor errors to an ideal observation and gives the filter what arrives by then.
  /// A filter that has diverged gets no more observations.
  void take(slam::Observation ideal);

  /// Gives the filter an observation to which sensor errors are already applied.
  void step(const slam::Observation& arrived);

  /// The newest frame; nullptr before the first.
  const TrackedFrame* newest() const { return tracked_.frames.empty() ? nullptr : &tracked_.frames.back(); }

  /// In the filter's map after the last observation.
  int landmarks() const { return tracked_.frames.empty() ? 0 : tracked_.frames.back().report.landmarks; }

  /// Gives the filter the observations that are still delayed, ends the tracking and returns its result.
  Tracked finish();

 private:
  sensor_errors::SensorErrors errors_;
  slam::Filter filter_;
  estimators::Estimator estimator_;  ///< in the filter's place; empty where the filter runs
  Tracked tracked_;
};

}  // namespace sim::tracking
