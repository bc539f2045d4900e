#include "sim/recording/asl_folder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>

#include "sim/recording/image_file.h"

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

/// A reading of an IMU and the time that it applies to.
struct Reading {
  slam::Stamp t, begin, end;
  Eigen::Vector3d gyro;
  std::optional<Eigen::Vector3d> accelerometer;
};

/// The readings of an IMU whose clock is ahead. Each applies until halfway to its neighbors.
std::vector<Reading> readings_of(const Stamps& imu, slam::Stamp ahead) {
  using files::Quantity;
  const files::Header& header = imu.header;
  const auto gyro = header.columns(Quantity::angular_rate, "xyz", 1);
  std::vector<files::Column> accelerometer;  // none if the header names the gyro but not it
  if (header.names(Quantity::acceleration) || (header.size() >= 7 && !header.names(Quantity::angular_rate)))
    accelerometer = header.columns(Quantity::acceleration, "xyz", 4);
  std::vector<Reading> all;
  for (StampedRows rows = imu.rows(); rows.stamp(); rows.advance()) {
    all.push_back({*rows.stamp() - ahead, {}, {}, angular_rate(rows.row(), gyro), std::nullopt});
    if (!accelerometer.empty()) all.back().accelerometer = acceleration(rows.row(), accelerometer);
  }
  slam::Stamp half{2'500'000};  // of the gap ahead of the last reading
  for (std::size_t i = 0; i < all.size(); ++i) {
    Reading& now = all[i];
    if (i + 1 < all.size()) half = std::min(all[i + 1].t - now.t, kLongestGap) / 2;
    const bool joins = i > 0 && now.t - all[i - 1].t <= kLongestGap;
    now.begin = joins ? all[i - 1].end : now.t - (i > 0 ? kLongestGap / 2 : half);
    now.end = now.t + half;
  }
  return all;
}

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
Eigen::Vector3d first_acceleration(const std::vector<Reading>& readings) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const std::size_t count = std::min<std::size_t>(20, readings.size());
  for (std::size_t i = 0; i < count; ++i) sum += readings[i].accelerometer.value_or(Eigen::Vector3d::Zero());
  return sum / std::max(1.0, static_cast<double>(count));
}

YamlFile yaml(const fs::path& file) { return {file, files::read_text(file, files::kMostOfYaml)}; }

// A sensor.yaml, or the calibration file of kalibr that stands for it.
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
    for (const auto& [file, unread] : {std::pair(camera_file, stated.unread), {imu_file, mounted.unread}})
      if (!unread.empty())
        remarks.push_back(
            fmt::format("{}: keys that are not read: {}", file.string(), fmt::join(unread, ", ")));
    if (!truth_folder(folder))
      remarks.push_back(fmt::format("{}: no truth: data.csv is in none of {}", folder.string(),
                                    fmt::join(kTruthFolders, ", ")));
    else if (const fs::path file = *truth_folder(folder) / "data.csv"; true)
      if (const auto doubt = files::read_trajectory(file).warning)
        remarks.push_back(fmt::format("{}: {}", file.string(), *doubt));
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
    readings = readings_of(*imu, imu_ahead);
    const Eigen::Vector3d a_G = first_acceleration(readings);
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
  std::vector<Reading> readings;
};

// The files of the list. Each must exist.
std::vector<fs::path> images_of(const fs::path& folder, const Stamps& list) {
  std::vector<fs::path> all;
  for (files::CsvReader rows(list.file, kCameraColumns); rows.next();) {
    const std::size_t field = list.next_field();
    all.push_back(files::contained_path(folder / sensor_data("cam0"), rows.text(field)));
    if (!fs::is_regular_file(all.back())) rows.fail(field, "no such image: " + all.back().string());
  }
  return all;
}

Eigen::Isometry3d interpolate(const files::TimedPose& a, const files::TimedPose& b, slam::Stamp t) {
  const double part = slam::seconds(t - a.t) / slam::seconds(b.t - a.t);
  const Eigen::Vector3d p = (1 - part) * a.X.translation() + part * b.X.translation();
  const Eigen::Quaterniond qa(a.X.linear()), qb(b.X.linear());
  return Eigen::Translation3d(p) * qa.slerp(part, qb);
}

