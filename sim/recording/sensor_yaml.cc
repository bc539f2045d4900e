#include "sim/recording/sensor_yaml.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/depthguard.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "sim/files/text.h"
#include "slam/camera.h"

namespace sim::recording {
namespace {

// OpenCV's reader requires this directive on the first line; yaml-cpp does not know its version.
constexpr const char* kDirective = "%YAML:1.0";
constexpr double kLeastRate = 1e-3, kLargestRate = 1e6;  // Hz
constexpr int kLeastSide = 32, kLargestSide = 8192;      // px of a camera: its images fit into memory
constexpr const char *kOneParameter = "one-parameter-radial", *kRadialTangential = "radial-tangential",
                     *kEquidistant = "equidistant";

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

std::string lens(const slam::Lens& lens) {
  const auto text = [](const char* model, const auto&... coefficients) {
    const std::vector<double> all{coefficients...};
    return fmt::format("distortion_model: {}\ndistortion_coefficients: [{}]\n", model, fmt::join(all, ", "));
  };
  if (const auto* k = std::get_if<slam::Equidistant>(&lens))
    return text(kEquidistant, k->k1, k->k2, k->k3, k->k4);
  if (const auto* k = std::get_if<slam::RadialTangential>(&lens))
    return text(kRadialTangential, k->k1, k->k2, k->p1, k->p2);
  return text(kOneParameter, std::get<slam::OneParameterRadial>(lens).k1_px2);
}

// A parsed file. Members throw FileError with file, line and column.
class Yaml {
 public:
  Yaml(const std::filesystem::path& file, std::string text) : file_(file) {
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
    for (const char* pose : {"T_BS", "T_SB", "T_WC_start"})
      if (has(pose) && at(pose).IsMap()) require_keys_once(at(pose));
    for (const char* rate : {"rate_hz", "update_rate"})
      if (const auto hz = has(rate) ? files::parse_finite(at(rate).Scalar()) : kLeastRate;
          !hz || *hz < kLeastRate || *hz > kLargestRate)
        fail(at(rate).Mark(), fmt::format("{}: expected a number of Hz from {} to {:.0f}, found \"{}\"", rate,
                                          kLeastRate, kLargestRate, at(rate).Scalar()));
  }

  YAML::Node at(const std::string& key) const {
    const YAML::Node node = root_.IsMap() ? root_[key] : YAML::Node(YAML::NodeType::Undefined);
    if (!node) throw files::FileError(file_, "has no key " + key);
    return node;
  }

  bool has(const std::string& key) const { return root_.IsMap() && root_[key]; }

  /// The first of two names that a key may have.
  const char* either(const char* key, const char* other) const {
    return !has(key) && has(other) ? other : key;
  }

