#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <opencv2/imgcodecs.hpp>
#include <utility>
#include <variant>

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

// The file of an IMU. Its successive readings adjoin.
class ImuReader {
 public:
  /// begin: start of the first interval, as sensor_yaml states it; known only if there are readings.
  ImuReader(const Manifest& manifest, const std::string& rows, const fs::path& sensor_yaml,
            std::optional<slam::Stamp> begin)
      : rows_(rows_of(manifest, rows, {kImuHeader})), end_(begin.value_or(slam::Stamp{0})) {
    if (rows_.stamp() && !begin) throw files::FileError(sensor_yaml, "has no key first_interval_begins_ns");
  }
  const StampedRows& rows() const { return rows_; }
  /// Calls take(begin, end, gyro, accelerometer) with the readings up to t.
  void read_until(slam::Stamp t, auto&& take) {
    for (; rows_.stamp() && *rows_.stamp() <= t; rows_.advance()) {
      const slam::Stamp begin = end_;
      end_ = *rows_.stamp();
      if (end_ <= begin) rows_.row().fail(0, "the interval ends before its start");
      take(begin, end_, angular_rate(rows_.row()), acceleration(rows_.row()));
    }
  }

 private:
  StampedRows rows_;
  slam::Stamp end_;
};

constexpr const char* kNoFrame = "no frame of frames.csv has this stamp";

// The readings of a further camera or lidar, and the frames that have them.
class RigReader {
 public:
  RigReader(const Manifest& manifest, const std::string& rows)
      : rows_(rows_of(manifest, rows, {kRigHeader})) {}
  /// Calls take(stamp, name of the file) with the readings of the frame at t. Throws for earlier ones.
  void read_frame(slam::Stamp t, auto&& take) {
    for (; rows_.stamp() && frame() == t; rows_.advance()) take(*rows_.stamp(), rows_.row().text(1));
    if (rows_.stamp() && frame() < t) rows_.row().fail(2, kNoFrame);
  }

 private:
  slam::Stamp frame() const {
    const std::int64_t ns = rows_.row().integer(2);
    if (ns < 0) rows_.row().fail(2, kNoFrame);
    return slam::Stamp(ns) - kEpoch;
  }
  StampedRows rows_;
};

}  // namespace

slam::RigReading read_rig_file(const fs::path& folder, const Manifest& manifest, const rig::RigSensor& sensor,
                               const std::string& name) {
  const std::string path = sensor_data(sensor.name) + name, bytes = manifest.read(path, files::kMostOfImage);
  slam::RigReading reading;
  if (!rig::is_camera(sensor)) {
    reading.points = read_lidar(folder / path, bytes);
    return reading;
  }
  require_image_size(folder / path, bytes, {sensor.camera.width_px, sensor.camera.height_px});
  const RigFormat& format = format_of(sensor.kind);
  const auto image = decode_png(bytes, format.image_type);
  if (!image)
    throw files::FileError(folder / path, fmt::format("is not {} as recordings have", format.image_name));
  reading.image = *image;
  return reading;
}

struct RecordingReader::Files {
  explicit Files(const fs::path& folder_) : folder(folder_) {
    manifest.check_sizes();
    for (const std::string& name : {kMotionSensor, kMotionRows}) manifest.check(name);  // for others
    const std::string encoders = sensor_file(body_sensors()[0].name);
    setup.joints = read_joints(folder / encoders, sensor_text(encoders));
    for (const BodySensor& sensor : body_sensors()) {
      manifest.check(sensor_file(sensor.name));
      body.emplace_back(files::CsvReader(manifest.check(sensor_rows(sensor.name)),
                                         {kStampColumn + sensor.columns(setup.joints)}),
                        kEpoch);
    }
    read_camera_yaml(folder / kCameraSensor, sensor_text(kCameraSensor), setup);
    read_plan_yaml(folder / kPlanSensor, sensor_text(kPlanSensor), setup);
    imu.emplace(manifest, kImuRows, folder / kImuSensor,
                read_imu_yaml(folder / kImuSensor, sensor_text(kImuSensor), setup));
    for (const std::string& name : read_body_yaml(folder / kBody, sensor_text(kBody))) {
      const std::string file = sensor_file(name);
      const ReadRigSensor read = read_rig_sensor_yaml(folder / file, sensor_text(file), name);
      setup.rig.push_back(read.sensor);
      if (read.sensor.kind == rig::Kind::imu)
        rig.emplace_back(std::in_place_type<ImuReader>, manifest, sensor_rows(name), folder / file,
                         read.begin);
      else
        rig.emplace_back(std::in_place_type<RigReader>, manifest, sensor_rows(name));
    }
    for (const rig::RigSensor& sensor : setup.rig)
      if (const int with = rig::partner(setup.rig, sensor);
          sensor.kind == rig::Kind::depth && sensor.aligned_with != "cam0" &&
          (with < 0 || setup.rig[static_cast<std::size_t>(with)].kind > rig::Kind::color))
        throw files::FileError(
            folder / sensor_file(sensor.name),
            fmt::format("aligned_with: the rig has no gray or color camera {}", sensor.aligned_with));
  }