constexpr slam::Stamp kStep{20'000'000}, kBridged{100'000'000}, kHour = std::chrono::hours(1);
constexpr int kWindow = 5, kMostLag = 500, kFewest = 50;  // steps
constexpr double kLeastCorrelation = 0.6, kMostCorrelation = 0.9995, kDecisive = 15;

using Turns = std::vector<std::optional<Eigen::Vector3d>>;

/// Returns the turn from each time of a grid until a window later, if it is known.
Turns turns(const std::vector<files::TumRow>& poses, slam::Stamp begin, std::size_t size) {
  std::vector<std::optional<Eigen::Quaterniond>> at(size);
  std::size_t next = 1;
  for (std::size_t k = 0; k < size; ++k) {
    const slam::Stamp t = begin + static_cast<std::int64_t>(k) * kStep;
    while (next < poses.size() && poses[next].t < t) ++next;
    if (next >= poses.size()) break;
    const files::TumRow &a = poses[next - 1], &b = poses[next];
    if (a.t <= t && b.t - a.t <= kBridged)
      at[k] = Eigen::Quaterniond(a.X.linear())
                  .slerp(slam::seconds(t - a.t) / slam::seconds(b.t - a.t), Eigen::Quaterniond(b.X.linear()));
  }
  Turns all(size);
  for (std::size_t k = 0; k + kWindow < size; ++k)
    if (at[k] && at[k + kWindow]) {
      const Eigen::AngleAxisd turn(at[k]->conjugate() * *at[k + kWindow]);
      all[k] = turn.angle() * turn.axis();
    }
  return all;
}

struct Correlation {
  double r = 0, gain = 0;
  int pairs = 0;
  /// Log-likelihood of the linear relation, relative to none; of as many speeds as windows.
  double evidence(double of_r) const {
    return 0.5 * pairs / kWindow * -std::log1p(-std::pow(std::clamp(of_r, 0.0, 1 - 1e-12), 2));
  }
};

/// Correlates the angles turned after subtraction of the mean turns, which removes a bias.
Correlation correlation(const Turns& truth, const Turns& gyro, int lag) {
  const auto size = static_cast<int>(truth.size());
  const auto for_each_pair = [&](const auto& f) {
    for (int k = std::max(0, -lag); k < size - std::max(0, lag); ++k) {
      const auto &a = truth[static_cast<std::size_t>(k)], &b = gyro[static_cast<std::size_t>(k + lag)];
      if (a && b) f(*a, *b);
    }
  };
  Correlation c;
  Eigen::Vector3d truth_sum = Eigen::Vector3d::Zero(), gyro_sum = truth_sum;
  for_each_pair([&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    truth_sum += a, gyro_sum += b;
    ++c.pairs;
  });
  if (c.pairs < kFewest) return c;
  const Eigen::Vector3d truth_mean = truth_sum / c.pairs, gyro_mean = gyro_sum / c.pairs;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  for_each_pair([&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const Eigen::Vector2d pair((a - truth_mean).norm(), (b - gyro_mean).norm());
    sum += pair;
    squares += pair * pair.transpose();
  });
  const Eigen::Matrix2d S = squares - sum * sum.transpose() / c.pairs;
  if (S(0, 0) > 1e-12 && S(1, 1) > 1e-12) {
    c.r = S(0, 1) / std::sqrt(S(0, 0) * S(1, 1));
    c.gain = S(0, 1) / S(0, 0);
  }
  return c;
}

