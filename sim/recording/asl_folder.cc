#include "sim/recording/asl_folder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "sim/files/columns.h"
#include "sim/files/text.h"
#include "sim/recording/clock_offset.h"
#include "sim/recording/image_file.h"
#include "sim/recording/recording_format.h"

namespace sim::recording {
namespace {

namespace fs = std::filesystem;
using namespace recording_format;

/// Between true poses that are interpolated, and between readings that join.
constexpr slam::Stamp kLongestGap{100'000'000};
constexpr std::array kTruthFolders{"mav0/state_groundtruth_estimate0", "mav0/mocap0", "mav0/gt",
                                   "mav0/vicon0", "mav0/leica0"};

constexpr std::size_t kCameraColumns = 2, kImuColumns = 4, kPlanColumns = 23;

std::string span_text(slam::Stamp first, slam::Stamp last) {
  return fmt::format("from {:.3f} s to {:.3f} s", slam::seconds(first), slam::seconds(last));
}

/// All stamps of a file, in the unit that fits them, and its rows.
struct Stamps {
  /// rate_hz: as a sensor.yaml states it; slack: how many times as high as that of the rows it may be, since
  /// cameras skip frames.
  Stamps(fs::path file_, std::size_t least_columns_, std::optional<double> rate_hz = {}, double slack = 1)
      : file(std::move(file_)),
        least_columns(least_columns_),
        header(file, 1, files::CsvReader(file, least_columns).titles()),
        columns(header.stamp_columns()) {
    std::vector<double> numbers;
    files::CsvReader csv(file, least_columns);
    while (csv.next()) numbers.push_back(columns.number(csv, columns.unit ? *columns.unit : *unit));
    unit = &files::unit_of_stamps(file, numbers, columns.unit, 1 / rate_hz.value_or(20));
    for (StampedRows again = rows(); again.stamp(); again.advance()) all.push_back(*again.stamp());
    const auto step = files::median_step(numbers);
    if (!step || !rate_hz) return;
    const double hz = 1e9 / (*step * static_cast<double>(unit->ns)), ratio = *rate_hz / hz;
    const std::string differs =
        fmt::format("its rows come at {:.4g} Hz, its sensor.yaml states rate_hz: {}", hz, *rate_hz);
    if (ratio > slack || ratio < 1 / 1.5) throw files::FileError(file, differs);
    if (std::abs(ratio - 1) > 0.1) remark = fmt::format("{}: {}", file.string(), differs);
  }

  StampedRows rows() const {
    return StampedRows(files::CsvReader(file, least_columns), slam::Stamp{0}, columns, *unit);
  }
  /// The first column that is not part of the stamp.
  std::size_t next_field() const {
    std::size_t field = 0;
    while (field == columns.field || field == columns.rest) ++field;
    return field;
  }
  std::string span() const { return span_text(all.front(), all.back()); }  ///< there must be stamps

  fs::path file;
  std::size_t least_columns;
  files::Header header;
  files::StampColumns columns;
  const files::TimeUnit* unit = &files::kNanoseconds;
  std::vector<slam::Stamp> all;
  std::string remark;  ///< of a rate that differs from the stated one, but may be
};

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
  Readings(const Stamps& stamps, slam::Stamp ahead)
      : rows_(stamps.rows()), columns_(stamps.header), ahead_(ahead) {
    read();
  }

