#include "sim/recording/sensor_yaml.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cctype>
#include <set>
#include <type_traits>

#include "sim/files/yaml.h"
#include "slam/camera.h"

namespace sim::recording {
namespace {

using files::fail, files::Yaml;

// OpenCV's reader requires this directive on the first line.
constexpr const char* kDirective = "%YAML:1.0";
constexpr double kLeastRate = 1e-3, kLargestRate = 1e6;  // Hz
constexpr int kLeastSide = 32, kLargestSide = 8192;      // px of a camera, so that its images fit into memory
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

// Half a unit of the fourth digit in each number moves the residual of a rotation by up to 3e-4, and the
// residual of two such poses by up to 3e-4 and 3.3e-4 m + 1.5e-4 of their translation.
constexpr double kFewDigits = 3.1e-4;
bool agree(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.matrix() - b.matrix()).norm() <= 5e-4 * (1 + a.translation().norm());
}

// A parsed file. Members throw FileError with file, line and column.
class SensorFile {
 public:
  explicit SensorFile(const YamlFile& file)
      : name_(file.name), root_(parse_yaml(file.text, {file.name.string()}, files::YamlWriter::other)) {
    for (const char* chain : {"cam0", "imu0"})  // kalibr files have several sensors
      if (const Yaml* const first = root_.find(chain); first && first->is_map()) {
        root_ = Yaml(*first);
        break;
      }
    for (const char* rate : {"rate_hz", "update_rate"})
      if (const Yaml* const stated = root_.find(rate))
        if (const auto hz = files::parse_finite(stated->text); !hz || *hz < kLeastRate || *hz > kLargestRate)
          fail(*stated, rate, "expected a number of Hz from {} to {:.0f}, found \"{}\"", kLeastRate,
               kLargestRate, stated->text);
  }

  const Yaml* find(const std::string& key) const {
    asked_.insert(key);
    return root_.find(key);
  }
  const Yaml& at(const std::string& key) const {
    if (const Yaml* const value = find(key)) return *value;
    throw files::FileError(name_, "has no key " + key);
  }

  /// Returns which of two names of a key is used; if both are, their numbers must be the same.
  std::string either(const char* key, const char* other) const {
    const Yaml *const first = find(key), *const second = find(other);
    if (first && second && (first->is_list() ? numbers(key) != numbers(other) : number(key) != number(other)))
      fail(*second, other, "contradicts {} on line {}, expected only one of them", key, first->origin.line);
    return second && !first ? other : key;
  }

  /// Returns the keys that were not read, except those known to be irrelevant.
  std::vector<std::string> others() const {
    static const std::set<std::string> kKnown{"sensor_type", "comment", "rostopic", "cam_overlaps"};
    std::vector<std::string> keys;
    for (const Yaml& key : root_.keys)
      if (!asked_.contains(key.text) && !kKnown.contains(key.text)) keys.push_back(key.text);
    return keys;
  }

  double number(const std::string& key) const { return number(at(key), key); }
  std::vector<double> numbers(const std::string& key) const { return numbers(at(key), key); }
  std::vector<double> numbers(const std::string& key, std::size_t count) const {
    return numbers(at(key), key, count);
  }

  std::vector<std::string> names(const std::string& key) const {
    const Yaml& list = at(key);
    if (!list.is_list()) fail(list, key, "expected a list of sensors");
    std::vector<std::string> names;
    for (const Yaml& name : list.items) {
      if (!name.is_scalar()) fail(name, key, "expected the name of a sensor");
      names.push_back(name.text);
    }
    return names;
  }

  /// Reads 16 numbers in `data`, a list of them, or four rows. A rotation with few digits is made
  /// orthonormal.
  Eigen::Isometry3d pose(const std::string& key) const {
    const Yaml &node = at(key), *const data = node.is_map() ? node.find("data") : &node;
    if (!data || !data->is_list()) fail(node, key, "expected a matrix");
    std::vector<double> values;
    if (data->items.size() != 4) values = numbers(*data, key, 16);
    for (std::size_t row = 0; data->items.size() == 4 && row < 4; ++row)
      for (const double value : numbers(data->items[row], key, 4)) values.push_back(value);
    Eigen::Isometry3d X;
    X.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data());
    const double residual = (X.linear() * X.linear().transpose() - Eigen::Matrix3d::Identity()).norm();
    if (residual > kFewDigits || X.linear().determinant() < 0 ||
        X.matrix().row(3) != Eigen::RowVector4d(0, 0, 0, 1))
      fail(node, key, "not a pose: expected a rotation and a translation above the row 0 0 0 1");
    if (residual > 1e-9) X.linear() = Eigen::Quaterniond(X.linear()).normalized().toRotationMatrix();
    return X;
  }

