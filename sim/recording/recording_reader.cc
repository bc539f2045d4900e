#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "sim/recording/filter_input.h"
#include "sim/recording/image_file.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording.h"
#include "sim/recording/recording_format.h"
#include "sim/recording/sensor_yaml.h"

namespace sim::recording {
namespace {

namespace fs = std::filesystem;
using namespace recording_format;

StampedRows rows_of(const Manifest& manifest, const std::string& name,
                    const std::vector<std::string>& headers) {
  return StampedRows(files::CsvReader(manifest.check(name), headers), kEpoch);
}

std::vector<files::TimedPose> read_poses(const Manifest& manifest, const Table& table) {
  std::vector<files::TimedPose> poses;
  for (StampedRows rows = rows_of(manifest, table.file, {table.header}); rows.stamp(); rows.advance())
    poses.push_back({*rows.stamp(), rows.row().pose(1)});
  return poses;
}

// Reads the foot from this field on.
TrueFoot read_foot(const files::CsvReader& row, std::size_t first) {
  const std::int64_t down = row.integer(first + 6);
  if (down != 0 && down != 1) row.fail(first + 6, "expected 0 or 1");
  return {row.vector(first), row.vector(first + 3), down == 1, row.number(first + 7), row.vector(first + 8)};
}

// Steps are decided at least a tick apart; the time is that of the decision.
std::vector<score::StepCorrection> read_corrected_steps(const Manifest& manifest) {
  std::vector<score::StepCorrection> steps;
  StampedRows rows = rows_of(manifest, kCorrectedSteps.file, {kCorrectedSteps.header});
  for (; rows.stamp(); rows.advance()) {
    const files::CsvReader& row = rows.row();
    if (row.text(1) != "left" && row.text(1) != "right") row.fail(1, "expected left or right");
    steps.push_back({*rows.stamp(), row.number(8), row.number(9), row.number(10), row.text(1) == "left",
                     row.vector(2), row.vector(5)});
  }
  return steps;
}

std::vector<score::Surface> read_surfaces(const Manifest& manifest) {
  std::vector<score::Surface> surfaces;
  files::CsvReader rows(manifest.check(kSurfaces.file), {kSurfaces.header});
  while (rows.next()) {
    const auto kind = std::find(kSurfaceKinds.begin(), kSurfaceKinds.end(), rows.text(0));
    if (kind == kSurfaceKinds.end())
      rows.fail(0, "expected plane, box, sphere, cylinder, ellipsoid or capsule");
    surfaces.push_back({score::Surface::Kind(kind - kSurfaceKinds.begin()), rows.pose(1), rows.vector(13)});
  }
  return surfaces;
}

}  // namespace

struct RecordingReader::Files {
  explicit Files(const fs::path& folder_) : folder(folder_) {
    manifest.check_sizes();
    for (const std::string& name : {kBody, kMotionSensor, kMotionRows}) manifest.check(name);  // for others
    for (const BodySensor& sensor : body_sensors()) {
      manifest.check(body_sensor_file(sensor.name));
      manifest.check(body_sensor_rows(sensor.name));
    }
    read_camera_yaml(folder / kCameraSensor, sensor_text(kCameraSensor), setup);
    read_plan_yaml(folder / kPlanSensor, sensor_text(kPlanSensor), setup);
    const auto begin = read_imu_yaml(folder / kImuSensor, sensor_text(kImuSensor), setup);
    if (imu.stamp() && !begin)
      throw files::FileError(folder / kImuSensor, "has no key first_interval_begins_ns");
    if (begin) imu_end = *begin;
  }

  fs::path folder;
  Manifest manifest{folder};
  RecordingSetup setup;
  StampedRows frames = rows_of(manifest, kFrames, {kStampColumn}),
              camera = rows_of(manifest, kCameraRows, {kCameraHeader}),
              imu = rows_of(manifest, kImuRows, {kImuHeader}),
              plan = rows_of(manifest, kPlanRows, {kPlanHeader, kPlanAndLegsHeader});
  slam::Stamp imu_end{0};

  std::string sensor_text(const std::string& name) const { return manifest.read(name, files::kMostOfYaml); }