  /// Moves the readings before `until` into the observation, whose clock starts at `start`.
  void move_to(slam::Stamp until, slam::Stamp start, slam::Observation& o) {
    while (now_ && now_->begin < until) {
      const slam::Stamp begin = now_->begin, end = std::min(now_->end, until);
      o.gyro.push_back({begin - start, end - start, now_->gyro});
      if (now_->accelerometer) o.accelerometer.push_back({begin - start, end - start, *now_->accelerometer});
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
    const std::optional<Reading> before = std::exchange(now_, std::nullopt);
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

  StampedRows rows_;
  ImuColumns columns_;
  slam::Stamp ahead_;
  std::optional<Reading> now_;
  slam::Stamp half_{2'500'000};  // of the gap ahead of the last reading
};

/// The shortest turn of a direction to the vertical. Eigen's FromTwoVectors, the same but for a direction
/// straight down, takes eight seconds to compile for its singular value decomposition.
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
Eigen::Vector3d first_acceleration(const Stamps& imu) {
  files::CsvReader rows(imu.file, kImuColumns);
  const ImuColumns columns(imu.header);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (; count < 20 && !columns.accelerometer.empty() && rows.next(); ++count)
    sum += acceleration(rows, columns.accelerometer);
  return sum / std::max(1, count);
}

YamlFile yaml(const fs::path& file) { return {file, files::read_text(file, files::kMostOfYaml)}; }

// A sensor.yaml, or the calibration file of kalibr that stands for it.
fs::path calibration_file(const fs::path& folder, const std::string& own, const char* kalibr) {
  if (!fs::exists(folder / own))
    for (const char* place : {".", "dso", "mav0"})
      if (fs::exists(folder / place / kalibr)) return folder / place / kalibr;
  return folder / own;
}

// The folder of the truth, if there is one.
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
    for (const auto& [file, unread] : {std::pair(camera_file, stated.unread), {imu_file, mounted.unread}})
      if (!unread.empty())
        remarks.push_back(
            fmt::format("{}: keys that are not read: {}", file.string(), fmt::join(unread, ", ")));
    if (!truth_folder(folder))
      remarks.push_back(fmt::format("{}: no truth: data.csv is in none of {}", folder.string(),
                                    fmt::join(kTruthFolders, ", ")));
    else if (const fs::path file = *truth_folder(folder) / "data.csv"; true)
      if (const std::string doubt = files::read_trajectory(file).warning; !doubt.empty())
        remarks.push_back(fmt::format("{}: {}", file.string(), doubt));
    setup.imu_rate_hz = mounted.rate_hz;
    noise = mounted.noise;
    const Eigen::Isometry3d X_SC = setup.calibration.X_CG.inverse();
    X_BC = stated.by_imu ? mounted.X_BS * X_SC : X_SC;
    setup.calibration.X_CG = X_BC.inverse() * mounted.X_BS;
    imu_ahead = slam::Stamp(std::llround(1e9 * stated.timeshift_s));
    camera.emplace(folder / sensor_rows("cam0"), kCameraColumns, stated.rate_hz, 4);
    if (camera->all.empty()) throw files::FileError(camera->file, "has no images");
    first_image = camera->all.front();
    imu.emplace(folder / sensor_rows("imu0"), kImuColumns, mounted.rate_hz, 1.5);
    require_one_clock();
    if (!imu->header.names(files::Quantity::angular_rate))
      remarks.push_back(imu->file.string() +
                        ": no column is named as an angular rate; columns 2 to 4 are taken for it, in rad/s");
    for (const Stamps* const rows : {&*camera, &*imu})
      if (!rows->remark.empty()) remarks.push_back(rows->remark);
    const Eigen::Vector3d a_G = first_acceleration(*imu);
    if (!a_G.isZero() && std::abs(a_G.norm() - slam::kGravity) > slam::kGravity / 3)
      remarks.push_back(fmt::format(
          "{}: the acceleration is {:.3g} m/s^2 at first, expected about 9.81; a header may state its unit",
          imu->file.string(), a_G.norm()));
    has_plan = fs::exists(folder / sensor_rows("plan0"));
    if (has_plan)
      setup.X_WC_start = read_pose(yaml(folder / sensor_file("plan0")), "T_WC_start", false);
    else if (!a_G.isZero())  // it points up
      setup.X_WC_start.linear() = turn_upwards(setup.calibration.X_CG.linear() * a_G);
  }

  void require_one_clock() const {
    constexpr slam::Stamp kBefore = std::chrono::seconds(1);  // of a single image
    const slam::Stamp from = camera->all.size() > 1 ? first_image : first_image - kBefore;
    for (const slam::Stamp t : imu->all)
      if (t - imu_ahead >= from && t - imu_ahead <= camera->all.back()) return;
    throw files::FileError(
        imu->file, imu->all.empty()
                       ? "has no readings"
                       : fmt::format("none of its readings is between the images: they are {}, the images "
                                     "{}; expected one clock",
                                     imu->span(), camera->span()));
  }