  /// Returns the pose of a key, or the inverse of the pose of `inverse`; nothing if both are missing. If both
  /// are there, they must agree.
  std::optional<Eigen::Isometry3d> pose(const std::string& key, const std::string& inverse) const {
    const Yaml *const stated = find(key), *const other = find(inverse);
    if (!other) return stated ? std::optional(pose(key)) : std::nullopt;
    const Eigen::Isometry3d X = pose(inverse).inverse();
    if (!stated) return X;
    const Eigen::Isometry3d own = pose(key);
    if (!agree(own, X))
      fail(*other, inverse,
           "is not the inverse of {} on line {}: the rotations differ by {:.2g} deg, the positions "
           "by {:.2g} m; expected two that agree, or one",
           key, stated->origin.line,
           180 / M_PI * Eigen::AngleAxisd(own.linear().transpose() * X.linear()).angle(),
           (own.translation() - X.translation()).norm());
    return own;
  }

  const fs::path& name() const { return name_; }

 private:
  static double number(const Yaml& node, const std::string& key) {
    const auto value = files::parse_finite(node.text);
    if (!value) fail(node, key, "expected a finite number");
    return *value;
  }
  static std::vector<double> numbers(const Yaml& node, const std::string& key,
                                     std::optional<std::size_t> count = {}) {
    if (!node.is_list() || (count && node.items.size() != *count))
      fail(node, key, count ? fmt::format("expected {} numbers", *count) : "expected a list of numbers");
    std::vector<double> values;
    for (const Yaml& entry : node.items) values.push_back(number(entry, key));
    return values;
  }

  fs::path name_;
  Yaml root_;
  mutable std::set<std::string> asked_;
};

/// The names of distortion models, each with the kind of its lens; a name may stand for a lens without
/// coefficients.
enum class LensKind { one_parameter_radial, radial_tangential, equidistant, none };
constexpr std::pair<std::string_view, LensKind> kLensNames[]{{kLenses[0], LensKind::one_parameter_radial},
                                                             {kLenses[1], LensKind::radial_tangential},
                                                             {"radtan", LensKind::radial_tangential},
                                                             {"plumb_bob", LensKind::radial_tangential},
                                                             {kLenses[2], LensKind::equidistant},
                                                             {"equi", LensKind::equidistant},
                                                             {"kannala_brandt", LensKind::equidistant},
                                                             {"fisheye", LensKind::equidistant},
                                                             {"none", LensKind::none}};

// Ignores upper case, the kind of dashes, and the projection before the distortion, as in pinhole-equi.
std::optional<LensKind> lens_named(std::string_view name) {
  const auto plain = [](std::string_view word) {
    std::string text;
    for (const char c : word)
      if (std::isalnum(static_cast<unsigned char>(c))) text += char(std::tolower(c));
    return text;
  };
  std::string word = plain(name);
  if (word.starts_with("pinhole")) word.erase(0, std::string_view("pinhole").size());
  for (const auto& [known, kind] : kLensNames)
    if (plain(known) == word) return kind;
  return std::nullopt;
}

// Decides by camera_model (a pinhole, or the name of a lens) and distortion_model.
LensKind read_lens_kind(const SensorFile& file) {
  const Yaml *const model = file.find("camera_model"), *const distortion = file.find("distortion_model");
  std::optional<LensKind> kind;
  for (const auto& [node, key] : {std::pair(model, "camera_model"), {distortion, "distortion_model"}}) {
    if (!node || (node == model && node->text == "pinhole")) continue;
    const auto named = lens_named(node->text);
    if (!named) {
      std::string expected = node == model ? "pinhole" : "";
      for (const auto& [name, of] : kLensNames)
        expected += fmt::format("{}{}", expected.empty() ? "" : ", ", name);
      fail(*node, key, "found \"{}\", expected {}", node->text, expected);
    }
    if (kind && *kind != *named)
      fail(*node, key, "\"{}\" contradicts camera_model: {}", node->text, model->text);
    kind = named;
  }
  if (!kind) file.at("distortion_model");
  return *kind;
}

