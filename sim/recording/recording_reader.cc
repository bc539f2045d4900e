
#include "sim/recording/image_file.h"
#include "sim/recording/sensor_yaml.h"

namespace sim::recording {
namespace {

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

bool read_flag(const files::CsvReader& row, std::size_t column) {
  const std::int64_t flag = row.integer(column);
  if (flag != 0 && flag != 1) row.fail(column, "expected 0 or 1");
  return flag == 1;
}

TrueFoot read_foot(const files::CsvReader& row, std::size_t first) {
  return {row.vector(first), row.vector(first + 3), read_flag(row, first + 6), row.number(first + 7),
          row.vector(first + 8)};
}

// Steps are decided at least a tick apart; their time is the time of the decision.
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
    const auto kind = std::ranges::find(kSurfaceKinds, rows.text(0));
    if (kind == kSurfaceKinds.end())
      rows.fail(0, "expected plane, box, sphere, cylinder, ellipsoid, capsule or triangle");
    surfaces.push_back({score::Surface::Kind(kind - kSurfaceKinds.begin()), rows.pose(1), rows.vector(13)});
  }
  return surfaces;
}

constexpr const char* kNoFrame = "no frame of frames.csv has this stamp";

// The rows of a sensor, whose readings may be in files.
class SensorRows {
 public:
  /// begin: for an IMU, the start of the first interval; known only if there are readings.
  SensorRows(const Manifest& manifest, const fs::path& folder, const std::string& sensor, bool is_imu,
             std::optional<slam::Stamp> begin)
      : rows_(rows_of(manifest, sensor_rows(sensor), {is_imu ? kImuHeader : kRigHeader})),
        is_imu_(is_imu),
        end_(begin.value_or(slam::Stamp{0})) {
    if (is_imu && rows_.stamp() && !begin)
      throw files::FileError(folder / sensor_file(sensor), "has no key first_interval_begins_ns");
  }

  /// Calls take(reading, name of its file) for the readings of the frame at t. Throws if a row has an earlier
  /// frame.
  void read_frame(slam::Stamp t, auto&& take) {
    for (; rows_.stamp() && (is_imu_ ? *rows_.stamp() <= t : frame() == t); rows_.advance()) {
      slam::RigReading reading;
      reading.t = *rows_.stamp();
      if (is_imu_) {  // readings are contiguous
        reading.begin = std::exchange(end_, reading.t);
        if (end_ <= reading.begin) rows_.row().fail(0, "the interval ends before its start");
        reading.gyro = angular_rate(rows_.row()), reading.accelerometer = acceleration(rows_.row());
      }
      take(std::move(reading), is_imu_ ? "" : rows_.row().text(1));
    }
    if (!is_imu_ && rows_.stamp() && frame() < t) rows_.row().fail(2, kNoFrame);
  }

  /// Throws if rows are left at the end.
  void refuse_rest() const {
    if (rows_.stamp()) rows_.row().fail(is_imu_ ? 0 : 2, kNoFrame);
  }

 private:
  slam::Stamp frame() const {
    const std::int64_t ns = rows_.row().integer(2);
    if (ns < 0) rows_.row().fail(2, kNoFrame);
    return slam::Stamp(ns) - kEpoch;
  }
  StampedRows rows_;
  bool is_imu_;
  slam::Stamp end_;  // end of the last reading
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
  const RigFormat& format = format_of(sensor.kind);
  const auto image = decode_png(bytes, format.image_type);
  if (!image) throw files::FileError(folder / path, "is not {} as recordings have", format.image_name);
  require_size(folder / path, *image, {sensor.camera.width_px, sensor.camera.height_px});
  reading.image = *image;
  return reading;
}

namespace {

/// A recording's setup, and the starts of the first intervals of the chest IMU and of the rig's IMUs.
struct StatedSetup {
  RecordingSetup setup;
  std::optional<slam::Stamp> imu_begin;
  std::vector<std::optional<slam::Stamp>> rig_begins;

