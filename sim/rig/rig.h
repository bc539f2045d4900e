// The rig: the scenario's list of sensors in addition to head camera and chest IMU, the mounting of all
// sensors, and the calibrated sensors as used by recordings, estimators, exports and pages.
#pragma once

#include <string>

#include "slam/options.h"

namespace sim::rig {

/// Names of the sensors that every recording has.
inline constexpr const char *kHeadCamera = "cam0", *kChestImu = "imu0";

/// A mount without a link is relative to the sensor's place in the model.
inline constexpr const char* kModel = "model";

/// How a sensor is mounted on a link of the robot's model. The axes of the link and of the mounted sensor are
/// x forward, y left, z up; a camera looks along x.
struct Mount {
  std::string link = kModel;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double yaw_rad = 0, tilt_rad = 0, roll_rad = 0;

  static void keys(auto&& key) {
    value<&Mount::link>(
        key,
        "link of the robot that carries the sensor; model: position and angles are relative to the sensor's "
        "place in the model or, for the rig's sensors, to the head camera");
    number<&Mount::position_m>(key, -10, 10, "position on the link: forward, left, up");
    degrees<&Mount::yaw_rad>(key, -180, 180,
                             "turn about the vertical axis, positive to the left, applied first");
    degrees<&Mount::tilt_rad>(key, -180, 180,
                              "turn about the sensor's left axis, positive down, applied second");
    degrees<&Mount::roll_rad>(key, -180, 180, "turn about the sensor's forward axis, applied last");
  }

  bool on_link() const { return link != kModel; }
  bool is_default() const { return *this == Mount{}; }
  bool operator==(const Mount&) const = default;
};

/// Returns the pose of the sensor's axes (forward, left, up) in the link's axes.
Eigen::Isometry3d pose(const Mount& mount);

/// The scenario's keys imu.*: how the chest IMU is mounted.
struct ImuOptions : Mount {};

/// Each sensor has a name, which is also the name of its folder in a recording, and a clock.
struct Sensor : Mount {
  std::string name;
  double time_offset_s = 0;

  static void keys(auto&& key) {
    value<&Sensor::name>(key, "name of the sensor and of its folder in the recording");
    Mount::keys(key);
    number<&Sensor::time_offset_s>(key, -1, 1, "how far its stamps are ahead of the head camera's clock");
  }
};

/// Size, rate and shutter of a camera.
struct Imager {
  int width_px = 320, height_px = 240;
  double rate_hz = 30;
  double exposure_s = 0, readout_s = 0;
  int subframes = 8;

  static void size_keys(auto&& key) {
    number<&Imager::width_px>(key, 32, 4096, "width of the image");
    number<&Imager::height_px>(key, 32, 4096, "height of the image");
    number<&Imager::rate_hz>(key, 0.1, 1000, "frames per second of simulated time");
  }
  static void shutter_keys(auto&& key) {
    number<&Imager::exposure_s>(key, 0, 0.1, "exposure time of each row, which causes motion blur");
    number<&Imager::readout_s>(key, 0, 0.1,
                               "time from the first row's exposure to the last row's (rolling shutter)");
    number<&Imager::subframes>(key, 2, 64,
                               "pictures rendered for each frame when exposure_s or readout_s is not 0");
  }
};

/// A second gray camera with the lens, size, rate and shutter of the head camera.
struct GrayEye : Sensor {
  static constexpr const char* kName = "gray";
  double baseline_m = 0.05, read_sigma_gray = 1, shot_sigma_gray = 1;

  GrayEye() { name = "cam1"; }
  static void keys(auto&& key) {
    Sensor::keys(key);
    number<&GrayEye::baseline_m>(key, -1, 1, "distance to the right of the head camera, plus position_m");
    number<&GrayEye::read_sigma_gray>(key, 0, 100, "noise of a black pixel, in gray levels of 255");
    number<&GrayEye::shot_sigma_gray>(key, 0, 50, "photon noise of a white pixel, in gray levels of 255");
  }
  /// Returns what is wrong with the sensor, if anything.
  std::optional<std::string> problem() const;
};

/// A color camera with its own lens.
struct ColorCamera : Sensor, Imager {
  static constexpr const char* kName = "color";
  double fov_rad = 1.2042771838760873, distortion = 0;  // 69 deg
  double read_sigma_gray = 1, shot_sigma_gray = 1;

