#include "sim/recording/sensor_yaml.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/depthguard.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <set>
#include <type_traits>

#include "slam/camera.h"

namespace sim::recording {
namespace {

// OpenCV's reader requires this directive on the first line; yaml-cpp does not know its version.
constexpr const char* kDirective = "%YAML:1.0";
constexpr double kLeastRate = 1e-3, kLargestRate = 1e6;  // Hz
constexpr int kLeastSide = 32, kLargestSide = 8192;      // px of a camera: its images fit into memory
/// In the order of slam::Lens.
constexpr std::array<std::string_view, 3> kLenses{"one-parameter-radial", "radial-tangential", "equidistant"};

std::string matrix(const std::string& key, const Eigen::Isometry3d& X) {
  const Eigen::Matrix4d& m = X.matrix();
  std::string text = fmt::format("{}:\n  cols: 4\n  rows: 4\n  data: [", key);
  for (int row = 0; row < 4; ++row)
    text += fmt::format("{}{}, {}, {}, {}", row ? ",\n         " : "", m(row, 0), m(row, 1), m(row, 2),
                        m(row, 3));
  return text + "]\n";
}

std::string head(const std::string& type, const std::string& comment) {
  return fmt::format("{}\nsensor_type: {}\ncomment: \"{}\"\n", kDirective, type, comment);
}

// A parsed file. Members throw FileError with file, line and column.
class Yaml {
 public:
  explicit Yaml(const YamlFile& file) : file_(file.name) {
    std::string text = file.text;
    if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);  // byte order mark
    if (text.starts_with(kDirective)) text.replace(0, std::string(kDirective).size(), "#");
    try {
      root_ = YAML::Load(text);
    } catch (const YAML::DeepRecursion& error) {
      fail(error.mark, fmt::format("has {} levels or more, expected fewer", error.depth()));
    } catch (const YAML::Exception& error) {
      fail(error.mark, error.msg);
    }
    if (!root_.IsMap()) return;
    require_keys_once(root_);
    for (const char* chain : {"cam0", "imu0"})  // of kalibr, which knows several sensors
      if (const YAML::Node first = root_[chain]; first && first.IsMap()) {
        root_.reset(first);
        require_keys_once(root_);
        break;
      }
    for (const char* pose : {"T_BS", "T_SB", "T_CS", "T_WC_start"})
      if (has(pose) && at(pose).IsMap()) require_keys_once(at(pose));
    for (const char* rate : {"rate_hz", "update_rate"})
      if (const auto hz = has(rate) ? files::parse_finite(at(rate).Scalar()) : kLeastRate;
          !hz || *hz < kLeastRate || *hz > kLargestRate)
        fail(at(rate).Mark(), fmt::format("{}: expected a number of Hz from {} to {:.0f}, found \"{}\"", rate,
                                          kLeastRate, kLargestRate, at(rate).Scalar()));
    asked_.clear();
  }

  YAML::Node at(const std::string& key) const {
    if (!has(key)) throw files::FileError(file_, "has no key " + key);
    return root_[key];
  }

  bool has(const std::string& key) const {
    asked_.insert(key);
    return root_.IsMap() && root_[key];
  }

  /// The first of two names that a key may have.
  const char* either(const char* key, const char* other) const {
    return !has(key) && has(other) ? other : key;
  }

  /// The keys that were neither asked for nor are known to say nothing more.
  std::vector<std::string> others() const {
    static const std::set<std::string> kKnown{"sensor_type", "comment",   "rostopic",  "cam_overlaps",
                                              "T_BS",        "T_imu_cam", "T_cam_imu", "T_SB"};
    std::vector<std::string> keys;
    for (const auto& entry : root_)
      if (const std::string& key = entry.first.Scalar(); !asked_.contains(key) && !kKnown.contains(key))
        keys.push_back(key);
    return keys;
  }

  double number(const YAML::Node& node) const {
    const auto value = node.IsScalar() ? files::parse_finite(node.Scalar()) : std::nullopt;
    if (!value) fail(node.Mark(), "expected a finite number");
    return *value;
  }

