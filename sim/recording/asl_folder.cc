#include "sim/recording/asl_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <opencv2/imgcodecs.hpp>

#include "sim/files/contained_path.h"
#include "sim/files/text.h"
#include "sim/recording/image_file.h"
#include "sim/recording/recording_format.h"

namespace sim::recording {
namespace {

namespace fs = std::filesystem;
using namespace recording_format;

constexpr slam::Stamp kLongestGap{
    100'000'000};  // between true poses that are interpolated, and between readings that join
constexpr std::array kTruthFolders{"mav0/state_groundtruth_estimate0", "mav0/mocap0", "mav0/gt"};

StampedRows rows_of(const fs::path& file, std::size_t least_columns) {
  return StampedRows(files::CsvReader(file, least_columns));
}

slam::Stamp first_stamp(const fs::path& rows) {
  const StampedRows first = rows_of(rows, 2);
  if (!first.stamp()) throw files::FileError(rows, "has no images");
  return *first.stamp();
}

// Readings of an IMU one after another. Each applies until halfway to its neighbors.
class Readings {
 public:
  explicit Readings(const fs::path& file) : rows_(rows_of(file, 4)) { read(); }

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
    Reading reading{*rows_.stamp(), {}, {}, angular_rate(rows_.row()), std::nullopt};
    if (rows_.row().fields() >= 7) reading.accelerometer = acceleration(rows_.row());
    rows_.advance();
    const auto half = [&](slam::Stamp gap) { return std::min(gap, kLongestGap) / 2; };
    const slam::Stamp ahead = rows_.stamp() ? *rows_.stamp() - reading.t : half_ * 2;
    const slam::Stamp behind = before ? reading.t - before->t : ahead;
    reading.begin = before && behind <= kLongestGap ? before->end : reading.t - half(behind);
    reading.end = reading.t + half(ahead);
    half_ = half(ahead);
    now_ = reading;
  }