  ColorCamera() { name = "rgb0", width_px = 424, subframes = 4; }
  static void keys(auto&& key) {
    Sensor::keys(key);
    Imager::size_keys(key);
    degrees<&ColorCamera::fov_rad>(key, 10, 120, "horizontal field of view without distortion");
    number<&ColorCamera::distortion>(key, 0, 1.3, "radial parameter relative to the paper's camera");
    Imager::shutter_keys(key);
    number<&ColorCamera::read_sigma_gray>(key, 0, 100, "noise of a black pixel, in levels of 255");
    number<&ColorCamera::shot_sigma_gray>(key, 0, 50, "photon noise of a white pixel, in levels of 255");
  }
};

/// Depth at the pixels and stamps of another camera, as seen from that camera.
struct DepthCamera {
  static constexpr const char* kName = "depth";
  std::string name = "depth0", aligned_with = kHeadCamera;
  double nearest_m = 0.3, furthest_m = 10;
  double baseline_m = 0.05, disparity_sigma_px = 0.08, window_px = 7;
  int stereo_width_px = 0, edge_px = 1;

  static void keys(auto&& key) {
    value<&DepthCamera::name>(key, "name of the sensor and of its folder in the recording");
    value<&DepthCamera::aligned_with>(key, "the camera that has the same pixels, place and stamps");
    number<&DepthCamera::nearest_m>(key, 0.05, 60, "nearer surfaces give no depth");
    number<&DepthCamera::furthest_m>(key, 0.05, 60, "surfaces farther away give no depth");
    number<&DepthCamera::baseline_m>(
        key, 0.001, 1, "baseline b of the measuring stereo pair: the error is z² disparity_sigma_px / (f b)");
    number<&DepthCamera::stereo_width_px>(
        key, 0, 4096,
        "width of the images that the pair matches, which defines the pixels "
        "of the next two keys; 0: width of the depth image");
    number<&DepthCamera::disparity_sigma_px>(key, 0, 10, "error of the disparity; 0: exact depth");
    number<&DepthCamera::window_px>(key, 1, 64,
                                    "matching window, which correlates neighbors' errors; 1: independent");
    number<&DepthCamera::edge_px>(key, 0, 20,
                                  "width of the band along an occlusion edge that gives no depth");
  }
  std::optional<std::string> problem() const;
};

/// A spinning lidar whose pattern does not repeat.
struct Lidar : Sensor {
  static constexpr const char* kName = "lidar";
  double rate_hz = 10;
  int points_per_s = 200000;
  double lowest_rad = -0.12217304763960307, highest_rad = 0.9075712110370513;  // -7, 52 deg
  double nearest_m = 0.1, furthest_m = 40;
  double range_sigma_m = 0.02, angle_sigma_rad = 0.0026179938779914941;  // 0.15 deg

  Lidar() { name = "lidar0"; }
  static void keys(auto&& key) {
    Sensor::keys(key);
    number<&Lidar::rate_hz>(key, 0.5, 1000, "sweeps per second of simulated time");
    number<&Lidar::points_per_s>(key, 1, 5e6, "rays per second");
    degrees<&Lidar::lowest_rad>(key, -90, 90, "lowest ray, from the horizontal plane of the sensor");
    degrees<&Lidar::highest_rad>(key, -90, 90, "highest ray");
    number<&Lidar::nearest_m>(key, 0.01, 200, "nearer surfaces give no point");
    number<&Lidar::furthest_m>(key, 0.01, 200, "surfaces farther away give no point");
    number<&Lidar::range_sigma_m>(key, 0, 10, "noise of the range");
    degrees<&Lidar::angle_sigma_rad>(key, 0, 10, "noise of azimuth and elevation");
  }
  std::optional<std::string> problem() const;
};

/// A further IMU.
struct Imu : Sensor {
  static constexpr const char* kName = "imu";
  double rate_hz = 200;
  double gyro_sigma_rad_s = 5e-4, accelerometer_sigma_m_s2 = 1e-2;
  double gyro_bias_sigma_rad_s = 0, accelerometer_bias_sigma_m_s2 = 0;

