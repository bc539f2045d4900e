#include "sim/recording/asl_folder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "sim/files/columns.h"
#include "sim/files/contained_path.h"
#include "sim/files/text.h"
#include "sim/recording/external_rows.h"
#include "sim/recording/image_file.h"
#include "sim/recording/recording_format.h"

namespace sim::recording {
namespace {

namespace fs = std::filesystem;
using namespace recording_format;

constexpr slam::Stamp kLongestGap{
    100'000'000};  // between true poses that are interpolated, and between readings that join
constexpr std::array kTruthFolders{"mav0/state_groundtruth_estimate0", "mav0/mocap0", "mav0/gt"};

constexpr std::size_t kCameraColumns = 2, kImuColumns = 4, kPlanColumns = 23, kTruthColumns = 8;

/// The columns of an IMU; no accelerometer if the header names the gyro but not it.
struct ImuColumns {
  explicit ImuColumns(const files::Header& header)
      : gyro(header.columns(files::Quantity::angular_rate, "xyz", 1)) {
    using files::Quantity;
    if (header.names(Quantity::acceleration) || (header.size() >= 7 && !header.names(Quantity::angular_rate)))
      accelerometer = header.columns(Quantity::acceleration, "xyz", 4);
  }
  std::vector<files::Column> gyro, accelerometer;
};

// Readings of an IMU one after another. Each applies until halfway to its neighbors.
class Readings {
 public:
  Readings(const fs::path& file, Stamps stamps, slam::Stamp ahead)
      : rows_(file, kImuColumns, std::move(stamps)), columns_(rows_.header()), ahead_(ahead) {
    read();
  }

  /// Moves the readings before `until` into the observation.
  void move_to(slam::Stamp until, slam::Observation& o) {
    while (now_ && now_->begin < until) {
      const slam::Stamp end = std::min(now_->end, until);
      o.gyro.push_back({now_->begin, end, now_->gyro});
      if (now_->accelerometer) o.accelerometer.push_back({now_->begin, end, *now_->accelerometer});
      now_->begin = end;
      if (end == now_->end) read();
    }
  }

 private:
  struct Reading {
    slam::Stamp t, begin, end;
    Eigen::Vector3d gyro;
    std::optional<Eigen::Vector3d> accelerometer;
  };

  void read() {
    const std::optional<Reading> before = now_;
    now_.reset();
    if (!rows_.stamp()) return;
    Reading reading{*rows_.stamp() - ahead_, {}, {}, angular_rate(rows_.row(), columns_.gyro), std::nullopt};
    if (!columns_.accelerometer.empty())
      reading.accelerometer = acceleration(rows_.row(), columns_.accelerometer);
    rows_.advance();
    const auto half = [&](slam::Stamp gap) { return std::min(gap, kLongestGap) / 2; };
    const slam::Stamp ahead = rows_.stamp() ? *rows_.stamp() - ahead_ - reading.t : half_ * 2;
    const slam::Stamp behind = before ? reading.t - before->t : ahead;
    reading.begin = before && behind <= kLongestGap ? before->end : reading.t - half(behind);
    reading.end = reading.t + half(ahead);
    half_ = half(ahead);
    now_ = reading;
  }