  fs::path folder;
  Manifest manifest{folder};
  RecordingSetup setup;
  StampedRows frames = rows_of(manifest, kFrames, {kStampColumn}),
              camera = rows_of(manifest, kCameraRows, {kCameraHeader}),
              plan = rows_of(manifest, kPlanRows, {kPlanHeader, kPlanAndLegsHeader});
  std::optional<ImuReader> imu;
  std::deque<StampedRows> body;                        // in the order of body_sensors()
  std::deque<std::variant<RigReader, ImuReader>> rig;  // in the order of setup.rig

  std::string sensor_text(const std::string& name) const { return manifest.read(name, files::kMostOfYaml); }

  void take_rig(slam::Observation& observation) {
    for (std::size_t i = 0; i < rig.size(); ++i) {
      const rig::RigSensor& sensor = setup.rig[i];
      if (auto* imu_reader = std::get_if<ImuReader>(&rig[i])) {
        imu_reader->read_until(observation.t, [&](slam::Stamp begin, slam::Stamp end,
                                                  const Eigen::Vector3d& w, const Eigen::Vector3d& a) {
          slam::RigReading& reading = observation.rig.emplace_back();
          reading.sensor = static_cast<int>(i), reading.t = end;
          reading.begin = begin, reading.gyro = w, reading.accelerometer = a;
        });
        continue;
      }
      std::get<RigReader>(rig[i]).read_frame(observation.t, [&](slam::Stamp t, std::string_view name) {
        slam::RigReading reading = read_rig_file(folder, manifest, sensor, std::string(name));
        reading.sensor = static_cast<int>(i), reading.t = t;
        observation.rig.push_back(std::move(reading));
      });
    }
  }

  cv::Mat image(std::string_view name) const {
    const std::string path = kCameraFolder + std::string(name);
    const slam::CameraIntrinsics& size = setup.calibration.camera;
    const cv::Mat decoded = decode_image(folder / path, manifest.read(path, files::kMostOfImage),
                                         {size.width_px, size.height_px}, cv::IMREAD_UNCHANGED);
    if (decoded.type() != CV_8UC1) throw files::FileError(folder / path, "is not an 8-bit grey image");
    return decoded;
  }

  void take_inertial(slam::Observation& observation) {
    imu->read_until(observation.t, [&](slam::Stamp begin, slam::Stamp end, const Eigen::Vector3d& w,
                                       const Eigen::Vector3d& a) {
      observation.gyro.push_back({begin, end, w});
      observation.accelerometer.push_back({begin, end, a});
    });
  }

  // The rows of all sensors of the body have the same stamps.
  void take_body(slam::Observation& observation) {
    while (body[0].stamp() && *body[0].stamp() < observation.t) {
      BodyReading& reading = observation.body.emplace_back();
      reading.t = *body[0].stamp();
      for (std::size_t i = 0; i < body.size(); ++i) {
        if (body[i].stamp() != reading.t)
          throw files::FileError(folder / sensor_rows(body_sensors()[i].name),
                                 fmt::format("has no row of the stamp {}", file_stamp(reading.t)));
        body_sensors()[i].read(body[i].row(), reading);
        body[i].advance();
      }
    }
  }

  /// At the end: throws if rows are left of any sensor.
  void refuse_rest() {
    refuse_rows_before(slam::Stamp::max(), {&camera, &plan, &imu->rows()});
    for (auto& rows : rig) {
      if (const auto* imu_reader = std::get_if<ImuReader>(&rows))
        refuse_rows_before(slam::Stamp::max(), {&imu_reader->rows()});
      else
        std::get<RigReader>(rows).read_frame(slam::Stamp::max(), [](slam::Stamp, std::string_view) {});
    }
  }

  /// Throws if a row's stamp is before t: then it is not in frames.csv.
  void refuse_rows_before(slam::Stamp t, const std::initializer_list<const StampedRows*>& files) const {
    for (const StampedRows* rows : files)
      if (rows->stamp() && *rows->stamp() < t) rows->row().fail(0, kNoFrame);
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
    f.refuse_rest();
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
  f.take_rig(observation);
  f.take_body(observation);
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