// Throws FileError if the speeds of rotation show that gyro and truth have different clocks or units.
void require_rotation_of_imu(const fs::path& file, const files::TrajectoryFile& truth, const fs::path& folder,
                             slam::Stamp ahead) {
  constexpr double kMost_s = 0.1, kMostGain = 2, kSure = 0.9;
  if (!truth.has_orientation) return;
  const Stamps imu(folder / sensor_rows("imu0"), kImuColumns);
  std::vector<TimedRotation> gyro;
  for (const Reading& reading : readings_of(imu, ahead)) gyro.push_back({reading.t, reading.gyro});
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
    for (const slam::Stamp t : stamps) times.push_back(t - sensors.first_image);
    if (!sensors.has_plan) return;
    const Stamps planned(folder / sensor_rows("plan0"), kPlanColumns);
    const auto is_of_image = [&](slam::Stamp t) { return std::ranges::binary_search(stamps, t); };
    if (!planned.all.empty() && std::ranges::none_of(planned.all, is_of_image))
      throw files::FileError(planned.file,
                             fmt::format("none of its stamps is that of an image: they are {}, the images {}",
                                         planned.span(), sensors.camera->span()));
    plan.emplace(files::CsvReader(planned.file, kPlanColumns), slam::Stamp{0}, planned.columns,
                 *planned.unit);
  }

  fs::path folder;
  ReadSensors sensors{folder};
  const std::vector<slam::Stamp>& stamps = sensors.camera->all;  // of the images
  std::vector<fs::path> images = images_of(folder, *sensors.camera);
  std::vector<slam::Stamp> times;
  std::size_t next_image = 0, next_reading = 0;
  std::optional<StampedRows> plan;

  slam::Observation next() {
    const slam::Stamp start = sensors.first_image, t = stamps[next_image];
    const slam::CameraIntrinsics& size = sensors.setup.calibration.camera;
    const fs::path& file = images[next_image++];
    slam::Observation o;
    o.t = t - start;
    o.image = decode_image(file, files::read_text(file, files::kMostOfImage), {size.width_px, size.height_px},
                           cv::IMREAD_GRAYSCALE);
    for (auto& all = sensors.readings; next_reading < all.size() && all[next_reading].begin < t;) {
      Reading& now = all[next_reading];
      const slam::Stamp begin = std::exchange(now.begin, std::min(now.end, t));
      o.gyro.push_back({begin - start, now.begin - start, now.gyro});
      if (now.accelerometer)
        o.accelerometer.push_back({begin - start, now.begin - start, *now.accelerometer});
      if (now.begin == now.end) ++next_reading;
    }
    while (plan && plan->stamp() && *plan->stamp() < t) plan->advance();
    if (plan && plan->stamp() == t) o.plan = read_plan_row(plan->row());
    return o;
  }
};

AslFolder::AslFolder(const fs::path& folder) : files_(std::make_unique<Files>(folder)) {}
AslFolder::~AslFolder() = default;

const AslSensors& AslFolder::sensors() const { return files_->sensors; }

const std::vector<slam::Stamp>& AslFolder::times() const { return files_->times; }

double AslFolder::part() const {
  return static_cast<double>(files_->next_image) / static_cast<double>(files_->images.size());
}

std::optional<slam::Observation> AslFolder::next() {
  if (files_->next_image == files_->images.size()) return std::nullopt;
  return files_->next();
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

std::optional<ClockOffset> clock_offset(const std::vector<TimedRotation>& gyro,
                                        const std::vector<files::TumRow>& truth) {
  if (gyro.empty() || truth.empty()) return std::nullopt;
  const slam::Stamp margin = kMostLag * kStep, begin = truth.front().t - margin;
  const slam::Stamp end = std::min(truth.back().t, truth.front().t + kHour) + margin;
  const auto size = static_cast<std::size_t>((end - begin) / kStep);
  std::vector<files::TumRow> integral{{{gyro.front().t}, std::nullopt}};
  for (std::size_t i = 1; i < gyro.size(); ++i) {
    const Eigen::Vector3d turn =
        0.5 * (gyro[i - 1].value + gyro[i].value) * slam::seconds(gyro[i].t - gyro[i - 1].t);
    files::TumRow& now = integral.emplace_back(integral.back());
    now.t = gyro[i].t;
    now.X.rotate(Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()));
  }
  const Turns by_gyro = turns(integral, begin, size), by_truth = turns(truth, begin, size);
  std::vector<Correlation> all;
  for (int lag = -kMostLag; lag <= kMostLag; ++lag) all.push_back(correlation(by_truth, by_gyro, lag));
  const auto best = std::ranges::max_element(all, {}, [](const Correlation& c) { return c.evidence(c.r); });
  const double as_stamped = all[kMostLag].r;
  if (best->r < kLeastCorrelation) return std::nullopt;
  const auto evidence = [&](double r) { return best->evidence(std::min(r, kMostCorrelation)); };
  const bool decisive = evidence(best->r) - evidence(as_stamped) >= kDecisive;
  return ClockOffset{decisive ? slam::seconds((best - all.begin() - kMostLag) * kStep) : 0, best->r,
                     as_stamped, best->gain};
}

}  // namespace sim::recording