  Imu() { name = "imu1"; }
  static void keys(auto&& key) {
    Sensor::keys(key);
    number<&Imu::rate_hz>(key, 1, 1000, "readings per second, each the mean since the previous one");
    number<&Imu::gyro_sigma_rad_s>(key, 0, 1e3, "white noise of a gyro reading");
    number<&Imu::accelerometer_sigma_m_s2>(key, 0, 1e3, "white noise of an accelerometer reading");
    number<&Imu::gyro_bias_sigma_rad_s>(key, 0, 1e3,
                                        "standard deviation of the gyro's constant bias over seeds");
    number<&Imu::accelerometer_bias_sigma_m_s2>(
        key, 0, 1e3, "standard deviation of the accelerometer's constant bias over seeds");
  }
  std::optional<std::string> problem() const;
};

/// One additional sensor.
using Item = std::variant<GrayEye, ColorCamera, DepthCamera, Lidar, Imu>;

const std::string& name_of(const Item& item);

/// Returns the rig with that name: head_2006 (the paper's: no additional sensors), d435i, d435i_mid360.
/// Returns nothing for other names.
std::optional<std::vector<Item>> preset(std::string_view name);
std::vector<std::string_view> preset_names();

/// An invalid item and the reason: its name is taken or not a folder name, or a depth camera has no partner.
struct Problem {
  std::size_t item;
  std::string what;
};
/// Returns the first problem, if any.
std::optional<Problem> problem(const std::vector<Item>& items);
/// Returns the first of these sensor names that is taken or not a folder name, and why.
std::optional<Problem> name_problem(const std::vector<std::string>& names);

enum class Kind { gray, color, depth, lidar, imu };
/// The words for the kinds, in the order of their values.
inline constexpr std::array<std::string_view, 5> kKinds{"gray", "color", "depth", "lidar", "imu"};

/// An additional sensor of a recording.
struct RigSensor {
  std::string name;  ///< name of the sensor and of its folder
  Kind kind = Kind::gray;
  double rate_hz = 30;
  double time_offset_s = 0;  ///< how far its stamps are ahead of the head camera's clock, after sensor errors
  /// The sensor in the frame of the head camera C. A camera's axes are x right, y down, z forward; a lidar's
  /// and an IMU's are x forward, y left, z up.
  Eigen::Isometry3d X_CS = Eigen::Isometry3d::Identity();
  slam::CameraIntrinsics camera = {};      ///< for gray, color and depth
  std::string aligned_with = {};           ///< for depth: the camera with the same pixels and stamps
  double nearest_m = 0, furthest_m = 0;    ///< for depth and lidar
  double readout_s = 0;                    ///< for gray and color: from the first row to the last
  double lowest_rad = 0, highest_rad = 0;  ///< for a lidar

  // Errors on the way to the estimator (sim/sensor_errors); recorded readings are ideal.
  double read_sigma_gray = 0, shot_sigma_gray = 0;            ///< for gray and color
  double baseline_m = 0, disparity_sigma_px = 0;              ///< for depth, in the camera's pixels
  double window_px = 1;                                       ///< for depth: the matching window
  int edge_px = 0;                                            ///< for depth
  double range_sigma_m = 0, angle_sigma_rad = 0;              ///< for a lidar
  double gyro_sigma_rad_s = 0, accelerometer_sigma_m_s2 = 0;  ///< for one reading of an IMU
  double gyro_bias_sigma_rad_s = 0, accelerometer_bias_sigma_m_s2 = 0;
  double gyro_bias_walk_rad_s2 = 0, accelerometer_bias_walk_m_s3 = 0;  ///< for the chest IMU
};

/// Returns the standard deviation of the inverse depth 1/z measured by a depth camera, 1/m.
inline double inverse_depth_sigma(const RigSensor& depth) {
  return depth.disparity_sigma_px / (depth.camera.fu_px * depth.baseline_m);
}

/// Returns whether the sensor has images.
inline bool is_camera(const RigSensor& sensor) { return sensor.kind <= Kind::depth; }

/// Returns the axes forward, left, up in a camera's axes (right, down, forward).
Eigen::Isometry3d camera_from_forward_left_up();

/// Returns the calibrated sensors of a scenario's list. head: intrinsics of the head camera; head_rate_hz,
/// head_readout_s: its rate and shutter. X_CL: each item's mount (axes: forward, left, up) in the head
/// camera's frame, in the order of the items; not used for depth. Throws std::invalid_argument if
/// problem(items) finds a problem.
std::vector<RigSensor> calibrated(const std::vector<Item>& items, const slam::CameraIntrinsics& head,
                                  double head_rate_hz, double head_readout_s,
                                  const std::vector<Eigen::Isometry3d>& X_CL);

/// Returns a lens with the pinhole focal length for a field of view, f = (w/2) / tan(fov/2), radial
/// distortion, and its center in the middle.
slam::CameraIntrinsics lens(int width_px, int height_px, double fov_rad, double distortion);

/// The coefficients of a lens, in the order of its members.
std::vector<double> coefficients(const slam::Lens& lens);

/// Returns the index of the camera that a depth camera is aligned with, or -1 for the head camera.
int partner(const std::vector<RigSensor>& rig, const RigSensor& depth);

/// A camera that approximates another one, and the differences between their pixels over the whole image.
struct FittedCamera {
  slam::CameraIntrinsics camera;
  double rms_px = 0, largest_px = 0;
};

/// Returns the equidistant camera closest to the given one: a least-squares fit of the two focal lengths and
/// four coefficients over a grid of pixels that includes the borders. The principal point is kept.
FittedCamera fit_equidistant(const slam::CameraIntrinsics& camera);

}  // namespace sim::rig
