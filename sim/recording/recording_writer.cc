#include <fmt/format.h>

#include "sim/recording/image_file.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording.h"
#include "sim/recording/recording_format.h"
#include "sim/recording/sensor_yaml.h"

namespace sim::recording {
namespace {

using namespace recording_format;

void require(bool holds, const std::string& what) {
  if (!holds) throw std::logic_error("recording: " + what);
}

fs::path made_folder(const fs::path& folder) {
  std::error_code error;
  if (fs::create_directories(folder, error)) return folder;
  if (error) files::fail_by_errno(folder, "cannot be created", error.value());
  throw files::FileError(folder, "already exists");
}

files::HashedFile new_file(const fs::path& file) {
  fs::create_directories(file.parent_path());
  return files::HashedFile(file);
}

// One csv file of the recording, written row by row.
struct Rows {
  Rows(const fs::path& folder, const std::string& name_, const std::string& header)
      : name(name_), file(new_file(folder / name_)) {
    if (!header.empty()) file.write(header + "\n");
  }
  Rows(const fs::path& folder, const Table& table) : Rows(folder, table.file, table.header) {}
  /// Adds a row with that stamp. Each of the `fields` is preceded by a comma.
  void add(slam::Stamp t, const std::string& fields) {
    require(!last || t > *last, "the stamps of " + name + " do not increase");
    file.write(fmt::format("{}{}\n", file_stamp(t), fields));
    last = t;
  }
  /// Adds a reading of an IMU, which starts where the previous one ended. (after, until]: the time of its
  /// observation.
  void add_inertial(slam::Stamp from, slam::Stamp to, const Eigen::Vector3d& gyro,
                    const Eigen::Vector3d& accelerometer, std::optional<slam::Stamp> after,
                    slam::Stamp until) {
    if (!begin) begin = from;
    require(from == last.value_or(from) && to > from, "inertial readings are not contiguous");
    require(to <= until && (!after || to > *after), "an inertial reading is not within its frame's time");
    add(to, "," + files::csv_fields(gyro) + "," + files::csv_fields(accelerometer));
  }
  std::string name;
  files::HashedFile file;
  std::optional<slam::Stamp> last, begin;  // begin: of an IMU's first reading
};

/// The truth. desired_waist: only for a steered walk. torques: only once there are some.
struct TruthRows {
  explicit TruthRows(const fs::path& folder)
      : camera(folder, kTrueCamera),
        waist(folder, kTrueWaist),
        planned_waist(folder, kPlannedWaist),
        feet(folder, kFeet.file, ""),
        surfaces(folder, kSurfaces) {}
  Rows camera, waist, planned_waist, feet, surfaces;
  std::optional<Rows> desired_waist, torques;
};

}  // namespace

struct RecordingWriter::Files {
  Files(const fs::path& folder_, const RecordingSetup& setup_) : folder(made_folder(folder_)), setup(setup_) {
    for (const BodySensor& sensor : body_sensors())
      body.emplace_back(folder, sensor_rows(sensor.name), kStampColumn + sensor.columns(setup.joints));
    for (const rig::RigSensor& sensor : setup.rig)
      rig.emplace_back(folder, sensor_rows(sensor.name),
                       sensor.kind == rig::Kind::imu ? kImuHeader : kRigHeader);
  }

  fs::path folder;
  RecordingSetup setup;
  ManifestWriter manifest{folder};
  Rows frames{folder, kFrames, kStampColumn}, camera{folder, sensor_rows("cam0"), kCameraHeader},
      imu{folder, sensor_rows("imu0"), kImuHeader}, motion{folder, sensor_rows(kMotion), kMotionHeader};
  TruthRows truth{folder};
  std::vector<Rows> body;                      // in the order of body_sensors()
  std::vector<Rows> rig;                       // in the order of setup.rig
  std::array<std::optional<Rows>, 3> sources;  // in the order of motion_sources()

  void write_whole(const std::string& name, std::string_view bytes) {
    files::HashedFile file = new_file(folder / name);
    file.write(bytes);
    file.close();
    manifest.add(name, file.hash());
  }

