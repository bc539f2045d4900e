// Errors of the motion sensors on their way to the filter: gyro, accelerometer, leg odometry, plan and clock.
#pragma once

#include <cstdint>
#include <deque>
#include <string>

#include "sim/sensor_errors/faults.h"

namespace sim::sensor_errors {

/// The errors of one inertial sensor, per axis, in its own unit (rad/s or m/s²).
struct InertialErrorSizes {
  double sigma = 0;            ///< white noise of a 200 Hz reading
  double bias_sigma = 0;       ///< of the bias at the start, drawn once per run
  double bias_walk_sigma = 0;  ///< growth of the bias's standard deviation in 1 s
  double range = 0;            ///< readings beyond ±range are ±range; 0: none are
  double resolution = 0;       ///< readings are whole multiples of it; 0: they are not rounded

  /// Its keys, whose names end in the unit of a reading, that of the walk in the reading's unit per s.
  static void keys(auto&& key, const std::string& sensor, const std::string& unit, const char* unit_per_s) {
    const auto add = [&](const std::string& name, double InertialErrorSizes::*size, const std::string& doc) {
      key.number(name, size, 0, 1e3, doc.c_str());
    };
    add("sigma_" + unit, &InertialErrorSizes::sigma, "white noise of a 200 Hz " + sensor + " reading");
    add("bias_sigma_" + unit, &InertialErrorSizes::bias_sigma,
        "standard deviation of the " + sensor + "'s bias at the start over seeds");
    add(std::string("bias_walk_sigma_") + unit_per_s, &InertialErrorSizes::bias_walk_sigma,
        "random walk of the " + sensor + "'s bias: growth of its standard deviation in 1 s");
    add("range_" + unit, &InertialErrorSizes::range, "saturation limit of " + sensor + " readings; 0: none");
    add("resolution_" + unit, &InertialErrorSizes::resolution,
        "quantization step of " + sensor + " readings; 0: they are not rounded");
  }
};

/// One sensor. Draws are keyed by seed, the sensor's name and the reading's stamp.
class InertialErrors {
 public:
  struct Spike {
    Span span;
    double size = 0;
  };
  InertialErrors(std::string sensor, const InertialErrorSizes& sizes, std::uint64_t seed,
                 std::vector<Spike> spikes, std::vector<Span> silences);

  /// Readings must come in order of time, also from call to call.
  void apply(std::vector<slam::InertialSample>& readings);

 private:
  Eigen::Vector3d disturbed(const slam::InertialSample& reading);

  std::string sensor_;
  InertialErrorSizes sizes_;
  std::uint64_t seed_;
  std::vector<Spike> spikes_;
  std::vector<Span> silences_;
  Eigen::Vector3d bias_;
};

/// Errors of leg odometry, applied to one frame after another. sigma_m: white noise of each frame's position,
/// per axis, drawn by seed and stamp. scale_fraction: relative error of the distances.
class LegErrors {
 public:
  LegErrors(double sigma_m, double scale_fraction, std::uint64_t seed)
      : sigma_m_(sigma_m), scale_fraction_(scale_fraction), seed_(seed) {}
  void apply(slam::LegMotion& legs, slam::Stamp t);

 private:
  double sigma_m_, scale_fraction_;
  std::uint64_t seed_;
  std::optional<Eigen::Vector3d> first_p_OC_;
};

/// Faults of the planned motion, applied to one observation after another.
class PlanErrors {
 public:
  explicit PlanErrors(const std::vector<Fault>& faults)
      : missing_(faults_of<PlanMissing>(faults)), scaled_(faults_of<PlanScaled>(faults)) {}
  std::optional<slam::PlannedMotion> apply(std::optional<slam::PlannedMotion> plan, slam::Stamp t);

 private:
  std::vector<PlanMissing> missing_;
  std::vector<PlanScaled> scaled_;
  std::optional<Eigen::Vector3d> last_p_PC_;                    // as planned
  Eigen::Vector3d position_error_P_ = Eigen::Vector3d::Zero();  // accumulated so far
};

/// A motion computer with an offset clock. Assembles the observations of the vision computer, by its stamps.
class MotionClock {
 public:
  /// offset: stamps of the motion computer minus those of the vision computer at the same time.
  explicit MotionClock(slam::Stamp offset) : offset_(offset) {}

  /// Adds an observation with true stamps and returns the complete ones: if the clock is behind, frames wait
  /// for their motion. Readings across a frame are split; the plan is interpolated.
  std::vector<slam::Observation> process(slam::Observation observation);

  /// Returns the waiting frames with the motion known so far.
  std::vector<slam::Observation> flush();

 private:
  struct StampedPlan {
    slam::Stamp t{0};
    std::optional<slam::PlannedMotion> plan;
  };
  slam::Observation assembled();
  std::optional<slam::PlannedMotion> plan_at(slam::Stamp t);

  slam::Stamp offset_;
  std::deque<slam::Observation> waiting_;
  std::deque<slam::InertialSample> gyro_, accelerometer_;
  std::deque<slam::BodyReading> body_;
  std::deque<StampedPlan> plans_;
};

}  // namespace sim::sensor_errors
