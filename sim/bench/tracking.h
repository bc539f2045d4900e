// The filter's side of a run, live or replayed: ideal observations in, what the filter made of them out.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "sim/bench/estimators.h"
#include "sim/bench/scenario.h"
#include "sim/stream/sensor_errors.h"
#include "slam/filter.h"

namespace sim::bench {

/// What the filter believed after a frame, and what it did in it.
struct TrackedFrame {
  slam::Estimate estimate;
  slam::FrameReport report;
};

/// A time over which tracking was lost.
struct Loss {
  slam::Stamp from{0};
  std::optional<slam::Stamp> to;  ///< absent where it was not found again
  std::string cause;
};

/// The map at a time.
struct TimedMap {
  slam::Stamp t{0};
  std::vector<slam::MapPoint> points;
};

/// All that a filter left behind.
struct Tracked {
  std::vector<TrackedFrame> frames;  ///< up to and including the one in which it diverged, if it did
  std::vector<slam::MapPoint> map;   ///< at the end
  std::vector<TimedMap> maps;        ///< second by second
  /// It found itself broken, or was still lost when the run ended.
  bool diverged() const;
  const std::string& cause() const;  ///< of the divergence
  /// The estimates, each once: a refused observation makes no new one.
  std::vector<slam::Estimate> estimates() const;
  std::vector<Loss> losses() const;
};

/// Sensor errors, then the filter or the estimator that the scenario names: the same for a live run and a
/// replay, so that both give the same bits.
class Tracking {
 public:
  /// The scenario must have a slam section.
  Tracking(const Scenario& scenario, const slam::Calibration& calibration,
           const Eigen::Isometry3d& X_WC_start);

  /// Applies the scenario's sensor errors to an ideal observation and gives the filter what arrives with it.
  /// A filter that has diverged is given no more.
  void take(slam::Observation ideal);

  /// Gives the filter what arrived, errors applied already.
  void step(const slam::Observation& arrived);

  /// In the filter's map after the last observation.
  int landmarks() const { return tracked_.frames.empty() ? 0 : tracked_.frames.back().report.landmarks; }

  /// Gives the filter what was still under way, ends the tracking and hands out what came of it.
  Tracked finish();

 private:
  stream::SensorErrors errors_;
  slam::Filter filter_;
  Estimator other_;  ///< in the filter's place; empty where the filter runs
  Tracked tracked_;
};

}  // namespace sim::bench