  std::vector<double> numbers(const YAML::Node& node, std::size_t count) const {
    if (!node.IsSequence() || node.size() != count)
      fail(node.Mark(), fmt::format("expected {} numbers", count));
    std::vector<double> values;
    for (const YAML::Node& entry : node) values.push_back(number(entry));
    return values;
  }

  std::vector<std::string> names(const std::string& key) const {
    if (!at(key).IsSequence()) fail(at(key).Mark(), key + ": expected a list of sensors");
    std::vector<std::string> names;
    for (const YAML::Node& name : at(key)) {
      if (!name.IsScalar()) fail(name.Mark(), key + ": expected the name of a sensor");
      names.push_back(name.Scalar());
    }
    return names;
  }

  /// From 16 numbers in `data`, a list of them, or four rows. rounded: the file has few digits, and the
  /// rotation is made orthonormal.
  Eigen::Isometry3d pose(const std::string& key, bool rounded = true) const {
    const YAML::Node node = at(key), data = node.IsMap() ? node["data"] : node;
    if (!data || !data.IsSequence()) fail(node.Mark(), "expected a matrix");
    std::vector<double> values;
    if (data.size() != 4) values = numbers(data, 16);
    for (std::size_t row = 0; data.size() == 4 && row < 4; ++row)
      for (const double value : numbers(data[row], 4)) values.push_back(value);
    Eigen::Isometry3d X;
    X.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data());
    const Eigen::Matrix3d residual = X.linear() * X.linear().transpose() - Eigen::Matrix3d::Identity();
    if (residual.norm() > (rounded ? 1e-4 : 1e-9) || X.linear().determinant() < 0 ||
        X.matrix().row(3) != Eigen::RowVector4d(0, 0, 0, 1))
      fail(node.Mark(), "not a pose: expected a rotation and a translation above the row 0 0 0 1");
    if (rounded) X.linear() = Eigen::Quaterniond(X.linear()).normalized().toRotationMatrix();
    return X;
  }

  [[noreturn]] void fail(const YAML::Mark& mark, const std::string& why) const {
    if (mark.is_null()) throw files::FileError(file_, why);
    throw files::FileError(file_, static_cast<std::size_t>(mark.line) + 1,
                           static_cast<std::size_t>(mark.column) + 1, why);
  }

 private:
  void require_keys_once(const YAML::Node& map) const {
    std::map<std::string, int> lines;
    for (const auto& entry : map) {
      const std::string& key = entry.first.Scalar();
      const YAML::Mark mark = entry.first.Mark();
      const auto [first, is_new] = lines.emplace(key, mark.line + 1);
      if (!is_new && entry.first.IsScalar())
        fail(mark, fmt::format("{}: given twice, first in line {}, expected once", key, first->second));
    }
  }

  std::filesystem::path file_;
  YAML::Node root_;
  mutable std::set<std::string> asked_;
};

slam::Lens read_lens(const Yaml& yaml) {
  const YAML::Node model = yaml.at("distortion_model"),
                   coefficients = yaml.at(yaml.either("distortion_coefficients", "distortion_coeffs"));
  const std::string name = model.IsScalar() ? model.Scalar() : "";
  if (name == kLenses[0]) return slam::OneParameterRadial{yaml.numbers(coefficients, 1)[0]};
  if (name != kLenses[1] && name != "radtan" && name != kLenses[2])
    yaml.fail(model.Mark(), fmt::format("expected {}, radtan, {} or {}", kLenses[1], kLenses[2], kLenses[0]));
  const std::vector<double> k = yaml.numbers(coefficients, 4);
  if (name == kLenses[2]) return slam::Equidistant{k[0], k[1], k[2], k[3]};
  return slam::RadialTangential{k[0], k[1], k[2], k[3]};
}

