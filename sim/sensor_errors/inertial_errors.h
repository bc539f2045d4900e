// Errors of a gyro or an accelerometer: noise, bias, range, resolution, spikes and dropout.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/sensor_errors/faults.h"
#include "slam/observation.h"

namespace sim::sensor_errors {

/// The errors of one sensor, per axis, in its own unit (rad/s or m/s²).
struct InertialErrorSizes {
  double sigma = 0;            ///< white noise of a 200 Hz reading
  double bias_sigma = 0;       ///< of the bias at the start, drawn once per run
  double bias_walk_sigma = 0;  ///< growth of the bias's standard deviation in 1 s
  double range = 0;            ///< readings beyond ±range are ±range; 0: none are
  double resolution = 0;       ///< readings are whole multiples of it; 0: they are not rounded
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

}  // namespace sim::sensor_errors