  ExternalRows rows_;
  ImuColumns columns_;
  slam::Stamp ahead_;
  std::optional<Reading> now_;
  slam::Stamp half_{2'500'000};  // of the gap ahead of the last reading
};

// Rotation from the mean of the accelerometer's first readings to the z axis.
Eigen::Matrix3d upright(const fs::path& imu_rows, const Eigen::Matrix3d& R_CG) {
  files::CsvReader rows(imu_rows, kImuColumns);
  const ImuColumns columns(header_of(imu_rows, rows));
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < 20 && !columns.accelerometer.empty() && rows.next(); ++i)
    sum += acceleration(rows, columns.accelerometer);
  if (sum.isZero()) return Eigen::Matrix3d::Identity();
  return Eigen::Quaterniond::FromTwoVectors(R_CG * sum, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

std::string sensor_text(const fs::path& file) { return files::read_text(file, files::kMostOfYaml); }

// A sensor.yaml, or the calibration file of kalibr that stands for it.
fs::path sensor_file(const fs::path& folder, const std::string& own, const char* kalibr) {
  if (!fs::exists(folder / own))
    for (const char* place : {".", "dso", "mav0"})
      if (fs::exists(folder / place / kalibr)) return folder / place / kalibr;
  return folder / own;
}

void remark(AslSensors& sensors, const fs::path& file, const std::vector<std::string>& unread) {
  if (unread.empty()) return;
  sensors.remarks.push_back(
      fmt::format("{}: keys that are not read: {}", file.string(), fmt::join(unread, ", ")));
}

struct ReadSensors : AslSensors {
  explicit ReadSensors(const fs::path& folder) {
    const fs::path camera_file = sensor_file(folder, kCameraSensor, "camchain.yaml"),
                   imu_file = sensor_file(folder, kImuSensor, "imu_config.yaml");
    const StatedCamera stated = read_camera_yaml(camera_file, sensor_text(camera_file), setup);
    const MountedImu mounted = read_mounted_imu(imu_file, sensor_text(imu_file));
    remark(*this, camera_file, stated.unread);
    remark(*this, imu_file, mounted.unread);
    setup.imu_rate_hz = mounted.rate_hz;
    noise = mounted.noise;
    const Eigen::Isometry3d X_SC = setup.calibration.X_CG.inverse();
    X_BC = stated.by_imu ? mounted.X_BS * X_SC : X_SC;
    setup.calibration.X_CG = X_BC.inverse() * mounted.X_BS;
    imu_ahead = slam::Stamp(std::llround(1e9 * stated.timeshift_s));
    camera = stamps_of(folder / kCameraRows, kCameraColumns, {stated.rate_hz, 4});
    if (camera.all.empty()) throw files::FileError(folder / kCameraRows, "has no images");
    first_image = camera.all.front();
    imu = stamps_of(folder / kImuRows, kImuColumns, {mounted.rate_hz, 1.5});
    require_one_clock(folder);
    has_plan = fs::exists(folder / kPlanRows);
    if (has_plan)
      read_plan_yaml(folder / kPlanSensor, sensor_text(folder / kPlanSensor), setup);
    else
      setup.X_WC_start.linear() = upright(folder / kImuRows, setup.calibration.X_CG.linear());
  }

  void require_one_clock(const fs::path& folder) const {
    constexpr slam::Stamp kBefore = std::chrono::seconds(1);  // of a single image
    const slam::Stamp from = camera.all.size() > 1 ? first_image : first_image - kBefore;
    const auto between = [&](slam::Stamp t) {
      return t - imu_ahead >= from && t - imu_ahead <= camera.all.back();
    };
    if (!std::any_of(imu.all.begin(), imu.all.end(), between))
      throw files::FileError(
          folder / kImuRows,
          imu.all.empty()
              ? "has no readings"
              : fmt::format("none of its readings is between the images: they are {}, the images {}; "
                            "expected one clock",
                            imu.span(), camera.span()));
  }

  Stamps camera, imu;
};

// Each image of the list must exist.
void require_images(const fs::path& folder) {
  for (files::CsvReader rows(folder / kCameraRows, kCameraColumns); rows.next();) {
    const fs::path file = files::contained_path(folder / kCameraFolder, rows.text(1));
    if (!fs::is_regular_file(file)) rows.fail(1, "no such image: " + file.string());
  }
}

/// The columns of a true pose: position, and orientation with w first.
struct PoseColumns {
  explicit PoseColumns(const files::Header& header)
      : p(header.columns(files::Quantity::position, "xyz", 1)),
        q(header.columns(files::Quantity::orientation, "wxyz", 4)) {}
  std::vector<files::Column> p, q;
};

files::TimedPose true_pose(const ExternalRows& rows, const PoseColumns& columns) {
  const files::CsvReader& row = rows.row();
  const auto& [p, q] = columns;
  const auto at = [&](const files::Column& column) { return column.factor * row.number(column.field); };
  files::TimedPose pose{*rows.stamp(), Eigen::Isometry3d::Identity()};
  const Eigen::Quaterniond orientation(at(q[0]), at(q[1]), at(q[2]), at(q[3]));
  if (std::abs(orientation.norm() - 1) > 1e-2) row.fail(q[0].field, "the quaternion is not of length 1");
  pose.X = Eigen::Translation3d(at(p[0]), at(p[1]), at(p[2])) * orientation.normalized();
  return pose;
}

Eigen::Isometry3d interpolate(const files::TimedPose& a, const files::TimedPose& b, slam::Stamp t) {
  const double part = slam::seconds(t - a.t) / slam::seconds(b.t - a.t);
  const Eigen::Vector3d p = (1 - part) * a.X.translation() + part * b.X.translation();
  const Eigen::Quaterniond qa(a.X.linear()), qb(b.X.linear());
  return Eigen::Translation3d(p) * qa.slerp(part, qb);
}

std::optional<fs::path> truth_folder(const fs::path& folder) {
  for (const char* name : kTruthFolders)
    if (fs::exists(folder / name / "data.csv")) return folder / name;
  return std::nullopt;
}

// Why a truth has no pose at any of the times.
std::string why_none(const Stamps& truth, const std::vector<slam::Stamp>& times) {
  if (truth.all.empty()) return "has no poses";
  if (truth.all.back() < times.front() || truth.all.front() > times.back())
    return fmt::format(
        "none of its poses is near the time of an image: they are {}, the images from {} to {}", truth.span(),
        seconds_text(times.front()), seconds_text(times.back()));
  return fmt::format(
      "its poses are more than {} s apart around each image, too far to interpolate between them",
      slam::seconds(kLongestGap));
}

// Poses of the truth's body at the given times of the recording's clock.
std::vector<files::TimedPose> interpolated(const fs::path& file, const std::vector<slam::Stamp>& times) {
  std::vector<files::TimedPose> poses;
  const Stamps stamps = stamps_of(file, kTruthColumns);
  ExternalRows rows(file, kTruthColumns, stamps);
  const PoseColumns columns(rows.header());
  std::optional<files::TimedPose> before;
  for (auto t = times.begin(); rows.stamp(); rows.advance()) {  // to the end: each row is checked
    const files::TimedPose now = true_pose(rows, columns);
    for (; t != times.end() && *t <= now.t; ++t) {
      if (*t == now.t)
        poses.push_back(now);
      else if (before && now.t - before->t <= kLongestGap)
        poses.push_back({*t, interpolate(*before, now, *t)});
    }
    before = now;
  }
  if (poses.empty()) throw files::FileError(file, why_none(stamps, times));
  return poses;
}

}  // namespace

struct AslFolder::Files {
  explicit Files(const fs::path& folder_) : folder(folder_) {
    require_images(folder);
    for (const slam::Stamp t : sensors.camera.all) times.push_back(t - sensors.first_image);
    if (!sensors.has_plan) return;
    const Stamps planned = stamps_of(folder / kPlanRows, kPlanColumns);
    const auto is_of_image = [&](slam::Stamp t) {
      return std::binary_search(sensors.camera.all.begin(), sensors.camera.all.end(), t);
    };
    if (!planned.all.empty() && std::none_of(planned.all.begin(), planned.all.end(), is_of_image))
      throw files::FileError(folder / kPlanRows,
                             fmt::format("none of its stamps is that of an image: they are {}, the images {}",
                                         planned.span(), sensors.camera.span()));
    plan.emplace(folder / kPlanRows, kPlanColumns, planned);
  }