  /// The keys that are not among those known.
  std::vector<std::string> others(const std::set<std::string>& known) const {
    std::vector<std::string> keys;
    for (const auto& entry : root_)
      if (const std::string& key = entry.first.Scalar(); !known.contains(key)) keys.push_back(key);
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
};

slam::Lens read_lens(const Yaml& yaml) {
  const YAML::Node model = yaml.at("distortion_model"),
                   coefficients = yaml.at(yaml.either("distortion_coefficients", "distortion_coeffs"));
  const std::string name = model.IsScalar() ? model.Scalar() : "";
  if (name == kOneParameter) return slam::OneParameterRadial{yaml.numbers(coefficients, 1)[0]};
  if (name != kRadialTangential && name != "radtan" && name != kEquidistant)
    yaml.fail(model.Mark(),
              fmt::format("expected {}, radtan, {} or {}", kRadialTangential, kEquidistant, kOneParameter));
  const std::vector<double> k = yaml.numbers(coefficients, 4);
  if (name == kEquidistant) return slam::Equidistant{k[0], k[1], k[2], k[3]};
  return slam::RadialTangential{k[0], k[1], k[2], k[3]};
}

}  // namespace

std::string camera_yaml(const RecordingSetup& setup) {
  const slam::CameraIntrinsics& camera = setup.calibration.camera;
  return head("camera", "head camera; body frame: the chest IMU") +
         matrix("T_BS", setup.calibration.X_CG.inverse()) + matrix("T_SB", setup.calibration.X_CG) +
         fmt::format(
             "rate_hz: {}\nresolution: [{}, {}]\ncamera_model: pinhole\nintrinsics: [{}, {}, {}, {}]\n{}",
             setup.camera_rate_hz, camera.width_px, camera.height_px, camera.fu_px, camera.fv_px,
             camera.u0_px, camera.v0_px, lens(camera.lens));
}

std::string imu_yaml(const RecordingSetup& setup, const std::optional<ImuNoise>& stated,
                     std::optional<slam::Stamp> begin) {
  const ImuNoise noise = stated.value_or(ImuNoise{});
  return head("imu", stated ? "chest IMU; +g up at rest"
                            : "chest IMU, ideal: means over (previous stamp, stamp]; +g up at rest") +
         matrix("T_BS", Eigen::Isometry3d::Identity()) +
         fmt::format(
             "rate_hz: {}\ngyroscope_noise_density: {}\ngyroscope_random_walk: {}\n"
             "accelerometer_noise_density: {}\naccelerometer_random_walk: {}\n",
             setup.imu_rate_hz, noise.gyro_density, noise.gyro_walk, noise.accelerometer_density,
             noise.accelerometer_walk) +
         (begin ? fmt::format("first_interval_begins_ns: {}\n", (kEpoch + *begin).count()) : "");
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

std::string body_yaml() {
  return std::string(kDirective) + "\ncomment: \"GaitSLAM humanoid; body frame: the chest IMU\"\n";
}

StatedCamera read_camera_yaml(const std::filesystem::path& file, const std::string& text,
                              RecordingSetup& setup) {
  const Yaml yaml(file, text);
  slam::CameraIntrinsics& camera = setup.calibration.camera;
  const auto resolution = yaml.numbers(yaml.at("resolution"), 2),
             intrinsics = yaml.numbers(yaml.at("intrinsics"), 4);
  for (const double side : resolution)
    if (side < kLeastSide || side > kLargestSide || side != std::floor(side))
      yaml.fail(yaml.at("resolution").Mark(),
                fmt::format("expected whole numbers from {} to {}", kLeastSide, kLargestSide));
  if (yaml.has("camera_model") && yaml.at("camera_model").Scalar() != "pinhole")
    yaml.fail(yaml.at("camera_model").Mark(), "expected pinhole");
  camera.width_px = static_cast<int>(resolution[0]), camera.height_px = static_cast<int>(resolution[1]);
  camera.fu_px = intrinsics[0], camera.fv_px = intrinsics[1], camera.u0_px = intrinsics[2],
  camera.v0_px = intrinsics[3];
  camera.lens = read_lens(yaml);
  try {
    slam::Camera{camera};
  } catch (const std::invalid_argument& error) {  // the filter rejects it
    throw files::FileError(file, error.what());
  }
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
  stated.unread =
      yaml.others({"sensor_type", "comment", "T_BS", "T_SB", "T_cam_imu", "T_imu_cam", "rate_hz",
                   "resolution", "camera_model", "intrinsics", "distortion_model", "distortion_coefficients",
                   "distortion_coeffs", "timeshift_cam_imu", "rostopic", "cam_overlaps"});
  return stated;
}

std::optional<slam::Stamp> read_imu_yaml(const std::filesystem::path& file, const std::string& text,
                                         RecordingSetup& setup) {
  const Yaml yaml(file, text);
  setup.imu_rate_hz = yaml.number(yaml.at("rate_hz"));
  if (text.find("first_interval_begins_ns") == text.npos) return std::nullopt;
  const YAML::Node begin = yaml.at("first_interval_begins_ns");
  const auto ns = files::parse_number<std::int64_t>(begin.IsScalar() ? begin.Scalar() : "");
  if (!ns || *ns < 0) yaml.fail(begin.Mark(), "expected an integer from 0");
  return slam::Stamp(*ns) - kEpoch;
}

MountedImu read_mounted_imu(const std::filesystem::path& file, const std::string& text) {
  const Yaml yaml(file, text);
  const auto density = [&](const char* key) {
    const double stated = yaml.has(key) ? yaml.number(yaml.at(key)) : 0;
    if (stated != 0 && !(stated >= 1e-9 && stated <= 1e3))
      yaml.fail(yaml.at(key).Mark(), "expected 0 or a number from 1e-9 to 1000");
    return stated;
  };
  MountedImu imu;
  if (yaml.has("T_BS") || !yaml.has("update_rate")) imu.X_BS = yaml.pose("T_BS");
  imu.rate_hz = yaml.number(yaml.at(yaml.either("rate_hz", "update_rate")));
  imu.noise = {density("gyroscope_noise_density"), density("gyroscope_random_walk"),
               density("accelerometer_noise_density"), density("accelerometer_random_walk")};
  imu.unread = yaml.others({"sensor_type", "comment", "T_BS", "rate_hz", "update_rate", "rostopic",
                            "gyroscope_noise_density", "gyroscope_random_walk", "accelerometer_noise_density",
                            "accelerometer_random_walk", "first_interval_begins_ns"});
  return imu;
}

Eigen::Isometry3d read_mounting(const std::filesystem::path& file, const std::string& text) {
  return Yaml(file, text).pose("T_BS");
}

void read_plan_yaml(const std::filesystem::path& file, const std::string& text, RecordingSetup& setup) {
  setup.X_WC_start = Yaml(file, text).pose("T_WC_start", false);
}

}  // namespace sim::recording
