#include "sim/recording/asl_folder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/recording/image_file.h"

namespace sim::recording {
namespace {

using namespace recording_format;

/// Largest gap between true poses that are interpolated, and between adjoining readings.
constexpr slam::Stamp kLongestGap{100'000'000};
/// From kLeastOffset, an offset or jump of a clock causes a remark; from kMostOffset_s, an offset is
/// rejected.
constexpr slam::Stamp kLeastOffset{15'000'000};
constexpr double kMostOffset_s = 0.1;
/// A truth that starts at most this much after an image is treated as starting with it, because stamps may be
/// rounded.
constexpr slam::Stamp kSameTime{100'000};
constexpr std::array kTruthFolders{"mav0/state_groundtruth_estimate0", "mav0/mocap0", "mav0/gt",
                                   "mav0/vicon0", "mav0/leica0"};

std::string span_text(slam::Stamp first, slam::Stamp last) {
  return fmt::format("from {:.3f} s to {:.3f} s", slam::seconds(first), slam::seconds(last));
}

/// Adds a remark about the largest step between stamps if it is out of proportion, because a clock was set or
/// rows are missing.
void add_leap(std::vector<std::string>& remarks, const fs::path& file, const std::vector<slam::Stamp>& stamps,
              const std::vector<std::size_t>& lines) {
  const slam::Stamp usual = files::median_step(stamps), most = usual + std::max(2 * usual, kLeastOffset);
  std::size_t leap = 0, leaps = 0;
  const auto step = [&](std::size_t i) { return i == 0 ? slam::Stamp(0) : stamps[i] - stamps[i - 1]; };
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    leaps += step(i) > most;
    if (step(i) > step(leap)) leap = i;
  }
  if (leaps == 0) return;
  remarks.push_back(fmt::format(
      "{}:{}: its clock leaps by {:.6g} s from the previous row, or rows are missing; they come every "
      "{:.4g} s{}",
      file.string(), lines[leap], slam::seconds(step(leap)), slam::seconds(usual),
      leaps > 1 ? fmt::format("; the largest of {} such steps", leaps) : ""));
}

/// The rows of a sensor or of a motion and their stamps.
struct Stamps : files::Table {
  /// rate_hz: as stated in a sensor.yaml. slack: maximum ratio of rate_hz to the rate of the rows, because
  /// cameras skip frames.
  Stamps(const fs::path& name, Expected expected, std::optional<double> rate_hz = {}, double slack = 1)
      : Table(name, expected) {
    const auto stamp_columns = required(files::Quantity::time);
    std::vector<std::size_t> lines;
    for (const files::TableRow& row : rows()) {
      if (row.fields() != width()) row.fail("expected {} fields, found {}", width(), row.fields());
      const slam::Stamp t = stamp(row, stamp_columns);
      if (t.count() < 0) row.fail(stamp_columns[0].field, "expected a stamp from 0");
      if (!all.empty() && t <= all.back())
        row.fail(stamp_columns[0].field, "{}", files::not_rising(all.back(), t));
      all.push_back(t);
      lines.push_back(row.line());
    }
    add_leap(remarks, file(), all, lines);
    const double step_s = slam::seconds(files::median_step(all));
    if (step_s == 0 || !rate_hz) return;
    const double ratio = *rate_hz * step_s;
    const std::string differs =
        fmt::format("its rows come at {:.4g} Hz, its sensor.yaml states rate_hz: {}", 1 / step_s, *rate_hz);
    if (ratio > slack || ratio < 1 / 1.5) throw files::FileError(file(), differs);
    if (std::abs(ratio - 1) > 0.1) remarks.push_back(fmt::format("{}: {}", file().string(), differs));
  }

  std::string span() const { return span_text(all.front(), all.back()); }  ///< there must be stamps