  cv::Mat image(std::string_view name) const {
    const std::string path = kCameraFolder + std::string(name);
    const slam::CameraIntrinsics& size = setup.calibration.camera;
    const cv::Mat decoded = decode_image(folder / path, manifest.read(path, files::kMostOfImage),
                                         {size.width_px, size.height_px}, cv::IMREAD_UNCHANGED);
    if (decoded.type() != CV_8UC1) throw files::FileError(folder / path, "is not an 8-bit grey image");
    return decoded;
  }

  void take_inertial(slam::Observation& observation) {
    for (; imu.stamp() && *imu.stamp() <= observation.t; imu.advance()) {
      const slam::Stamp begin = imu_end;
      imu_end = *imu.stamp();
      if (imu_end <= begin) imu.row().fail(0, "the interval ends before its start");
      observation.gyro.push_back({begin, imu_end, angular_rate(imu.row())});
      observation.accelerometer.push_back({begin, imu_end, acceleration(imu.row())});
    }
  }

  /// Throws if a row's stamp is before t: then it is not in frames.csv.
  void refuse_rows_before(slam::Stamp t, const std::initializer_list<const StampedRows*>& files) const {
    for (const StampedRows* rows : files)
      if (rows->stamp() && *rows->stamp() < t) rows->row().fail(0, "no frame of frames.csv has this stamp");
  }
};

RecordingReader::RecordingReader(const fs::path& folder) : files_(std::make_unique<Files>(folder)) {}
RecordingReader::~RecordingReader() = default;
RecordingReader::RecordingReader(RecordingReader&&) noexcept = default;

const RecordingSetup& RecordingReader::setup() const { return files_->setup; }
double RecordingReader::part() const { return files_->frames.row().part(); }
const std::string& RecordingReader::hash() const { return files_->manifest.hash(); }

std::optional<slam::Observation> RecordingReader::next() {
  Files& f = *files_;
  if (!f.frames.stamp()) {
    f.refuse_rows_before(slam::Stamp::max(), {&f.camera, &f.plan, &f.imu});
    return std::nullopt;
  }
  slam::Observation observation;
  observation.t = *f.frames.stamp();
  f.refuse_rows_before(observation.t, {&f.camera, &f.plan});
  f.take_inertial(observation);
  if (f.camera.stamp() == observation.t) {
    observation.image = f.image(f.camera.row().text(1));
    f.camera.advance();
  }
  if (f.plan.stamp() == observation.t) {
    observation.plan = read_plan_row(f.plan.row());
    f.plan.advance();
  }
  f.frames.advance();
  return observation;
}

Truth read_truth(const fs::path& folder) {
  const Manifest manifest(folder);
  Truth truth;
  truth.camera = read_poses(manifest, kTrueCamera);
  truth.waist = read_poses(manifest, kTrueWaist);
  truth.waist_plan = read_poses(manifest, kPlannedWaist);
  for (StampedRows rows = rows_of(manifest, kFeet.file, {kFeet.header}); rows.stamp(); rows.advance())
    truth.feet.push_back({*rows.stamp(), read_foot(rows.row(), 1), read_foot(rows.row(), 12)});
  truth.surfaces = read_surfaces(manifest);
  if (manifest.lists(kCorrectedSteps.file)) truth.corrected_steps = read_corrected_steps(manifest);
  return truth;
}

std::optional<slam::Observation> FilterInput::next() {
  while (arrived_.empty() && !ended_) {
    std::optional<slam::Observation> ideal = reader_.next();
    ended_ = !ideal;
    for (slam::Observation& o : ideal ? errors_.process(std::move(*ideal)) : errors_.flush())
      arrived_.push_back(std::move(o));
  }
  if (arrived_.empty()) return std::nullopt;
  slam::Observation next = std::move(arrived_.front());
  arrived_.pop_front();
  return next;
}

std::optional<slam::Observation> FilterInput::next_in_order() {
  std::optional<slam::Observation> observation = next();
  while (observation && last_ && observation->t <= *last_) observation = next();
  if (observation) last_ = observation->t;
  return observation;
}

}  // namespace sim::recording
