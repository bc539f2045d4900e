// What turns the readings of ideal sensors into what the filter is given: noise, bias, loss, wrong clocks and
// faults, drawn from named streams.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "sim/stream/arrival.h"
#include "sim/stream/faults.h"
#include "sim/stream/image_errors.h"
#include "sim/stream/inertial_errors.h"
#include "sim/stream/motion_clock.h"
#include "sim/stream/plan_errors.h"
#include "slam/observation.h"

namespace sim::stream {

/// The scenario's keys errors.*, name for name. All standard deviations >= 0, all fractions in [0, 1].
struct ErrorOptions {
  struct Gyro {
    double sigma_rad_s = 0.01;          ///< white noise of a 200 Hz reading, per axis
    double bias_sigma_rad_s = 0.0;      ///< of the bias at the start, drawn once per run, per axis
    double bias_walk_sigma_rad_s2 = 0;  ///< growth of the bias's standard deviation in 1 s
    double range_rad_s = 0;             ///< readings beyond are cut; 0: none are
    double resolution_rad_s = 0;        ///< step of the readings; 0: none
  } gyro;
  struct Accelerometer {  ///< likewise
    double sigma_m_s2 = 0.05;
    double bias_sigma_m_s2 = 0.0;
    double bias_walk_sigma_m_s3 = 0;
    double range_m_s2 = 0;
    double resolution_m_s2 = 0;
  } accelerometer;
  ImageOptions image;
  struct Plan {
    double loss_fraction = 0.0;  ///< of frames whose planned motion does not arrive
    double velocity_sigma_m_s =
        0.0;  ///< white error of each frame's planned velocity, along x and y of the plan's world
  } plan;
  struct Motion {
    double time_offset_s = 0;  ///< how much later the motion computer stamps than the vision computer
  } motion;
  std::vector<Fault> faults;
};

/// Applies the errors to one observation after another, from the first of a run. Every draw is keyed by the
/// run's seed, the name of its stream and the stamp it belongs to: a live run and a replay agree bit for bit,
/// and one error's numbers do not depend on which others are switched on.
class SensorErrors {
 public:
  /// Throws std::invalid_argument naming the option that is out of its range.
  SensorErrors(const ErrorOptions& options, std::uint64_t seed);

  /// What the filter is given once this ideal observation has been made: usually one, in the order of
  /// arrival. `ideal`'s pixels are not written to: a noisy image is a new one.
  std::vector<slam::Observation> take(slam::Observation ideal);

  /// What has not arrived when the run ends.
  std::vector<slam::Observation> rest();

 private:
  void disturb(slam::Observation& observation);
  cv::Mat arrived_picture(const cv::Mat& ideal, slam::Stamp t);
  cv::Mat late_picture(cv::Mat picture, slam::Stamp t);
  bool lost(const char* stream, slam::Stamp t, double fraction) const;

  struct StampedPicture {
    slam::Stamp t{0};
    cv::Mat picture;
  };
  ErrorOptions options_;
  std::uint64_t seed_;
  InertialErrors gyro_, accelerometer_;
  ImageErrors image_;
  PlanErrors plan_;
  MotionClock motion_clock_;
  Arrival arrival_;
  std::vector<FramesLost> frames_lost_;
  std::vector<FramesFrozen> frames_frozen_;
  cv::Mat before_freezing_;
  std::deque<StampedPicture> under_way_;
};

}  // namespace sim::stream