  /// Writes the image or the points of a reading. Returns the file's name.
  std::string write_reading(const rig::RigSensor& sensor, const slam::RigReading& reading,
                            std::string_view png) {
    const RigFormat& format = format_of(sensor.kind);
    const std::string name = fmt::format("{}{}", file_stamp(reading.t), format.ending);
    const cv::Size size(sensor.camera.width_px, sensor.camera.height_px);
    require(!rig::is_camera(sensor) ||
                (reading.image.type() == format.image_type && reading.image.size() == size),
            fmt::format("an image is not {} of the camera's size", format.image_name));
    if (!rig::is_camera(sensor))
      write_whole(sensor_data(sensor.name) + name, lidar_bytes(reading.points));
    else
      write_whole(sensor_data(sensor.name) + name, png.empty() ? encode_png(reading.image) : png);
    return name;
  }

  void add_rig(const slam::Observation& ideal, const std::vector<std::string>& pngs,
               std::optional<slam::Stamp> before) {
    for (std::size_t i = 0; i < ideal.rig.size(); ++i) {
      const slam::RigReading& reading = ideal.rig[i];
      const auto index = std::size_t(reading.sensor);
      require(index < rig.size(), fmt::format("the rig has no sensor {}", reading.sensor));
      require(i == 0 || ideal.rig[i - 1].sensor <= reading.sensor,
              "the rig's readings are not in the order of its sensors");
      const rig::RigSensor& sensor = setup.rig[index];
      if (sensor.kind == rig::Kind::imu) {
        rig[index].add_inertial(reading.begin, reading.t, reading.gyro, reading.accelerometer, before,
                                ideal.t);
        continue;
      }
      const std::string name = write_reading(sensor, reading, i < pngs.size() ? pngs[i] : "");
      rig[index].add(reading.t, fmt::format(",{},{}", name, file_stamp(ideal.t)));
    }
  }

  void add_motion(const slam::Observation& ideal) {
    for (std::size_t i = 0; i < sources.size(); ++i) {
      const MotionSource& source = motion_sources()[i];
      if (!source.in(ideal)) continue;
      if (!sources[i]) sources[i].emplace(folder, sensor_rows(source.name), source.header);
      sources[i]->add(ideal.t, "," + source.fields(ideal));
    }
  }