  std::vector<slam::Stamp> all;
  std::vector<std::string> remarks;
};

/// A reading of an IMU and the interval to which it applies.
struct Reading {
  slam::Stamp t, begin, end;
  Eigen::Vector3d gyro;
  std::optional<Eigen::Vector3d> accelerometer;
};

/// Returns the readings of an IMU whose clock is ahead. Each reading applies up to halfway to its neighbors.
std::vector<Reading> readings_of(const Stamps& imu, slam::Stamp ahead) {
  const auto gyro = imu.required(files::Quantity::angular_rate),
             accelerometer = imu.columns(files::Quantity::acceleration);
  std::vector<Reading> all;
  for (const files::TableRow& row : imu.rows()) {
    all.push_back({imu.all[all.size()] - ahead, {}, {}, angular_rate(row, gyro), std::nullopt});
    if (!accelerometer.empty()) all.back().accelerometer = acceleration(row, accelerometer);
  }
  slam::Stamp half{2'500'000};  // half the gap before the last reading
  for (std::size_t i = 0; i < all.size(); ++i) {
    Reading& now = all[i];
    if (i + 1 < all.size()) half = std::min(all[i + 1].t - now.t, kLongestGap) / 2;
    const bool joins = i > 0 && now.t - all[i - 1].t <= kLongestGap;
    now.begin = joins ? all[i - 1].end : now.t - (i > 0 ? kLongestGap / 2 : half);
    now.end = now.t + half;
  }
  return all;
}

/// Returns the shortest rotation that turns a direction to the vertical. Eigen's FromTwoVectors gives the
/// same except for a direction straight down, but its singular value decomposition takes eight seconds to
/// compile.
Eigen::Matrix3d turn_upwards(const Eigen::Vector3d& direction) {
  const Eigen::Vector3d from = direction.normalized(), up = Eigen::Vector3d::UnitZ();
  if (from.z() < -1 + 1e-12) return Eigen::Vector3d(1, -1, -1).asDiagonal();
  const double s = std::sqrt((1 + from.z()) * 2);
  Eigen::Quaterniond turn;
  turn.w() = s * 0.5;
  turn.vec() = from.cross(up) * (1 / s);
  return turn.toRotationMatrix();
}

// The mean of the accelerometer's first readings.
Eigen::Vector3d first_acceleration(const std::vector<Reading>& readings) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const std::size_t count = std::min<std::size_t>(20, readings.size());
  for (std::size_t i = 0; i < count; ++i) sum += readings[i].accelerometer.value_or(Eigen::Vector3d::Zero());
  return sum / std::max(1.0, double(count));
}

std::string expected_motion(const files::Table&) {
  return "the columns of this project's plan0, legs0 and command0, as README.md in sim/recording states them";
}

Eigen::Isometry3d first_pose(const fs::path& motion) {
  const Stamps rows(motion, expected_motion);
  if (rows.width() < 13) throw files::FileError(motion, "has no pose");
  return rows.rows()[0].pose(1);
}

YamlFile yaml(const fs::path& file) { return {file, files::read_text(file, files::kMostOfYaml)}; }

// Returns the path of a sensor.yaml, or of the kalibr calibration file that replaces it.
fs::path calibration_file(const fs::path& folder, const std::string& own, const char* kalibr) {
  if (!fs::exists(folder / own))
    for (const char* place : {".", "dso", "mav0"})
      if (fs::exists(folder / place / kalibr)) return folder / place / kalibr;
  return folder / own;
}

std::optional<fs::path> truth_folder(const fs::path& folder) {
  for (const char* const name : kTruthFolders)
    if (fs::exists(folder / name / "data.csv")) return folder / name;
  return std::nullopt;
}

struct ReadSensors : AslSensors {
  explicit ReadSensors(const fs::path& folder) {
    const fs::path camera_file = calibration_file(folder, sensor_file("cam0"), "camchain.yaml"),
                   imu_file = calibration_file(folder, sensor_file("imu0"), "imu_config.yaml");
    const StatedCamera stated = read_camera_yaml(yaml(camera_file), setup);
    const StatedImu mounted = read_imu_yaml(yaml(imu_file));
    require_same_mounting(camera_file, stated, imu_file, mounted);
    for (const auto& [file, unread] : {std::pair(camera_file, stated.unread), {imu_file, mounted.unread}})
      if (!unread.empty())
        remarks.push_back(fmt::format("{}: ignored keys: {}", file.string(), fmt::join(unread, ", ")));
    setup.imu_rate_hz = mounted.rate_hz;
    noise = mounted.noise;
    const Eigen::Isometry3d X_SC = setup.calibration.X_CG.inverse();
    X_BC = stated.X_SB ? X_SC : mounted.X_BS * X_SC;
    setup.calibration.X_CG = X_BC.inverse() * mounted.X_BS;
    imu_ahead = slam::Stamp(std::llround(1e9 * stated.timeshift_s));
    const auto expected_images = [](const files::Table&) { return kCameraHeader + " and one image a row"; };
    camera.emplace(folder / sensor_rows("cam0"), expected_images, stated.rate_hz, 4);
    if (camera->all.empty()) throw files::FileError(camera->file(), "has no images");
    first_image = camera->all.front();
    const auto expected_readings = [](const files::Table&) {
      return "a header with names and units, such as " + kImuHeader;
    };
    imu.emplace(folder / sensor_rows("imu0"), expected_readings, mounted.rate_hz, 1.5);
    require_one_clock();
    for (const Stamps* const rows : {&*camera, &*imu})
      std::ranges::copy(rows->remarks, std::back_inserter(remarks));
    readings = readings_of(*imu, imu_ahead);
    const Eigen::Vector3d a_G = first_acceleration(readings);
    if (!a_G.isZero() && std::abs(a_G.norm() - slam::kGravity) > slam::kGravity / 3)
      remarks.push_back(fmt::format(
          "{}: the acceleration is {:.3g} m/s^2 at first, expected about 9.81; a header can state its unit",
          imu->file().string(), a_G.norm()));
    has_motion = std::ranges::any_of(motion_sources(), [&](const MotionSource& source) {
      return fs::exists(folder / sensor_rows(source.name));
    });
    const fs::path plan = folder / sensor_file("plan0"), legs = folder / sensor_rows("legs0");
    if (fs::exists(plan))
      read_plan_yaml(yaml(plan), setup);
    else if (fs::exists(legs))
      setup.X_WC_start = first_pose(legs);
    else if (!a_G.isZero())  // it points up
      setup.X_WC_start.linear() = turn_upwards(setup.calibration.X_CG.linear() * a_G);
    else
      remarks.push_back(imu->file().string() +
                        ": no accelerations: the vertical is unknown, and yaw is about the optical axis");
  }