// A fifth coefficient is accepted if it is 0; so is any number of zeros without distortion.
slam::Lens read_lens(const SensorFile& file) {
  const LensKind kind = read_lens_kind(file);
  const std::string key = file.either("distortion_coefficients", "distortion_coeffs");
  if (kind == LensKind::one_parameter_radial) return slam::OneParameterRadial{file.numbers(key, 1)[0]};
  std::vector<double> k;
  if (kind != LensKind::none || (file.find(key) && file.at(key).kind != Yaml::Kind::empty))
    k = file.numbers(key);
  const std::size_t count = kind == LensKind::none ? 0 : 4;
  if (k.size() < count || k.size() > 5) fail(file.at(key), key, "expected 4 numbers, or a 0 after them");
  for (std::size_t i = count; i < k.size(); ++i)
    if (k[i] != 0)
      fail(file.at(key).items[i], key,
           count == 0 ? fmt::format("found {}, expected 0 without a distortion_model", k[i])
                      : fmt::format("coefficient 5 is {}, expected 0: only 4 coefficients are read", k[i]));
  if (kind == LensKind::none) return slam::RadialTangential{};
  if (kind == LensKind::equidistant) return slam::Equidistant{k[0], k[1], k[2], k[3]};
  return slam::RadialTangential{k[0], k[1], k[2], k[3]};
}

std::string intrinsics(const slam::CameraIntrinsics& camera) {
  return fmt::format(
      "resolution: [{}, {}]\ncamera_model: pinhole\nintrinsics: [{}, {}, {}, {}]\ndistortion_model: {}\n"
      "distortion_coefficients: [{}]\n",
      camera.width_px, camera.height_px, camera.fu_px, camera.fv_px, camera.u0_px, camera.v0_px,
      kLenses[camera.lens.index()], fmt::join(rig::coefficients(camera.lens), ", "));
}

slam::CameraIntrinsics read_intrinsics(const SensorFile& file) {
  const slam::Lens lens = read_lens(file);
  const auto resolution = file.numbers("resolution", 2), values = file.numbers("intrinsics", 4);
  for (const double side : resolution)
    if (side < kLeastSide || side > kLargestSide || side != std::floor(side))
      fail(file.at("resolution"), "resolution", "expected whole numbers from {} to {}", kLeastSide,
           kLargestSide);
  const slam::CameraIntrinsics camera{int(resolution[0]), int(resolution[1]), values[0], values[1],
                                      values[2],          values[3],          lens};
  try {
    slam::Camera{camera};
  } catch (const std::invalid_argument& error) {  // the filter rejects the camera
    throw files::FileError(file.name(), error.what());
  }
  return camera;
}

std::string first_interval(std::optional<slam::Stamp> begin) {
  return begin ? fmt::format("first_interval_begins_ns: {}\n", file_stamp(*begin)) : "";
}

std::optional<slam::Stamp> read_first_interval(const SensorFile& file) {
  constexpr const char* kKey = "first_interval_begins_ns";
  const Yaml* const begin = file.find(kKey);
  if (!begin) return std::nullopt;
  const auto ns = files::parse_number<std::int64_t>(begin->text);
  if (!ns || *ns < 0) fail(*begin, kKey, "expected an integer from 0");
  return slam::Stamp(*ns) - kEpoch;
}

// Calls take(key, number) for each noise number of an IMU.
void each_density(auto& noise, auto&& take) {
  take("gyroscope_noise_density", noise.gyro_density);
  take("gyroscope_random_walk", noise.gyro_walk);
  take("accelerometer_noise_density", noise.accelerometer_density);
  take("accelerometer_random_walk", noise.accelerometer_walk);
}

constexpr double kLargest = 1e6;  // for a sensor's numbers; rates have their own limits

// Calls take(key, number, lowest = 0, highest = kLargest) for each number that this kind of rig sensor has.
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

std::string motion_source_yaml(const MotionSource& source, const RecordingSetup& setup) {
  const bool plan = source.in == motion_sources()[0].in;
  return head(source.name.substr(0, source.name.size() - 1), source.comment) +
         fmt::format("rate_hz: {}\n", setup.camera_rate_hz) +
         (plan ? matrix("T_WC_start", setup.X_WC_start) : "") +
         (plan && !setup.calibration.level_floor ? "level_floor: false\n" : "");
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
                     fmt::format("kind: {}\n", rig::kKinds.at(std::size_t(sensor.kind)));
  if (rig::is_camera(sensor)) text += intrinsics(sensor.camera);
  if (sensor.kind == rig::Kind::depth) text += fmt::format("aligned_with: {}\n", sensor.aligned_with);
  each_number(sensor,
              [&](const char* key, auto value, auto...) { text += fmt::format("{}: {}\n", key, value); });
  return text + first_interval(begin);
}

std::vector<std::string> read_joints(const YamlFile& file) { return SensorFile(file).names("joints"); }

std::vector<std::string> read_body_yaml(const YamlFile& text) {
  const SensorFile file(text);
  if (!file.find("rig")) return {};
  const std::vector<std::string> names = file.names("rig");
  if (const auto found = rig::name_problem(names))
    fail(file.at("rig").items[found->item], "rig", found->what);
  return names;
}