  void add_inertial(const slam::Observation& ideal, std::optional<slam::Stamp> before) {
    require(ideal.accelerometer.size() == ideal.gyro.size(), "gyro and accelerometer counts differ");
    for (std::size_t i = 0; i < ideal.gyro.size(); ++i) {
      const slam::InertialSample& gyro = ideal.gyro[i];
      imu.add_inertial(gyro.begin, gyro.end, gyro.value, ideal.accelerometer[i].value, before, ideal.t);
    }
  }
};

RecordingWriter::RecordingWriter(const fs::path& folder, const RecordingSetup& setup)
    : files_(std::make_unique<Files>(folder, setup)) {}

RecordingWriter::~RecordingWriter() = default;

void RecordingWriter::add(const slam::Observation& ideal, std::string_view png,
                          const std::vector<std::string>& rig_pngs) {
  Files& f = *files_;
  const std::optional<slam::Stamp> before = f.frames.last;
  f.frames.add(ideal.t, "");
  f.add_inertial(ideal, before);
  if (!ideal.image.empty()) {
    slam::RigReading head;
    head.t = ideal.t, head.image = ideal.image;
    f.camera.add(ideal.t, "," + f.write_reading(head_camera(f.setup), head, png));
  }
  f.add_motion(ideal);
  f.add_rig(ideal, rig_pngs, before);
}

void RecordingWriter::add(const BodyReading& reading) {
  require(reading.q.size() == Eigen::Index(files_->setup.joints.size()),
          "the encoders do not give one angle for each joint");
  for (std::size_t i = 0; i < files_->body.size(); ++i)
    files_->body[i].add(reading.t, body_sensors()[i].values(reading));
}

void RecordingWriter::add(const TruePoses& poses) {
  files_->truth.camera.add(poses.t, "," + files::csv_fields(poses.X_WC));
  files_->truth.waist.add(poses.t, "," + files::csv_fields(poses.X_WB));
  if (poses.X_PB) files_->truth.planned_waist.add(poses.t, "," + files::csv_fields(*poses.X_PB));
  if (!poses.X_WB_desired) return;
  if (!files_->truth.desired_waist) files_->truth.desired_waist.emplace(files_->folder, kDesiredWaist);
  files_->truth.desired_waist->add(poses.t, "," + files::csv_fields(*poses.X_WB_desired));
}

void RecordingWriter::add(const TrueMotion& motion) {
  Eigen::Quaterniond q(motion.X_WG.linear());
  q.normalize();
  files_->motion.add(motion.t, fmt::format(",{},{},{},{},{},{},0,0,0,0,0,0",
                                           files::csv_fields(Eigen::Vector3d(motion.X_WG.translation())),
                                           q.w(), q.x(), q.y(), q.z(), files::csv_fields(motion.v_WG)));
}

void RecordingWriter::add(const TrueFeet& feet) {
  std::string fields;
  for (const TrueFoot& foot : {feet.left, feet.right})
    fields += fmt::format(",{},{},{},{},{}", files::csv_fields(foot.truth), files::csv_fields(foot.plan),
                          foot.planned_down ? 1 : 0, foot.load_n, files::csv_fields(foot.creep));
  Rows& rows = files_->truth.feet;
  if (!rows.last) rows.file.write((feet.torque_limited ? kFeetAndTorqueHeader : kFeet.header) + "\n");
  if (feet.torque_limited) fields += *feet.torque_limited ? ",1" : ",0";
  rows.add(feet.t, fields);
}

void RecordingWriter::add(slam::Stamp t, const Eigen::VectorXd& torques) {
  std::optional<Rows>& rows = files_->truth.torques;
  if (!rows) {
    std::string header = kStampColumn;
    for (const std::string& joint : files_->setup.joints) header += "," + joint + " [N m]";
    rows.emplace(files_->folder, kTorques, header);
  }
  std::string fields;
  for (const double torque : torques) fields += fmt::format(",{:.4f}", torque);
  rows->add(t, fields);
}

void RecordingWriter::add(const score::Surface& surface) {
  files_->truth.surfaces.file.write(fmt::format("{},{},{}\n", kSurfaceKinds.at(std::size_t(surface.kind)),
                                                files::csv_fields(surface.X_WS),
                                                files::csv_fields(surface.size)));
}

void RecordingWriter::add(const std::vector<score::StepCorrection>& steps) {
  std::string text = kCorrectedSteps.header + "\n";
  for (const score::StepCorrection& step : steps)
    text += fmt::format("{}{}\n", file_stamp(step.t), correction_fields(step));
  files_->write_whole(kCorrectedSteps.file, text);
}

void RecordingWriter::add(const std::string& name, std::string_view text) { files_->write_whole(name, text); }

void RecordingWriter::finish() {
  Files& f = *files_;
  if (!f.truth.feet.last) f.truth.feet.file.write(kFeet.header + "\n");
  f.write_whole(kBody, body_yaml(f.setup.rig));
  f.write_whole(sensor_file("cam0"), camera_yaml(f.setup.calibration, f.setup.camera_rate_hz));
  f.write_whole(sensor_file("imu0"),
                imu_yaml("chest IMU, ideal: means over (previous stamp, stamp]; +g up at rest",
                         Eigen::Isometry3d::Identity(), f.setup.imu_rate_hz, {}, f.imu.begin));
  for (const BodySensor& sensor : body_sensors())
    f.write_whole(sensor_file(sensor.name), body_sensor_yaml(sensor, f.setup));
  for (std::size_t i = 0; i < f.rig.size(); ++i)
    f.write_whole(sensor_file(f.setup.rig[i].name),
                  rig_sensor_yaml(f.setup.rig[i], f.setup.calibration, f.rig[i].begin));
  f.write_whole(sensor_file(kMotion), motion_yaml());
  std::vector<Rows*> all{&f.frames, &f.camera, &f.imu};
  for (std::size_t i = 0; i < f.sources.size(); ++i) {
    if (f.sources[i]) all.push_back(&*f.sources[i]);
    if (f.sources[i] || i == 0)
      f.write_whole(sensor_file(motion_sources()[i].name), motion_source_yaml(motion_sources()[i], f.setup));
  }
  for (std::vector<Rows>* sensors : {&f.body, &f.rig})
    for (Rows& rows : *sensors) all.push_back(&rows);
  for (Rows* rows :
       {&f.motion, &f.truth.camera, &f.truth.waist, &f.truth.planned_waist, &f.truth.feet, &f.truth.surfaces})
    all.push_back(rows);
  for (std::optional<Rows>* rows : {&f.truth.desired_waist, &f.truth.torques})
    if (*rows) all.push_back(&**rows);
  for (Rows* rows : all) {
    rows->file.close();
    f.manifest.add(rows->name, rows->file.hash());
  }
  f.manifest.finish();
}

}  // namespace sim::recording