  void require_one_clock() const {
    constexpr slam::Stamp kBefore = std::chrono::seconds(1);  // for a single image
    const slam::Stamp from = camera->all.size() > 1 ? first_image : first_image - kBefore;
    for (const slam::Stamp t : imu->all)
      if (t - imu_ahead >= from && t - imu_ahead <= camera->all.back()) return;
    throw files::FileError(
        imu->file(), imu->all.empty()
                         ? "has no readings"
                         : fmt::format("none of its readings is between the images: they are {}, the images "
                                       "{}; expected one clock",
                                       imu->span(), camera->span()));
  }

  std::optional<Stamps> camera, imu;
  std::vector<Reading> readings;
};

// Returns the files in the list. Each must exist.
std::vector<fs::path> images_of(const fs::path& folder, const Stamps& list) {
  std::vector<fs::path> all;
  const std::size_t field = list.columns(files::Quantity::time).size();  // after the stamp
  if (list.width() <= field) list.fail("no column contains the file name");
  for (const files::TableRow& rows : list.rows()) {
    all.push_back(files::contained_path(folder / sensor_data("cam0"), rows.text(field)));
    if (!fs::is_regular_file(all.back())) rows.fail(field, "no such image: {}", all.back().string());
  }
  return all;
}

// Compares the gyro with the truth. Throws FileError if their clocks or units differ, and adds remarks
// about what may be wrong.
void require_rotation_of_imu(const fs::path& file, const files::TrajectoryFile& truth,
                             const std::vector<Reading>& readings, const fs::path& imu, AslSensors& sensors) {
  constexpr double kMostGain = 2, kUsualGain = 0.2, kSure = 0.9;
  if (!truth.has_orientation) return;
  std::vector<TimedRotation> gyro;
  for (const Reading& reading : readings) gyro.push_back({reading.t, reading.gyro});
  const auto found = compare_gyro(gyro, truth.rows);
  if (!found) {
    sensors.remarks.push_back(
        fmt::format("{}: the clock of its gyro cannot be checked: it turns too little, or "
                    "unlike {}",
                    imu.string(), file.string()));
    return;
  }
  const bool same_unit = found->gain < kMostGain && found->gain > 1 / kMostGain;
  if (!same_unit && found->correlation > kSure)  // otherwise noise of the truth lowers the gain
    throw files::FileError(
        imu,
        "its rotation speeds are {:.3g} times the speeds in {}: expected rad/s, or a header with "
        "their unit, such as w_RS_S_x [deg s^-1]",
        found->gain, file.string());
  if (std::abs(found->gain - 1) > kUsualGain && found->correlation > kSure)
    sensors.remarks.push_back(
        fmt::format("{}: its rotation speeds are {:.3g} times the speeds in {}: its scale is wrong",
                    imu.string(), found->gain, file.string()));
  const double late_s = -found->late_s;  // delay of the truth
  const std::string late = fmt::format("{:.2f} s {} {}", std::abs(late_s),
                                       late_s > 0 ? "later than" : "earlier than", imu.string());
  if (std::abs(late_s) >= kMostOffset_s)
    throw files::FileError(
        file,
        "its stamps are {}: shifted by that, the rotation speeds correlate by {:.2f}, as "
        "stamped by {:.2f}; expected one clock (timeshift_cam_imu of the camera corrects an IMU's){}{}",
        late, found->correlation, found->as_stamped, sensors.remarks.empty() ? "" : "; ",
        fmt::join(sensors.remarks, "; "));
  if (std::abs(late_s) < slam::seconds(kLeastOffset)) return;
  sensors.remarks.push_back(
      fmt::format("{}: the truth is {}: errors of orientation and the NEES include it if the images have the "
                  "IMU's clock; if they have the truth's clock, state timeshift_cam_imu: {:.3f} in the "
                  "camera's file",
                  file.string(), late, slam::seconds(sensors.imu_ahead) - late_s));
}

// Poses of the truth's body at the given times of the recording's clock.
std::vector<files::TimedPose> interpolated(const fs::path& file, const files::TrajectoryFile& truth,
                                           const std::vector<slam::Stamp>& times) {
  std::vector<files::TimedPose> poses;
  auto t = times.begin();
  for (std::size_t i = 0; i < truth.rows.size(); ++i)
    for (const files::TimedPose& now = truth.rows[i]; t != times.end() && *t <= now.t; ++t) {
      if (now.t - *t <= (i == 0 ? kSameTime : slam::Stamp(0)))
        poses.push_back({*t, now.X});
      else if (i > 0 && now.t - truth.rows[i - 1].t <= kLongestGap)
        poses.push_back({*t, files::interpolate(truth.rows[i - 1], now, *t)});
    }
  if (!poses.empty()) return poses;
  const slam::Stamp first = truth.rows.front().t, last = truth.rows.back().t;
  if (last < times.front() || first > times.back())
    throw files::FileError(file, "none of its poses is near the time of an image: they are {}, the images {}",
                           span_text(first, last), span_text(times.front(), times.back()));
  throw files::FileError(
      file, "its poses are more than {} s apart around each image, too far to interpolate between them",
      slam::seconds(kLongestGap));
}

}  // namespace