  StampedRows rows_;
  std::optional<Reading> now_;
  slam::Stamp half_{2'500'000};  // of the gap ahead of the last reading
};

// Rotation from the mean of the accelerometer's first readings to the z axis.
Eigen::Matrix3d upright(const fs::path& imu_rows, const Eigen::Matrix3d& R_CG) {
  StampedRows rows = rows_of(imu_rows, 4);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < 20 && rows.stamp() && rows.row().fields() >= 7; ++i, rows.advance())
    sum += acceleration(rows.row());
  if (sum.isZero()) return Eigen::Matrix3d::Identity();
  return Eigen::Quaterniond::FromTwoVectors(R_CG * sum, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

std::string sensor_text(const fs::path& file) { return files::read_text(file, files::kMostOfYaml); }

AslSensors read_sensors(const fs::path& folder) {
  AslSensors sensors;
  RecordingSetup& setup = sensors.setup;
  read_camera_yaml(folder / kCameraSensor, sensor_text(folder / kCameraSensor), setup);
  const MountedImu imu = read_mounted_imu(folder / kImuSensor, sensor_text(folder / kImuSensor));
  setup.imu_rate_hz = imu.rate_hz;
  sensors.noise = imu.noise;
  sensors.X_BC = setup.calibration.X_CG.inverse();
  setup.calibration.X_CG = setup.calibration.X_CG * imu.X_BS;
  sensors.has_plan = fs::exists(folder / kPlanRows);
  if (sensors.has_plan)
    read_plan_yaml(folder / kPlanSensor, sensor_text(folder / kPlanSensor), setup);
  else
    setup.X_WC_start.linear() = upright(folder / kImuRows, setup.calibration.X_CG.linear());
  return sensors;
}

files::TimedPose true_pose(const files::CsvReader& row) {
  files::TimedPose pose{slam::Stamp(row.integer(0)), Eigen::Isometry3d::Identity()};
  const Eigen::Quaterniond q(row.number(4), row.number(5), row.number(6), row.number(7));
  if (std::abs(q.norm() - 1) > 1e-2) row.fail(4, "the quaternion is not of length 1");
  pose.X = Eigen::Translation3d(row.vector(1)) * q.normalized();
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

// Poses of the truth's body at the given times of the recording's clock.
std::vector<files::TimedPose> interpolated(const fs::path& file, const std::vector<slam::Stamp>& times) {
  std::vector<files::TimedPose> poses;
  StampedRows rows = rows_of(file, 8);
  std::optional<files::TimedPose> before;
  for (auto t = times.begin(); rows.stamp() && t != times.end(); rows.advance()) {
    const files::TimedPose now = true_pose(rows.row());
    for (; t != times.end() && *t <= now.t; ++t) {
      if (*t == now.t)
        poses.push_back(now);
      else if (before && now.t - before->t <= kLongestGap)
        poses.push_back({*t, interpolate(*before, now, *t)});
    }
    before = now;
  }
  return poses;
}

}  // namespace

struct AslFolder::Files {
  explicit Files(const fs::path& folder_) : folder(folder_) {
    if (sensors.has_plan) plan.emplace(files::CsvReader(folder / kPlanRows, 23));
  }

  fs::path folder;
  AslSensors sensors{read_sensors(folder)};
  slam::Stamp start{first_stamp(folder / kCameraRows)};
  StampedRows camera = rows_of(folder / kCameraRows, 2);
  Readings readings{folder / kImuRows};
  bool any_reading = false;
  std::optional<StampedRows> plan;

  cv::Mat image() const {
    const fs::path file = files::contained_path(folder / kCameraFolder, camera.row().text(1));
    if (!fs::is_regular_file(file)) camera.row().fail(1, "no such image: " + file.string());
    const slam::CameraIntrinsics& size = sensors.setup.calibration.camera;
    return decode_image(file, files::read_text(file, files::kMostOfImage), {size.width_px, size.height_px},
                        cv::IMREAD_GRAYSCALE);
  }
};

AslFolder::AslFolder(const fs::path& folder) : files_(std::make_unique<Files>(folder)) {}
AslFolder::~AslFolder() = default;

const AslSensors& AslFolder::sensors() const { return files_->sensors; }

double AslFolder::part() const { return files_->camera.row().part(); }

std::optional<slam::Observation> AslFolder::next() {
  Files& f = *files_;
  if (!f.camera.stamp()) {
    if (!f.any_reading)
      throw files::FileError(f.folder / kImuRows,
                             "none of its readings is from before or between the images");
    return std::nullopt;
  }
  const slam::Stamp t = *f.camera.stamp();
  slam::Observation o;
  o.t = t - f.start;
  o.image = f.image();
  f.readings.move_to(t, o);
  f.any_reading |= !o.gyro.empty();
  for (auto* samples : {&o.gyro, &o.accelerometer})
    for (slam::InertialSample& sample : *samples) sample.begin -= f.start, sample.end -= f.start;
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
  const slam::Stamp start = first_stamp(folder / kCameraRows);
  std::vector<slam::Stamp> own_clock;
  for (const slam::Stamp t : times) own_clock.push_back(t + start);
  Eigen::Isometry3d X_BS = Eigen::Isometry3d::Identity();
  if (fs::exists(*truth / "sensor.yaml"))
    X_BS = read_mounting(*truth / "sensor.yaml", sensor_text(*truth / "sensor.yaml"));
  std::vector<files::TimedPose> poses = interpolated(*truth / "data.csv", own_clock);
  if (poses.empty())
    throw files::FileError(*truth / "data.csv", "none of its poses is near the time of an image");
  const Eigen::Isometry3d X_SC = X_BS.inverse() * sensors.X_BC,
                          X_WT = sensors.setup.X_WC_start * (poses.front().X * X_SC).inverse();
  for (files::TimedPose& pose : poses) pose = {pose.t - start, X_WT * pose.X * X_SC};
  return poses;
}

}  // namespace sim::recording