std::pair<rig::RigSensor, std::optional<slam::Stamp>> read_rig_sensor_yaml(const YamlFile& text,
                                                                           const std::string& name) {
  const SensorFile file(text);
  std::pair<rig::RigSensor, std::optional<slam::Stamp>> read;
  auto& [sensor, begin] = read;
  sensor.name = name;
  const Yaml& kind = file.at("kind");
  const auto found = std::ranges::find(rig::kKinds, kind.text);
  if (found == rig::kKinds.end()) fail(kind, "kind", "expected one of {}", fmt::join(rig::kKinds, ", "));
  sensor.kind = static_cast<rig::Kind>(found - rig::kKinds.begin());
  sensor.X_CS = file.pose("T_CS");
  if (rig::is_camera(sensor)) sensor.camera = read_intrinsics(file);
  if (sensor.kind == rig::Kind::depth) sensor.aligned_with = file.at("aligned_with").text;
  each_number(sensor, [&](const char* key, auto& value, double lowest = 0, double highest = kLargest) {
    using Number = std::decay_t<decltype(value)>;
    const Yaml& node = file.at(key);
    const auto stated = files::parse_number<Number>(node.text);
    if (!stated || !(*stated >= lowest && *stated <= highest))
      fail(node, key, "expected {} from {} to {}", std::is_integral_v<Number> ? "a whole number" : "a number",
           lowest, highest);
    value = *stated;
  });
  if (sensor.nearest_m > sensor.furthest_m)
    fail(file.at("nearest_m"), "nearest_m", "{} is above furthest_m {}", sensor.nearest_m, sensor.furthest_m);
  if (sensor.kind == rig::Kind::imu) begin = read_first_interval(file);
  return read;
}

StatedCamera read_camera_yaml(const YamlFile& text, RecordingSetup& setup) {
  const SensorFile file(text);
  setup.calibration.camera = read_intrinsics(file);
  StatedCamera stated;
  stated.X_SB = file.pose("T_SB", "T_BS");
  stated.X_SI = file.pose("T_cam_imu", "T_imu_cam");
  if (!stated.X_SB && !stated.X_SI) file.at("T_BS");
  setup.calibration.X_CG = stated.X_SB ? *stated.X_SB : *stated.X_SI;
  if (stated.X_SB || file.find("rate_hz")) stated.rate_hz = setup.camera_rate_hz = file.number("rate_hz");
  constexpr const char* kShift = "timeshift_cam_imu";
  if (file.find(kShift)) stated.timeshift_s = file.number(kShift);
  if (std::abs(stated.timeshift_s) > 10)
    fail(file.at(kShift), kShift, "expected a number of seconds from -10 to 10");
  stated.unread = file.others();
  return stated;
}

StatedImu read_imu_yaml(const YamlFile& text) {
  const SensorFile file(text);
  StatedImu imu;
  if (const auto X_BS = file.pose("T_BS", "T_SB"))
    imu.X_BS = *X_BS;
  else if (!file.find("update_rate"))  // otherwise it is kalibr's
    file.at("T_BS");
  imu.rate_hz = file.number(file.either("rate_hz", "update_rate"));
  each_density(imu.noise, [&](const char* key, double& stated) {
    if (file.find(key)) stated = file.number(key);
    if (stated != 0 && !(stated >= 1e-9 && stated <= 1e3))
      fail(file.at(key), key, "expected 0 or a number from 1e-9 to 1000");
  });
  imu.begin = read_first_interval(file);
  imu.unread = file.others();
  return imu;
}

Eigen::Isometry3d read_pose(const YamlFile& text, const std::string& key, const std::string& inverse) {
  const SensorFile file(text);
  if (const auto X = file.pose(key, inverse)) return *X;
  return file.pose(key);
}

void read_plan_yaml(const YamlFile& text, RecordingSetup& setup) {
  const SensorFile file(text);
  setup.X_WC_start = file.pose("T_WC_start");
  const Yaml* const level = file.find("level_floor");
  if (level && level->text != "true" && level->text != "false")
    fail(*level, "level_floor", "expected true or false");
  setup.calibration.level_floor = !level || level->text == "true";
}

void require_same_mounting(const fs::path& camera_file, const StatedCamera& camera, const fs::path& imu_file,
                           const StatedImu& imu) {
  if (camera.X_SB && camera.X_SI && !agree(*camera.X_SI, *camera.X_SB * imu.X_BS))
    throw files::FileError(camera_file,
                           "T_cam_imu contradicts T_BS here and in {}, expected poses that agree, or one",
                           imu_file.string());
}

}  // namespace sim::recording
