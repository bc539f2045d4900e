// Readings of ideal sensors become the filter's input, with errors and faults from named random streams.
#pragma once

#include "sim/rig/rig.h"
#include "sim/sensor_errors/image_errors.h"
#include "sim/sensor_errors/motion_errors.h"
#include "sim/sensor_errors/rig_errors.h"

namespace sim::sensor_errors {

/// The scenario's keys errors.*. Standard deviations are per axis; biases are drawn once per run.
struct ErrorOptions {
  struct Gyro {
    double sigma_rad_s = 0.01;
    double bias_sigma_rad_s = 0.0;
    double bias_walk_sigma_rad_s2 = 0;
    double range_rad_s = 0;
    double resolution_rad_s = 0;

    static void keys(auto&& key) {
      number<&Gyro::sigma_rad_s>(key, 0, 1e3, "white noise of a 200 Hz gyro reading");
      number<&Gyro::bias_sigma_rad_s>(key, 0, 1e3,
                                      "standard deviation of the gyro's bias at the start over seeds");
      number<&Gyro::bias_walk_sigma_rad_s2>(
          key, 0, 1e3, "random walk of the gyro's bias: growth of its standard deviation in 1 s");
      number<&Gyro::range_rad_s>(key, 0, 1e3, "saturation limit of gyro readings; 0: none");
      number<&Gyro::resolution_rad_s>(key, 0, 1e3,
                                      "quantization step of gyro readings; 0: they are not rounded");
    }
  } gyro;
  struct Accelerometer {
    double sigma_m_s2 = 0.05;
    double bias_sigma_m_s2 = 0.0;
    double bias_walk_sigma_m_s3 = 0;
    double range_m_s2 = 0;
    double resolution_m_s2 = 0;

    static void keys(auto&& key) {
      number<&Accelerometer::sigma_m_s2>(key, 0, 1e3, "white noise of a 200 Hz accelerometer reading");
      number<&Accelerometer::bias_sigma_m_s2>(
          key, 0, 1e3, "standard deviation of the accelerometer's bias at the start over seeds");
      number<&Accelerometer::bias_walk_sigma_m_s3>(
          key, 0, 1e3, "random walk of the accelerometer's bias: growth of its standard deviation in 1 s");
      number<&Accelerometer::range_m_s2>(key, 0, 1e3, "saturation limit of accelerometer readings; 0: none");
      number<&Accelerometer::resolution_m_s2>(
          key, 0, 1e3, "quantization step of accelerometer readings; 0: they are not rounded");
    }
  } accelerometer;
  ImageOptions image;
  double plan_loss_fraction = 0;
  struct LegOdometry {
    double sigma_m = 1e-4;
    double scale_fraction = 0;

    static void keys(auto&& key) {
      number<&LegOdometry::sigma_m>(
          key, 0, 1e3, "white noise of each frame's position by leg odometry, of encoders and force sensors");
      number<&LegOdometry::scale_fraction>(
          key, -1, 1, "error of the distances by leg odometry, relative to the true ones");
    }
  } leg_odometry;
  double motion_time_offset_s = 0, calibration_distortion_fraction = 0;
  std::vector<Fault> faults;

  static void keys(auto&& key) {
    part<&ErrorOptions::gyro, &ErrorOptions::accelerometer, &ErrorOptions::image>(key);
    key.number("plan.loss_fraction", &ErrorOptions::plan_loss_fraction, 0, 1,
               "fraction of the frames that lose their planned motion");
    part<&ErrorOptions::leg_odometry>(key);
    key.number("motion.time_offset_s", &ErrorOptions::motion_time_offset_s, -1, 1,
               "time offset of the motion computer's clock, which stamps readings and plan, ahead of the "
               "camera's");
    key.number("calibration.distortion_fraction", &ErrorOptions::calibration_distortion_fraction, -1, 1,
               "error of the lens distortion that the filter assumes, relative to the true one");
    value<&ErrorOptions::faults>(key, "temporary faults of the sensors and of the plan");
  }
};

/// Applies the errors to one observation after another, from the first of a run. Every draw is keyed by seed,
/// stream name and stamp: live run and replay agree bit for bit, and no error changes another's numbers.
class SensorErrors {
 public:
  /// rig: the further sensors of the observations.
  SensorErrors(const ErrorOptions& options, std::uint64_t seed, const std::vector<rig::RigSensor>& rig = {});

  /// Returns what reaches the filter after this ideal observation, in order. Does not write to its pixels.
  std::vector<slam::Observation> process(slam::Observation ideal);

  /// Returns the observations that have not arrived at the end of the run.
  std::vector<slam::Observation> flush();

 private:
  /// Appends what arrives after this observation: some twice, some after the next one, by seed and stamp.
  void arrive(slam::Observation observation, std::vector<slam::Observation>& arrived);
  template <class Kind>
  bool strikes(const char* stream, slam::Stamp t) const;
  cv::Mat received_image(const cv::Mat& ideal, slam::Stamp t);
  cv::Mat delayed_image(cv::Mat image, slam::Stamp t);
  bool lost(const char* stream, slam::Stamp t, double fraction) const;

  struct StampedImage {
    slam::Stamp t{0};
    cv::Mat image;
  };
  ErrorOptions options_;
  std::uint64_t seed_;
  RigErrors rig_;
  InertialErrors gyro_, accelerometer_;
  ImageErrors image_;
  PlanErrors plan_;
  LegErrors legs_;
  MotionClock motion_clock_;
  std::optional<slam::Observation> late_;
  cv::Mat last_unfrozen_;
  std::deque<StampedImage> delayed_;
};

}  // namespace sim::sensor_errors
