#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>

#include "sim/stream/grey_png.h"
#include "sim/stream/manifest.h"
#include "sim/stream/plan_row.h"
#include "sim/stream/recording.h"
#include "sim/stream/recording_format.h"
#include "sim/stream/sensor_yaml.h"

namespace sim::stream {
namespace {

namespace fs = std::filesystem;
using namespace recording_format;

// One csv file whose first column is a stamp, with one row read ahead.
class Rows {
 public:
  Rows(const Manifest& manifest, const std::string& name, std::vector<std::string> headers)
      : csv_(manifest.check(name), std::move(headers)) {
    advance();
  }

  /// Stamp of the row at hand; nothing after the last.
  std::optional<slam::Stamp> stamp() const { return stamp_; }
  const CsvReader& row() const { return csv_; }

  void advance() {
    const std::optional<slam::Stamp> before = stamp_;
    stamp_.reset();
    if (!csv_.next()) return;
    if (csv_.integer(0) < 0) csv_.fail(0, "a stamp below zero");
    stamp_ = slam::Stamp(csv_.integer(0)) - kEpoch;
    if (before && *stamp_ <= *before) csv_.fail(0, "the stamp is not after the one before");
  }

  /// Complains when the row at hand is of before t: a frame that frames.csv does not have.
  void refuse_before(slam::Stamp t) const {
    if (stamp_ && *stamp_ < t) csv_.fail(0, "no frame of frames.csv has this stamp");
  }

 private:
  CsvReader csv_;
  std::optional<slam::Stamp> stamp_;
};

std::vector<TimedPose> read_poses(const Manifest& manifest, const std::string& name,
                                  const std::string& header) {
  std::vector<TimedPose> poses;
  for (Rows rows(manifest, name, {header}); rows.stamp(); rows.advance())
    poses.push_back({*rows.stamp(), rows.row().pose(1)});
  return poses;
}

// The foot whose fields begin there.
TrueFoot read_foot(const CsvReader& row, std::size_t first) {
  const std::int64_t down = row.integer(first + 6);
  if (down != 0 && down != 1) row.fail(first + 6, "expected 0 or 1");
  return {row.vector(first), row.vector(first + 3), down == 1, row.number(first + 7), row.vector(first + 8)};
}

std::vector<TrueFeet> read_feet(const Manifest& manifest) {
  std::vector<TrueFeet> feet;
  if (!manifest.lists(kFeet)) return feet;
  for (Rows rows(manifest, kFeet, {kFeetHeader}); rows.stamp(); rows.advance())
    feet.push_back({*rows.stamp(), read_foot(rows.row(), 1), read_foot(rows.row(), 12)});
  return feet;
}

std::vector<RecordedSurface> read_surfaces(const Manifest& manifest) {
  std::vector<RecordedSurface> surfaces;
  CsvReader rows(manifest.check(kSurfaces), {kSurfacesHeader});
  while (rows.next()) {
    if (std::find(kSurfaceKinds.begin(), kSurfaceKinds.end(), rows.text(0)) == kSurfaceKinds.end())
      rows.fail(0, "expected plane, box, sphere, cylinder, ellipsoid or capsule");
    surfaces.push_back({std::string(rows.text(0)), rows.pose(1), rows.vector(13)});
  }
  return surfaces;
}

/// Pictures that were written by other programs may be of a kind that OpenCV alone decodes.
cv::Mat picture(const std::string& png) {
  if (auto grey = decode_grey_png(png)) return *grey;
  const cv::Mat bytes(1, static_cast<int>(png.size()), CV_8UC1, const_cast<char*>(png.data()));
  return cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
}

}  // namespace

struct RecordingReader::Files {
  explicit Files(const fs::path& folder_) : folder(folder_) {
    manifest.check_sizes();
    for (const std::string& name : kForOthers) manifest.check(name);
    read_camera_yaml(folder / kCameraSensor, manifest.read(kCameraSensor), setup);
    read_plan_yaml(folder / kPlanSensor, manifest.read(kPlanSensor), setup);
    const auto begin = read_imu_yaml(folder / kImuSensor, manifest.read(kImuSensor), setup);
    if (imu.stamp() && !begin) throw FileError(folder / kImuSensor, "has no key first_interval_begins_ns");
    if (begin) imu_end = *begin;
  }

  fs::path folder;
  Manifest manifest{folder};
  RecordingSetup setup;
  Rows frames{manifest, kFrames, {kStampColumn}}, camera{manifest, kCameraRows, {kCameraHeader}},
      imu{manifest, kImuRows, {kImuHeader, kGyroHeader}}, plan{manifest, kPlanRows, {kPlanHeader}};
  slam::Stamp imu_end{0};

  cv::Mat image(std::string_view name) const {
    const std::string path = kCameraFolder + std::string(name), png = manifest.read(path);
    const cv::Mat decoded = picture(png);
    const slam::CameraIntrinsics& size = setup.calibration.camera;
    if (decoded.type() != CV_8UC1 || decoded.cols != size.width_px || decoded.rows != size.height_px)
      throw FileError(folder / path,
                      fmt::format("is not an 8-bit grey image of {}x{}", size.width_px, size.height_px));
    return decoded;
  }

  void take_inertial(slam::Observation& observation) {
    for (; imu.stamp() && *imu.stamp() <= observation.t; imu.advance()) {
      const slam::Stamp begin = imu_end;
      imu_end = *imu.stamp();
      if (imu_end <= begin) imu.row().fail(0, "the interval ends before it begins");
      observation.gyro.push_back({begin, imu_end, imu.row().vector(1)});
      if (imu.row().header() == 0) observation.accelerometer.push_back({begin, imu_end, imu.row().vector(4)});
    }
  }

  void refuse_leftovers() const {
    camera.refuse_before(slam::Stamp::max());
    plan.refuse_before(slam::Stamp::max());
    imu.refuse_before(slam::Stamp::max());
  }
};

RecordingReader::RecordingReader(const fs::path& folder) : files_(std::make_unique<Files>(folder)) {}
RecordingReader::~RecordingReader() = default;
RecordingReader::RecordingReader(RecordingReader&&) noexcept = default;

const RecordingSetup& RecordingReader::setup() const { return files_->setup; }
const std::string& RecordingReader::hash() const { return files_->manifest.hash(); }

std::optional<slam::Observation> RecordingReader::next() {
  Files& f = *files_;
  if (!f.frames.stamp()) {
    f.refuse_leftovers();
    return std::nullopt;
  }
  slam::Observation observation;
  observation.t = *f.frames.stamp();
  f.camera.refuse_before(observation.t);
  f.plan.refuse_before(observation.t);
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
  truth.camera = read_poses(manifest, kTrueCamera, kTrueCameraHeader);
  truth.waist = read_poses(manifest, kTrueWaist, kTrueWaistHeader);
  truth.waist_plan = read_poses(manifest, kPlannedWaist, kPlannedWaistHeader);
  truth.feet = read_feet(manifest);
  truth.surfaces = read_surfaces(manifest);
  return truth;
}

}  // namespace sim::stream