struct AslFolder::Files {
  explicit Files(const fs::path& folder_) : folder(folder_) {
    for (const slam::Stamp t : stamps) times.push_back(t - sensors.first_image);
    read_truth();
    for (std::size_t i = 0; i < sources.size(); ++i)
      if (const fs::path file = folder / sensor_rows(motion_sources()[i].name); fs::exists(file)) {
        const Stamps& rows = sources[i].emplace(file, expected_motion);
        if (rows.all.empty()) continue;
        const auto is_of_image = [&](slam::Stamp t) { return std::ranges::binary_search(stamps, t); };
        if (rows.width() < std::size_t(std::ranges::count(motion_sources()[i].header, ',')) + 1)
          rows.fail("columns are missing");
        if (std::ranges::none_of(rows.all, is_of_image))
          throw files::FileError(file, "none of its stamps matches an image: they are {}, the images {}",
                                 rows.span(), sensors.camera->span());
      }
  }

  void read_truth();

  fs::path folder;
  ReadSensors sensors{folder};
  const std::vector<slam::Stamp>& stamps = sensors.camera->all;  // stamps of the images
  const cv::Size size{sensors.setup.calibration.camera.width_px, sensors.setup.calibration.camera.height_px};
  std::vector<fs::path> images = images_of(folder, *sensors.camera);
  std::vector<slam::Stamp> times;
  Truth truth;
  std::size_t next_image = 0, next_reading = 0;
  std::array<std::optional<Stamps>, 3> sources;  // in the order of motion_sources()