  StatedSetup(const fs::path& folder, const Manifest& manifest) {
    const auto yaml = [&](const std::string& name) {
      return YamlFile{folder / name, manifest.read(name, files::kMostOfYaml)};
    };
    setup.joints = read_joints(yaml(sensor_file(body_sensors()[0].name)));
    read_camera_yaml(yaml(sensor_file("cam0")), setup);
    read_plan_yaml(yaml(sensor_file("plan0")), setup);
    const StatedImu chest = read_imu_yaml(yaml(sensor_file("imu0")));
    setup.imu_rate_hz = chest.rate_hz, imu_begin = chest.begin;
    for (const std::string& name : read_body_yaml(yaml(kBody))) {
      const auto [sensor, begin] = read_rig_sensor_yaml(yaml(sensor_file(name)), name);
      setup.rig.push_back(sensor), rig_begins.push_back(begin);
    }
    for (const rig::RigSensor& sensor : setup.rig)
      if (const int with = rig::partner(setup.rig, sensor);
          sensor.kind == rig::Kind::depth && sensor.aligned_with != rig::kHeadCamera &&
          (with < 0 || setup.rig[std::size_t(with)].kind > rig::Kind::color))
        throw files::FileError(folder / sensor_file(sensor.name),
                               "aligned_with: the rig has no gray or color camera {}", sensor.aligned_with);
  }
};

}  // namespace

RecordingSetup read_setup(const fs::path& folder, const Manifest& manifest) {
  return StatedSetup(folder, manifest).setup;
}

struct RecordingReader::Files {
  explicit Files(const fs::path& folder_) : folder(folder_) {
    manifest.check_sizes();
    for (const std::string& name : {sensor_file(kMotion), sensor_rows(kMotion)})
      manifest.check(name);  // for other readers
    StatedSetup stated(folder, manifest);
    setup = std::move(stated.setup);
    for (const BodySensor& sensor : body_sensors()) {
      manifest.check(sensor_file(sensor.name));
      body.emplace_back(files::CsvReader(manifest.check(sensor_rows(sensor.name)),
                                         {kStampColumn + sensor.columns(setup.joints)}),
                        kEpoch);
    }
    for (std::size_t i = 0; i < sources.size(); ++i)
      if (const MotionSource& source = motion_sources()[i]; manifest.lists(sensor_rows(source.name))) {
        manifest.check(sensor_file(source.name));
        sources[i].emplace(files::CsvReader(manifest.check(sensor_rows(source.name)), {source.header}),
                           kEpoch);
      }
    imu.emplace(manifest, folder, "imu0", true, stated.imu_begin);
    for (std::size_t i = 0; i < setup.rig.size(); ++i)
      rig.emplace_back(manifest, folder, setup.rig[i].name, setup.rig[i].kind == rig::Kind::imu,
                       stated.rig_begins[i]);
    head = head_camera(setup);
  }

  fs::path folder;
  Manifest manifest{folder};
  RecordingSetup setup;
  rig::RigSensor head;
  StampedRows frames = rows_of(manifest, kFrames, {kStampColumn}),
              camera = rows_of(manifest, sensor_rows("cam0"), {kCameraHeader});
  std::optional<SensorRows> imu;
  std::deque<StampedRows> body;                       // in the order of body_sensors()
  std::deque<SensorRows> rig;                         // in the order of setup.rig
  std::array<std::optional<StampedRows>, 3> sources;  // in the order of motion_sources()

  // The rows of all body sensors have the same stamps.
  void add_body(slam::Observation& observation) {
    while (body[0].stamp() && *body[0].stamp() < observation.t) {
      BodyReading& reading = observation.body.emplace_back();
      reading.t = *body[0].stamp();
      for (std::size_t i = 0; i < body.size(); ++i) {
        if (body[i].stamp() != reading.t)
          throw files::FileError(folder / sensor_rows(body_sensors()[i].name), "has no row of the stamp {}",
                                 file_stamp(reading.t));
        body_sensors()[i].read(body[i].row(), reading);
        body[i].advance();
      }
    }
  }

