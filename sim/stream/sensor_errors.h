// What turns the readings of ideal sensors into what the filter is given: noise, bias and loss from named
// streams.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "slam/observation.h"

namespace sim::stream {

/// The scenario's keys errors.*, name for name. All standard deviations >= 0, all fractions in [0, 1].
struct ErrorOptions {
  struct Gyro {
    double sigma_rad_s = 0.01;      ///< white noise of a 200 Hz reading, per axis
    double bias_sigma_rad_s = 0.0;  ///< of the constant bias, drawn once per run, per axis
  } gyro;
  struct Accelerometer {
    double sigma_m_s2 = 0.05;      ///< white noise of a 200 Hz reading, per axis
    double bias_sigma_m_s2 = 0.0;  ///< of the constant bias, drawn once per run, per axis
  } accelerometer;
  struct Image {
    double read_sigma_grey = 1.0;  ///< noise of a black pixel, grey levels of 255; at most 100
    double shot_sigma_grey =
        1.0;  ///< noise of a white pixel from counting light alone; its square goes with the grey
    double loss_fraction = 0.0;  ///< of frames whose image does not arrive
  } image;
  struct Plan {
    double loss_fraction = 0.0;  ///< of frames whose planned motion does not arrive
  } plan;
};

/// Applies the errors to one observation after another. Every draw is keyed by the run's seed, the name of
/// its stream and the stamp it belongs to: a live run and a replay agree bit for bit, and one error's numbers
/// do not depend on which others are switched on.
class SensorErrors {
 public:
  /// Throws std::invalid_argument naming the option that is out of its range.
  SensorErrors(const ErrorOptions& options, std::uint64_t seed);

  /// `ideal`'s pixels are not written to: a noisy image is a new one.
  slam::Observation apply(slam::Observation ideal) const;

 private:
  void apply_white_noise(std::vector<slam::InertialSample>& readings, const char* stream, double sigma,
                         const Eigen::Vector3d& bias) const;
  cv::Mat noisy(const cv::Mat& image, slam::Stamp t) const;
  bool lost(const char* stream, slam::Stamp t, double fraction) const;

  ErrorOptions options_;
  std::uint64_t seed_;
  Eigen::Vector3d gyro_bias_, accelerometer_bias_;
  std::vector<int> sigma_of_grey_;  // 256 entries, in 1/256 grey
};

}  // namespace sim::stream