  slam::Observation next() {
    const slam::Stamp start = sensors.first_image, t = stamps[next_image];
    const fs::path& file = images[next_image++];
    slam::Observation o;
    o.t = t - start;
    o.image = decode_image(file, files::read_text(file, files::kMostOfImage), size);
    for (auto& all = sensors.readings; next_reading < all.size() && all[next_reading].begin < t;) {
      Reading& now = all[next_reading];
      const slam::Stamp begin = std::exchange(now.begin, std::min(now.end, t));
      o.gyro.push_back({begin - start, now.begin - start, now.gyro});
      if (now.accelerometer)
        o.accelerometer.push_back({begin - start, now.begin - start, *now.accelerometer});
      if (now.begin == now.end) ++next_reading;
    }
    for (std::size_t i = 0; i < sources.size(); ++i) {
      if (!sources[i]) continue;
      const auto& all = sources[i]->all;
      const auto row = std::ranges::lower_bound(all, t);
      if (row != all.end() && *row == t)
        motion_sources()[i].read(sources[i]->rows()[std::size_t(row - all.begin())], o);
    }
    return o;
  }
};

void AslFolder::Files::read_truth() {
  const auto found = truth_folder(folder);
  if (!found) {
    sensors.remarks.push_back(fmt::format("{}: no truth: none of {} contains a data.csv", folder.string(),
                                          fmt::join(kTruthFolders, ", ")));
    return;
  }
  const fs::path name = *found / "data.csv", mounting = *found / "sensor.yaml";
  const files::TrajectoryFile file = files::read_trajectory(name);
  if (file.warning) sensors.remarks.push_back(fmt::format("{}: {}", name.string(), *file.warning));
  std::vector<slam::Stamp> own_clock;
  std::vector<std::size_t> lines;
  for (const files::TumRow& row : file.rows) own_clock.push_back(row.t), lines.push_back(row.line);
  add_leap(sensors.remarks, name, own_clock, lines);
  Eigen::Isometry3d X_BT = Eigen::Isometry3d::Identity();
  if (fs::exists(mounting)) X_BT = read_pose(yaml(mounting), "T_BS", "T_SB");
  require_rotation_of_imu(name, file, sensors.readings, sensors.imu->file(), sensors);
  truth.camera = interpolated(name, file, stamps);
  Eigen::Isometry3d X_TC = X_BT.inverse() * sensors.X_BC,
                    X_WT = sensors.setup.X_WC_start * (truth.camera.front().X * X_TC).inverse();
  if (!file.has_orientation) {
    truth.positions_of = X_TC.inverse().translation();
    X_WT = X_TC = Eigen::Isometry3d::Identity();
  }
  for (files::TimedPose& pose : truth.camera) pose = {pose.t - sensors.first_image, X_WT * pose.X * X_TC};
}

AslFolder::AslFolder(const fs::path& folder) : files_(std::make_unique<Files>(folder)) {}
AslFolder::~AslFolder() = default;

const fs::path& AslFolder::folder() const { return files_->folder; }

const AslSensors& AslFolder::sensors() const { return files_->sensors; }

const Truth& AslFolder::truth() const { return files_->truth; }

const std::vector<slam::Stamp>& AslFolder::times() const { return files_->times; }

double AslFolder::part() const { return double(files_->next_image) / double(files_->images.size()); }

std::optional<slam::Observation> AslFolder::next() {
  if (files_->next_image == files_->images.size()) return std::nullopt;
  return files_->next();
}

bool is_asl_folder(const fs::path& folder) { return fs::exists(folder / "mav0"); }

}  // namespace sim::recording
