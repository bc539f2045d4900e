// Turns the readings of ideal sensors into the filter's input, with errors and faults from named random
// streams.
#pragma once

#include <cstdint>
#include <deque>

#include "sim/rig/rig.h"
#include "sim/sensor_errors/faults.h"

namespace sim::sensor_errors {

/// The scenario's keys errors.image.*. SensorErrors applies loss and latency. Fixed-point noise limits the
/// ranges.
struct ImageOptions {
  double read_sigma_gray = 1.0, shot_sigma_gray = 1.0;
  double gain = 1.0;
  double loss_fraction = 0.0;
  double latency_s = 0;
  bool operator==(const ImageOptions&) const = default;

  static void keys(auto&& key) {
    number<&ImageOptions::read_sigma_gray>(key, 0, 100,
                                           "noise of a black pixel before the gain, in gray levels of 255");
    number<&ImageOptions::shot_sigma_gray>(
        key, 0, 50,
        "photon noise of a white pixel before the gain, in gray levels of 255; its square is proportional to "
        "the light");
    number<&ImageOptions::gain>(key, 0, 16, "gain of the camera, applied after the noise");
    number<&ImageOptions::loss_fraction>(key, 0, 1, "fraction of the frames that lose their image");
    number<&ImageOptions::latency_s>(
        key, 0, 10,
        "minimum age of a frame's picture; a frame has the newest picture that is at least that old");
  }
};

/// Image = gain (light + noise) with noise² = read² + shot² light / 255, drawn by seed, stream and stamp.
class ImageErrors {
 public:
  ImageErrors(const ImageOptions& sizes, std::uint64_t seed, const std::vector<Fault>& faults,
              std::string stream = "image noise");

  /// Returns a new image; `ideal` is CV_8UC1.
  cv::Mat apply(const cv::Mat& ideal, slam::Stamp t) const;
  bool operator==(const ImageErrors&) const = default;

 private:
  cv::Mat covered(const cv::Mat& image, double fraction) const;

  /// The pixel for an amount of light (1/16 gray): its mean in 2^-20 gray and its noise in 1/256 gray.
  struct Response {
    int mean = 0, sigma = 0;
    bool operator==(const Response&) const = default;
  };
  ImageOptions sizes_;
  std::uint64_t seed_;
  std::string stream_;
  std::vector<FramesDimmed> dimmed_;
  std::vector<FramesCovered> covers_;
  std::array<Response, 4096> responses_;
};

/// The errors of one inertial sensor, per axis, in its own unit (rad/s or m/s²).
struct InertialErrorSizes {
  double sigma = 0;            ///< white noise of a 200 Hz reading
  double bias_sigma = 0;       ///< standard deviation of the start bias, drawn once per run
  double bias_walk_sigma = 0;  ///< growth of the bias's standard deviation in 1 s

  /// The keys. Their names end in the unit of a reading; for the bias walk, in that unit per s.
  static void keys(auto&& key, const std::string& sensor, const std::string& unit, const char* unit_per_s) {
    const auto add = [&](const std::string& name, double InertialErrorSizes::*size, const std::string& doc) {
      key.number(name, size, 0, 1e3, doc.c_str());
    };
    add("sigma_" + unit, &InertialErrorSizes::sigma, "white noise of a 200 Hz " + sensor + " reading");
    add("bias_sigma_" + unit, &InertialErrorSizes::bias_sigma,
        "standard deviation of the " + sensor + "'s bias at the start over seeds");
    add(std::string("bias_walk_sigma_") + unit_per_s, &InertialErrorSizes::bias_walk_sigma,
        "random walk of the " + sensor + "'s bias: growth of its standard deviation in 1 s");
  }
};

/// The errors of one sensor. Draws are keyed by seed, the sensor's name and the reading's stamp.
class InertialErrors {
 public:
  struct Spike {
    Span span;
    double size = 0, factor = 1;
  };
  InertialErrors(std::string sensor, const InertialErrorSizes& sizes, std::uint64_t seed,
                 std::vector<Spike> spikes, std::vector<Span> silences);

  /// Readings must come in chronological order, also from call to call.
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

/// The scenario's keys errors.*. Standard deviations are per axis; biases are drawn once per run.
struct ErrorOptions {
  struct Gyro : InertialErrorSizes {
    static void keys(auto&& key) { InertialErrorSizes::keys(key, "gyro", "rad_s", "rad_s2"); }
  } gyro{{.sigma = 0.01}};
  struct Accelerometer : InertialErrorSizes {
    static void keys(auto&& key) { InertialErrorSizes::keys(key, "accelerometer", "m_s2", "m_s3"); }
  } accelerometer{{.sigma = 0.05}};
  ImageOptions image;
  double plan_loss_fraction = 0;
  struct LegOdometry {
    double sigma_m = 1e-4;
    double scale_fraction = 0;

    static void keys(auto&& key) {
      number<&LegOdometry::sigma_m>(
          key, 0, 1e3, "white noise of each frame's leg odometry position, from encoders and force sensors");
      number<&LegOdometry::scale_fraction>(key, -1, 1, "relative error of the distances in leg odometry");
    }
  } leg_odometry;
  double motion_time_offset_s = 0, calibration_distortion_fraction = 0;
  std::vector<Fault> faults;