  /// Throws if a row in the frames' own files has a stamp before t, because then it is not in frames.csv.
  void refuse_rows_before(slam::Stamp t) const {
    const auto refuse = [t](const StampedRows& rows) {
      if (rows.stamp() && *rows.stamp() < t) rows.row().fail(0, kNoFrame);
    };
    refuse(camera);
    for (const auto& rows : sources)
      if (rows) refuse(*rows);
  }
};

RecordingReader::RecordingReader(const fs::path& folder) : files_(std::make_unique<Files>(folder)) {}
RecordingReader::~RecordingReader() = default;
RecordingReader::RecordingReader(RecordingReader&&) noexcept = default;

const RecordingSetup& RecordingReader::setup() const { return files_->setup; }
double RecordingReader::part() const { return files_->frames.row().part(); }
const std::string& RecordingReader::hash() const { return files_->manifest.hash(); }

std::optional<slam::Observation> RecordingReader::next(const std::function<bool(int)>& wants) {
  Files& f = *files_;
  if (!f.frames.stamp()) {
    f.refuse_rows_before(slam::Stamp::max());
    f.imu->refuse_rest();
    for (const SensorRows& rows : f.rig) rows.refuse_rest();
    return std::nullopt;
  }
  slam::Observation observation;
  observation.t = *f.frames.stamp();
  f.refuse_rows_before(observation.t);
  f.imu->read_frame(observation.t, [&](const slam::RigReading& reading, std::string_view) {
    observation.gyro.push_back({reading.begin, reading.t, reading.gyro});
    observation.accelerometer.push_back({reading.begin, reading.t, reading.accelerometer});
  });
  if (f.camera.stamp() == observation.t) {
    observation.image =
        read_rig_file(f.folder, f.manifest, f.head, std::string(f.camera.row().text(1))).image;
    f.camera.advance();
  }
  for (std::size_t i = 0; i < f.sources.size(); ++i) {
    if (!f.sources[i] || f.sources[i]->stamp() != observation.t) continue;
    motion_sources()[i].read(f.sources[i]->row(), observation);
    f.sources[i]->advance();
  }
  for (std::size_t i = 0; i < f.rig.size(); ++i)
    f.rig[i].read_frame(observation.t, [&](slam::RigReading reading, std::string_view name) {
      const slam::Stamp t = reading.t;
      if (!name.empty() && wants && !wants(int(i))) {
        f.manifest.check(sensor_data(f.setup.rig[i].name) + std::string(name));
        return;
      }
      if (!name.empty()) reading = read_rig_file(f.folder, f.manifest, f.setup.rig[i], std::string(name));
      reading.t = t;
      reading.sensor = int(i);
      observation.rig.push_back(std::move(reading));
    });
  f.add_body(observation);
  f.frames.advance();
  return observation;
}

Truth read_truth(const fs::path& folder) {
  const Manifest manifest(folder);
  Truth truth;
  truth.camera = read_poses(manifest, kTrueCamera);
  truth.waist = read_poses(manifest, kTrueWaist);
  truth.waist_plan = read_poses(manifest, kPlannedWaist);
  for (StampedRows rows = rows_of(manifest, kFeet.file, {kFeet.header, kFeetAndTorqueHeader}); rows.stamp();
       rows.advance()) {
    truth.feet.push_back({*rows.stamp(), read_foot(rows.row(), 1), read_foot(rows.row(), 12)});
    constexpr std::size_t kLimited = 23;
    if (rows.row().fields() > kLimited) truth.feet.back().torque_limited = read_flag(rows.row(), kLimited);
  }
  for (StampedRows rows = rows_of(manifest, sensor_rows("imu0"), {kImuHeader}); rows.stamp(); rows.advance())
    truth.forces.push_back({*rows.stamp(), acceleration(rows.row())});
  truth.surfaces = read_surfaces(manifest);
  if (manifest.lists(kDesiredWaist.file)) truth.waist_desired = read_poses(manifest, kDesiredWaist);
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