std::string intrinsics(const slam::CameraIntrinsics& camera) {
  return fmt::format(
      "resolution: [{}, {}]\ncamera_model: pinhole\nintrinsics: [{}, {}, {}, {}]\ndistortion_model: {}\n"
      "distortion_coefficients: [{}]\n",
      camera.width_px, camera.height_px, camera.fu_px, camera.fv_px, camera.u0_px, camera.v0_px,
      kLenses[camera.lens.index()], fmt::join(rig::coefficients(camera.lens), ", "));
}

slam::CameraIntrinsics read_intrinsics(const Yaml& yaml) {
  const auto resolution = yaml.numbers(yaml.at("resolution"), 2),
             values = yaml.numbers(yaml.at("intrinsics"), 4);
  for (const double side : resolution)
    if (side < kLeastSide || side > kLargestSide || side != std::floor(side))
      yaml.fail(yaml.at("resolution").Mark(),
                fmt::format("expected whole numbers from {} to {}", kLeastSide, kLargestSide));
  if (yaml.has("camera_model") && yaml.at("camera_model").Scalar() != "pinhole")
    yaml.fail(yaml.at("camera_model").Mark(), "expected pinhole");
  const slam::CameraIntrinsics camera{int(resolution[0]), int(resolution[1]), values[0],      values[1],
                                      values[2],          values[3],          read_lens(yaml)};
  try {
    slam::Camera{camera};
  } catch (const std::invalid_argument& error) {  // the filter rejects it
    yaml.fail(YAML::Mark::null_mark(), error.what());
  }
  return camera;
}

std::string first_interval(std::optional<slam::Stamp> begin) {
  return begin ? fmt::format("first_interval_begins_ns: {}\n", file_stamp(*begin)) : "";
}

std::optional<slam::Stamp> read_first_interval(const Yaml& yaml) {
  if (!yaml.has("first_interval_begins_ns")) return std::nullopt;
  const YAML::Node begin = yaml.at("first_interval_begins_ns");
  const auto ns = files::parse_number<std::int64_t>(begin.IsScalar() ? begin.Scalar() : "");
  if (!ns || *ns < 0) yaml.fail(begin.Mark(), "expected an integer from 0");
  return slam::Stamp(*ns) - kEpoch;
}

// Calls take(key, number) for the numbers of an IMU's noise.
void each_density(auto& noise, auto&& take) {
  take("gyroscope_noise_density", noise.gyro_density);
  take("gyroscope_random_walk", noise.gyro_walk);
  take("accelerometer_noise_density", noise.accelerometer_density);
  take("accelerometer_random_walk", noise.accelerometer_walk);
}

constexpr double kLargest = 1e6;  // of a sensor's numbers; rates have their own limits

// Calls take(key, number, lowest = 0, highest = kLargest) for the numbers that a further sensor of its kind
// has.
void each_number(auto& sensor, auto&& take) {
  using rig::Kind;
  take("rate_hz", sensor.rate_hz);
  take("time_offset_s", sensor.time_offset_s, -kLargest);
  if (sensor.kind == Kind::gray || sensor.kind == Kind::color) {
    take("readout_s", sensor.readout_s);
    take("read_sigma_gray", sensor.read_sigma_gray);
    take("shot_sigma_gray", sensor.shot_sigma_gray);
  }
  if (sensor.kind == Kind::depth || sensor.kind == Kind::lidar) {
    take("nearest_m", sensor.nearest_m);
    take("furthest_m", sensor.furthest_m);
  }
  if (sensor.kind == Kind::depth) {
    take("baseline_m", sensor.baseline_m, 1e-3);
    take("disparity_sigma_px", sensor.disparity_sigma_px);
    take("window_px", sensor.window_px, 1, 64);
    take("edge_px", sensor.edge_px, 0, 20);
  }
  if (sensor.kind == Kind::lidar) {
    take("lowest_rad", sensor.lowest_rad, -M_PI);
    take("highest_rad", sensor.highest_rad, -M_PI);
    take("range_sigma_m", sensor.range_sigma_m);
    take("angle_sigma_rad", sensor.angle_sigma_rad);
  }
  if (sensor.kind == Kind::imu) {
    take("gyro_sigma_rad_s", sensor.gyro_sigma_rad_s);
    take("accelerometer_sigma_m_s2", sensor.accelerometer_sigma_m_s2);
    take("gyro_bias_sigma_rad_s", sensor.gyro_bias_sigma_rad_s);
    take("accelerometer_bias_sigma_m_s2", sensor.accelerometer_bias_sigma_m_s2);
  }
}

}  // namespace