  static void keys(auto&& key) {
    part<&ErrorOptions::gyro, &ErrorOptions::accelerometer, &ErrorOptions::image>(key);
    key.number("plan.loss_fraction", &ErrorOptions::plan_loss_fraction, 0, 1,
               "fraction of the frames that lose their planned motion but keep leg odometry");
    part<&ErrorOptions::leg_odometry>(key);
    key.number("motion.time_offset_s", &ErrorOptions::motion_time_offset_s, -1, 1,
               "how far the motion computer's clock, which stamps readings and plan, is ahead of the "
               "camera's");
    key.number("calibration.distortion_fraction", &ErrorOptions::calibration_distortion_fraction, -1, 1,
               "relative error of the lens distortion that the filter assumes");
    value<&ErrorOptions::faults>(key, "temporary faults of the sensors and of the plan");
  }
};

/// Sets the values that a data sheet and a calibration of the chest IMU would state: noise, and the clock's
/// offset.
void state_errors(const ErrorOptions& errors, rig::RigSensor& chest_imu);

/// Decides which frame's image arrives with each frame: images are lost, frozen and delayed.
class ImageSources {
 public:
  ImageSources(const ErrorOptions& options, std::uint64_t seed);
  /// Returns the stamp of the frame whose image arrives with the frame at t, or nullopt. Must be called for
  /// each frame in chronological order. has_image: the frame has an ideal image.
  std::optional<slam::Stamp> at(slam::Stamp t, bool has_image);
  /// Returns whether the image of the last frame is to arrive, with it or later.
  bool is_source(slam::Stamp t) const { return last_unfrozen_ == t; }

 private:
  std::uint64_t seed_;
  double loss_fraction_;
  slam::Stamp latency_;
  std::vector<FramesLost> losses_;
  std::vector<FramesFrozen> freezes_;
  std::optional<slam::Stamp> last_unfrozen_;
  std::deque<std::pair<slam::Stamp, slam::Stamp>> delayed_;  // frame and source
};

/// Faults of the planned motion, applied to one observation at a time.
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

/// A motion computer whose clock has an offset. Assembles the vision computer's observations by their stamps.
class MotionClock {
 public:
  /// offset: the motion computer's stamps minus the vision computer's at the same time.
  explicit MotionClock(slam::Stamp offset) : offset_(offset) {}

  /// Adds an observation with true stamps and returns the complete ones. If the clock is behind, frames wait
  /// for their motion. Readings across a frame's stamp are split; plan and leg odometry are interpolated.
  std::vector<slam::Observation> process(slam::Observation observation);

  /// Returns the frames that are still waiting, with the motion known so far.
  std::vector<slam::Observation> flush();

 private:
  struct StampedMotion {
    slam::Stamp t{0};
    std::optional<slam::PlannedMotion> plan;
    std::optional<slam::LegMotion> legs;
    std::optional<slam::CommandedVelocity> command;
  };
  slam::Observation assembled();
  void add_motion(slam::Observation& frame);

  slam::Stamp offset_;
  std::deque<slam::Observation> waiting_;
  std::deque<slam::InertialSample> gyro_, accelerometer_;
  std::deque<slam::BodyReading> body_;
  std::deque<StampedMotion> motions_;
};

/// Applies each rig sensor's errors to its readings, then shifts their stamps by the sensor's offset. Draws
/// are keyed by seed, the sensor's name and the true stamp, so adding a sensor does not change another
/// sensor's numbers.
class RigErrors {
 public:
  RigErrors(const std::vector<rig::RigSensor>& rig, std::uint64_t seed);

  /// Does not write to the images' pixels.
  void apply(std::vector<slam::RigReading>& readings);

 private:
  struct Sensor {
    rig::RigSensor is;
    std::string stream;
    ImageErrors image;
    InertialErrors gyro, accelerometer;
  };
  std::uint64_t seed_;
  std::vector<Sensor> sensors_;
};

/// Returns the pixels of a depth image (CV_16UC1, mm, 0: none) within `reach` pixels of an occlusion edge, as
/// non-zero values of CV_8UC1. There is an edge between two neighbors in a row or a column if their inverse
/// depths differ by more than 2 % and by more than three times the larger difference to the next neighbors on
/// either side. On a plane of any slant these differences are equal, because inverse depth is linear in the
/// pixel.
cv::Mat1b beside_edges(const cv::Mat1w& depth_mm, int reach);

/// Applies the errors to one observation at a time, starting with the first one of a run. Every draw is keyed
/// by seed, stream name and stamp, so that a live run and a replay agree bit for bit and no error changes the
/// numbers of another.
class SensorErrors {
 public:
  /// rig: the additional sensors of the observations.
  SensorErrors(const ErrorOptions& options, std::uint64_t seed, const std::vector<rig::RigSensor>& rig = {});

  /// Returns what reaches the filter after this ideal observation, in order. Does not write to its pixels.
  std::vector<slam::Observation> process(slam::Observation ideal);

  /// Returns the observations that have not arrived at the end of the run.
  std::vector<slam::Observation> flush();

 private:
  /// Appends the observations that arrive after this one. By seed and stamp, some arrive twice and some after
  /// the next one.
  void arrive(slam::Observation observation, std::vector<slam::Observation>& arrived);
  template <class Kind>
  bool strikes(const char* stream, slam::Stamp t) const;
  cv::Mat received_image(const cv::Mat& ideal, slam::Stamp t);
  void disturb(slam::LegMotion& legs, slam::Stamp t);

  struct StampedImage {
    slam::Stamp t{0};
    cv::Mat image;
  };
  ErrorOptions options_;
  std::uint64_t seed_;
  RigErrors rig_;
  InertialErrors gyro_, accelerometer_;
  ImageErrors image_;
  ImageSources sources_;
  PlanErrors plan_;
  std::optional<Eigen::Vector3d> first_p_OC_;
  MotionClock motion_clock_;
  std::optional<slam::Observation> late_;
  std::deque<StampedImage> images_;  // since the one that arrived last
};

}  // namespace sim::sensor_errors