  fs::path folder;
  ReadSensors sensors{folder};
  std::vector<slam::Stamp> times;
  ExternalRows camera{folder / kCameraRows, kCameraColumns, sensors.camera};
  Readings readings{folder / kImuRows, sensors.imu, sensors.imu_ahead};
  std::optional<ExternalRows> plan;

  cv::Mat image() const {
    const fs::path file = files::contained_path(folder / kCameraFolder, camera.row().text(1));
    const slam::CameraIntrinsics& size = sensors.setup.calibration.camera;
    return decode_image(file, files::read_text(file, files::kMostOfImage), {size.width_px, size.height_px},
                        cv::IMREAD_GRAYSCALE);
  }
};

AslFolder::AslFolder(const fs::path& folder) : files_(std::make_unique<Files>(folder)) {}
AslFolder::~AslFolder() = default;

const AslSensors& AslFolder::sensors() const { return files_->sensors; }

const std::vector<slam::Stamp>& AslFolder::times() const { return files_->times; }

double AslFolder::part() const { return files_->camera.row().part(); }

std::optional<slam::Observation> AslFolder::next() {
  Files& f = *files_;
  if (!f.camera.stamp()) return std::nullopt;
  const slam::Stamp t = *f.camera.stamp();
  slam::Observation o;
  o.t = t - f.sensors.first_image;
  o.image = f.image();
  f.readings.move_to(t, o);
  for (auto* samples : {&o.gyro, &o.accelerometer})
    for (slam::InertialSample& sample : *samples)
      sample.begin -= f.sensors.first_image, sample.end -= f.sensors.first_image;
  while (f.plan && f.plan->stamp() && *f.plan->stamp() < t) f.plan->advance();
  if (f.plan && f.plan->stamp() == t) o.plan = read_plan_row(f.plan->row());
  f.camera.advance();
  return o;
}

bool is_asl_folder(const fs::path& folder) { return fs::exists(folder / "mav0"); }

std::vector<files::TimedPose> read_asl_truth(const fs::path& folder, const AslSensors& sensors,
                                             const std::vector<slam::Stamp>& times) {
  const auto truth = truth_folder(folder);
  if (!truth) return {};
  const slam::Stamp start = sensors.first_image;
  std::vector<slam::Stamp> own_clock;
  for (const slam::Stamp t : times) own_clock.push_back(t + start);
  Eigen::Isometry3d X_BS = Eigen::Isometry3d::Identity();
  if (fs::exists(*truth / "sensor.yaml"))
    X_BS = read_mounting(*truth / "sensor.yaml", sensor_text(*truth / "sensor.yaml"));
  std::vector<files::TimedPose> poses = interpolated(*truth / "data.csv", own_clock);
  const Eigen::Isometry3d X_SC = X_BS.inverse() * sensors.X_BC,
                          X_WT = sensors.setup.X_WC_start * (poses.front().X * X_SC).inverse();
  for (files::TimedPose& pose : poses) pose = {pose.t - start, X_WT * pose.X * X_SC};
  return poses;
}

}  // namespace sim::recording