std::string camera_yaml(const slam::Calibration& calibration, double rate_hz) {
  return head("camera", "head camera; body frame: the chest IMU") +
         matrix("T_BS", calibration.X_CG.inverse()) + matrix("T_SB", calibration.X_CG) +
         fmt::format("rate_hz: {}\n", rate_hz) + intrinsics(calibration.camera);
}

std::string imu_yaml(const std::string& comment, const Eigen::Isometry3d& X_BS, double rate_hz,
                     const ImuNoise& noise, std::optional<slam::Stamp> begin) {
  std::string text = head("imu", comment) + matrix("T_BS", X_BS) + fmt::format("rate_hz: {}\n", rate_hz);
  each_density(noise, [&](const char* key, double value) { text += fmt::format("{}: {}\n", key, value); });
  return text + first_interval(begin);
}

std::string body_sensor_yaml(const BodySensor& sensor, const RecordingSetup& setup) {
  return head(sensor.type, sensor.comment) + fmt::format("rate_hz: {}\n", setup.imu_rate_hz) +
         sensor.yaml(setup.joints);
}

std::string plan_yaml(const RecordingSetup& setup) {
  return head("plan", "walking plan: the camera's pose and velocities in the plan's own world") +
         fmt::format("rate_hz: {}\n", setup.camera_rate_hz) + matrix("T_WC_start", setup.X_WC_start);
}

std::string motion_yaml() {
  return head("visual-inertial", "truth of the simulator") + matrix("T_BS", Eigen::Isometry3d::Identity());
}

std::string body_yaml(const std::vector<rig::RigSensor>& rig) {
  std::vector<std::string> names;
  for (const rig::RigSensor& sensor : rig) names.push_back(sensor.name);
  return std::string(kDirective) + "\ncomment: \"GaitSLAM humanoid; body frame: the chest IMU\"\n" +
         (names.empty() ? "" : fmt::format("rig: [{}]\n", fmt::join(names, ", ")));
}

std::string rig_sensor_yaml(const rig::RigSensor& sensor, const slam::Calibration& calibration,
                            std::optional<slam::Stamp> begin) {
  const RigFormat& format = format_of(sensor.kind);
  std::string text = head(std::string(format.type), std::string(format.comment)) +
                     matrix("T_BS", calibration.X_CG.inverse() * sensor.X_CS) + matrix("T_CS", sensor.X_CS) +
                     fmt::format("kind: {}\n", rig::kKinds.at(static_cast<std::size_t>(sensor.kind)));
  if (rig::is_camera(sensor)) text += intrinsics(sensor.camera);
  if (sensor.kind == rig::Kind::depth) text += fmt::format("aligned_with: {}\n", sensor.aligned_with);
  each_number(sensor,
              [&](const char* key, auto value, auto...) { text += fmt::format("{}: {}\n", key, value); });
  return text + first_interval(begin);
}

std::vector<std::string> read_joints(const YamlFile& file) { return Yaml(file).names("joints"); }

std::vector<std::string> read_body_yaml(const YamlFile& file) {
  const Yaml yaml(file);
  if (!yaml.has("rig")) return {};
  const std::vector<std::string> names = yaml.names("rig");
  if (const auto found = rig::name_problem(names))
    yaml.fail(yaml.at("rig")[found->item].Mark(), "rig: " + found->what);
  return names;
}