  std::optional<Stamps> camera, imu;
};

// Each image of the list must exist.
void require_images(const fs::path& folder, const Stamps& images) {
  for (files::CsvReader rows(images.file, kCameraColumns); rows.next();) {
    const std::size_t field = images.next_field();
    const fs::path file = files::contained_path(folder / sensor_data("cam0"), rows.text(field));
    if (!fs::is_regular_file(file)) rows.fail(field, "no such image: " + file.string());
  }
}

Eigen::Isometry3d interpolate(const files::TimedPose& a, const files::TimedPose& b, slam::Stamp t) {
  const double part = slam::seconds(t - a.t) / slam::seconds(b.t - a.t);
  const Eigen::Vector3d p = (1 - part) * a.X.translation() + part * b.X.translation();
  const Eigen::Quaterniond qa(a.X.linear()), qb(b.X.linear());
  return Eigen::Translation3d(p) * qa.slerp(part, qb);
}

// Throws FileError if the speeds of rotation show that gyro and truth have different clocks or units.
void require_rotation_of_imu(const fs::path& file, const files::TrajectoryFile& truth, const fs::path& folder,
                             slam::Stamp ahead) {
  constexpr double kMost_s = 0.1, kMostGain = 2, kSure = 0.9;
  if (!truth.has_orientation) return;
  const Stamps imu(folder / sensor_rows("imu0"), kImuColumns);
  const ImuColumns columns(imu.header);
  std::vector<TimedRotation> gyro;
  for (StampedRows rows = imu.rows(); rows.stamp(); rows.advance())
    gyro.push_back({*rows.stamp() - ahead, angular_rate(rows.row(), columns.gyro)});
  const auto offset = clock_offset(gyro, truth.rows);
  if (!offset) return;
  const bool same_unit = offset->gain < kMostGain && offset->gain > 1 / kMostGain;
  if (!same_unit && offset->correlation > kSure)  // else noise of the truth lowers the gain
    throw files::FileError(
        imu.file,
        fmt::format("its speeds of rotation are {:.3g} times those of {}: expected rad/s, or a header "
                    "with their unit, as in w_RS_S_x [deg s^-1]",
                    offset->gain, file.string()));
  if (std::abs(offset->late_s) < kMost_s) return;
  throw files::FileError(
      file,
      fmt::format("its stamps are {:.2f} s {} than those of {}: shifted by that, the speeds of rotation "
                  "correlate by {:.2f}, as stamped by {:.2f}; expected one clock (timeshift_cam_imu of the "
                  "camera corrects an IMU's)",
                  std::abs(offset->late_s), offset->late_s > 0 ? "earlier" : "later", imu.file.string(),
                  offset->correlation, offset->as_stamped));
}

// Poses of the truth's body at the given times of the recording's clock.
std::vector<files::TimedPose> interpolated(const fs::path& file, const files::TrajectoryFile& truth,
                                           const std::vector<slam::Stamp>& times) {
  std::vector<files::TimedPose> poses;
  auto t = times.begin();
  for (std::size_t i = 0; i < truth.rows.size(); ++i)
    for (const files::TimedPose& now = truth.rows[i]; t != times.end() && *t <= now.t; ++t) {
      if (*t == now.t)
        poses.push_back(now);
      else if (i > 0 && now.t - truth.rows[i - 1].t <= kLongestGap)
        poses.push_back({*t, interpolate(truth.rows[i - 1], now, *t)});
    }
  if (!poses.empty()) return poses;
  const slam::Stamp first = truth.rows.front().t, last = truth.rows.back().t;
  if (last < times.front() || first > times.back())
    throw files::FileError(
        file, fmt::format("none of its poses is near the time of an image: they are {}, the images {}",
                          span_text(first, last), span_text(times.front(), times.back())));
  throw files::FileError(
      file,
      fmt::format("its poses are more than {} s apart around each image, too far to interpolate between them",
                  slam::seconds(kLongestGap)));
}

}  // namespace

struct AslFolder::Files {
  explicit Files(const fs::path& folder_) : folder(folder_) {
    require_images(folder, *sensors.camera);
    const std::vector<slam::Stamp>& images = sensors.camera->all;
    for (const slam::Stamp t : images) times.push_back(t - sensors.first_image);
    if (!sensors.has_plan) return;
    const Stamps planned(folder / sensor_rows("plan0"), kPlanColumns);
    const auto is_of_image = [&](slam::Stamp t) { return std::ranges::binary_search(images, t); };
    if (!planned.all.empty() && std::ranges::none_of(planned.all, is_of_image))
      throw files::FileError(planned.file,
                             fmt::format("none of its stamps is that of an image: they are {}, the images {}",
                                         planned.span(), sensors.camera->span()));
    plan.emplace(files::CsvReader(planned.file, kPlanColumns), slam::Stamp{0}, planned.columns,
                 *planned.unit);
  }

  fs::path folder;
  ReadSensors sensors{folder};
  std::vector<slam::Stamp> times;
  StampedRows camera = sensors.camera->rows();
  Readings readings{*sensors.imu, sensors.imu_ahead};
  std::optional<StampedRows> plan;

  cv::Mat image() const {
    const fs::path file =
        files::contained_path(folder / sensor_data("cam0"), camera.row().text(sensors.camera->next_field()));
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
  f.readings.move_to(t, f.sensors.first_image, o);
  while (f.plan && f.plan->stamp() && *f.plan->stamp() < t) f.plan->advance();
  if (f.plan && f.plan->stamp() == t) o.plan = read_plan_row(f.plan->row());
  f.camera.advance();
  return o;
}

bool is_asl_folder(const fs::path& folder) { return fs::exists(folder / "mav0"); }

Truth read_asl_truth(const fs::path& folder, const AslSensors& sensors,
                     const std::vector<slam::Stamp>& times) {
  const auto found = truth_folder(folder);
  if (!found) return {};
  const slam::Stamp start = sensors.first_image;
  std::vector<slam::Stamp> own_clock;
  for (const slam::Stamp t : times) own_clock.push_back(t + start);
  Eigen::Isometry3d X_BS = Eigen::Isometry3d::Identity();
  if (const fs::path file = *found / "sensor.yaml"; fs::exists(file)) X_BS = read_pose(yaml(file), "T_BS");
  const files::TrajectoryFile file = files::read_trajectory(*found / "data.csv");
  require_rotation_of_imu(*found / "data.csv", file, folder, sensors.imu_ahead);
  Truth truth;
  truth.camera = interpolated(*found / "data.csv", file, own_clock);
  Eigen::Isometry3d X_SC = X_BS.inverse() * sensors.X_BC,
                    X_WT = sensors.setup.X_WC_start * (truth.camera.front().X * X_SC).inverse();
  if (!file.has_orientation) {
    truth.positions_of = X_SC.inverse().translation();
    X_WT = X_SC = Eigen::Isometry3d::Identity();
  }
  for (files::TimedPose& pose : truth.camera) pose = {pose.t - start, X_WT * pose.X * X_SC};
  return truth;
}

}  // namespace sim::recording