std::pair<rig::RigSensor, std::optional<slam::Stamp>> read_rig_sensor_yaml(const YamlFile& file,
                                                                           const std::string& name) {
  const Yaml yaml(file);
  std::pair<rig::RigSensor, std::optional<slam::Stamp>> read;
  auto& [sensor, begin] = read;
  sensor.name = name;
  const YAML::Node kind = yaml.at("kind");
  const auto found = std::ranges::find(rig::kKinds, kind.IsScalar() ? kind.Scalar() : "");
  if (found == rig::kKinds.end())
    yaml.fail(kind.Mark(), fmt::format("kind: expected one of {}", fmt::join(rig::kKinds, ", ")));
  sensor.kind = static_cast<rig::Kind>(found - rig::kKinds.begin());
  sensor.X_CS = yaml.pose("T_CS", false);
  if (rig::is_camera(sensor)) sensor.camera = read_intrinsics(yaml);
  if (sensor.kind == rig::Kind::depth) sensor.aligned_with = yaml.at("aligned_with").Scalar();
  each_number(sensor, [&](const char* key, auto& value, double lowest = 0, double highest = kLargest) {
    using Number = std::decay_t<decltype(value)>;
    const YAML::Node node = yaml.at(key);
    const auto stated = files::parse_number<Number>(node.IsScalar() ? node.Scalar() : "");
    if (!stated || !(*stated >= lowest && *stated <= highest))
      yaml.fail(node.Mark(),
                fmt::format("{}: expected {} from {} to {}", key,
                            std::is_integral_v<Number> ? "a whole number" : "a number", lowest, highest));
    value = *stated;
  });
  if (sensor.nearest_m > sensor.furthest_m)
    yaml.fail(yaml.at("nearest_m").Mark(),
              fmt::format("nearest_m {} is above furthest_m {}", sensor.nearest_m, sensor.furthest_m));
  if (sensor.kind == rig::Kind::imu) begin = read_first_interval(yaml);
  return read;
}

StatedCamera read_camera_yaml(const YamlFile& file, RecordingSetup& setup) {
  const Yaml yaml(file);
  setup.calibration.camera = read_intrinsics(yaml);
  StatedCamera stated;
  stated.by_imu = !yaml.has("T_SB") && !yaml.has("T_BS") && (yaml.has("T_cam_imu") || yaml.has("T_imu_cam"));
  if (stated.by_imu)
    setup.calibration.X_CG =
        yaml.has("T_cam_imu") ? yaml.pose("T_cam_imu") : yaml.pose("T_imu_cam").inverse();
  else
    setup.calibration.X_CG = yaml.has("T_SB") ? yaml.pose("T_SB", false) : yaml.pose("T_BS").inverse();
  if (!stated.by_imu || yaml.has("rate_hz"))
    stated.rate_hz = setup.camera_rate_hz = yaml.number(yaml.at("rate_hz"));
  if (yaml.has("timeshift_cam_imu")) stated.timeshift_s = yaml.number(yaml.at("timeshift_cam_imu"));
  if (std::abs(stated.timeshift_s) > 10)
    yaml.fail(yaml.at("timeshift_cam_imu").Mark(), "expected a number of seconds from -10 to 10");
  stated.unread = yaml.others();
  return stated;
}

StatedImu read_imu_yaml(const YamlFile& file) {
  const Yaml yaml(file);
  StatedImu imu;
  if (yaml.has("T_BS") || !yaml.has("update_rate")) imu.X_BS = yaml.pose("T_BS");
  imu.rate_hz = yaml.number(yaml.at(yaml.either("rate_hz", "update_rate")));
  each_density(imu.noise, [&](const char* key, double& stated) {
    if (yaml.has(key)) stated = yaml.number(yaml.at(key));
    if (stated != 0 && !(stated >= 1e-9 && stated <= 1e3))
      yaml.fail(yaml.at(key).Mark(), "expected 0 or a number from 1e-9 to 1000");
  });
  imu.begin = read_first_interval(yaml);
  imu.unread = yaml.others();
  return imu;
}

Eigen::Isometry3d read_pose(const YamlFile& file, const std::string& key, bool rounded) {
  return Yaml(file).pose(key, rounded);
}

}  // namespace sim::recording
