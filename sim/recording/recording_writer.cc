#include <fmt/format.h>

#include <stdexcept>

#include "sim/recording/image_file.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording.h"
#include "sim/recording/recording_format.h"
#include "sim/recording/sensor_yaml.h"

namespace sim::recording {
namespace {

namespace fs = std::filesystem;
using namespace recording_format;

void require(bool holds, const std::string& what) {
  if (!holds) throw std::logic_error("recording: " + what);
}

fs::path made_folder(const fs::path& folder) {
  std::error_code error;
  if (!fs::create_directories(folder, error))
    throw files::FileError(folder, error ? "cannot be made: " + error.message() : "exists already");
  return folder;
}

files::HashedFile new_file(const fs::path& file) {
  fs::create_directories(file.parent_path());
  return files::HashedFile(file);
}

// One csv file of the recording, written row by row.
struct Rows {
  Rows(const fs::path& folder, const std::string& name_) : name(name_), file(new_file(folder / name_)) {}
  Rows(const fs::path& folder, const std::string& name_, const std::string& header) : Rows(folder, name_) {
    file.write(header + "\n");
  }
  Rows(const fs::path& folder, const Table& table) : Rows(folder, table.file, table.header) {}
  /// A row of that stamp; `fields` has a comma before each.
  void add(slam::Stamp t, const std::string& fields) {
    require(!last || t > *last, "the stamps of " + name + " do not rise");
    file.write(fmt::format("{}{}\n", file_stamp(t), fields));
    last = t;
  }
  std::string name;
  files::HashedFile file;
  std::optional<slam::Stamp> last;
};

}  // namespace

struct RecordingWriter::Files {
  Files(const fs::path& folder_, const RecordingSetup& setup_) : folder(made_folder(folder_)), setup(setup_) {
    for (const BodySensor& sensor : body_sensors())
      body.emplace_back(folder, body_sensor_rows(sensor.name), kStampColumn + sensor.columns(setup.joints));
  }

  fs::path folder;
  RecordingSetup setup;
  ManifestWriter manifest{folder};
  Rows frames{folder, kFrames, kStampColumn}, camera{folder, kCameraRows, kCameraHeader},
      imu{folder, kImuRows, kImuHeader}, plan{folder, kPlanRows}, motion{folder, kMotionRows, kMotionHeader},
      true_camera{folder, kTrueCamera}, true_waist{folder, kTrueWaist}, planned_waist{folder, kPlannedWaist},
      feet{folder, kFeet}, surfaces{folder, kSurfaces};
  std::vector<Rows> body;  // in the order of body_sensors()
  std::optional<slam::Stamp> imu_begin, imu_end;
  std::optional<bool> with_legs;  // known from the first plan on

  void write_whole(const std::string& name, std::string_view bytes) {
    files::HashedFile file = new_file(folder / name);
    file.write(bytes);
    file.close();
    manifest.add(name, file.hash());
  }

  void add_image(slam::Stamp t, const cv::Mat& image, std::string_view png) {
    const slam::CameraIntrinsics& size = setup.calibration.camera;
    require(image.type() == CV_8UC1 && image.cols == size.width_px && image.rows == size.height_px,
            "an image is not 8-bit grey of the camera's size");
    const std::string name = fmt::format("{}.png", file_stamp(t));
    write_whole(kCameraFolder + name, png.empty() ? encode_grey_png(image) : png);
    camera.add(t, "," + name);
  }

  void add_plan(slam::Stamp t, const slam::PlannedMotion& planned) {
    if (!with_legs) plan.file.write(plan_header(planned) + "\n");
    require(with_legs.value_or(planned.legs.has_value()) == planned.legs.has_value(),
            "leg odometry comes and goes");
    with_legs = planned.legs.has_value();
    plan.add(t, "," + plan_fields(planned));
  }

  void add_inertial(const slam::Observation& ideal) {
    require(ideal.accelerometer.size() == ideal.gyro.size(), "gyro and accelerometer differ in number");
    for (std::size_t i = 0; i < ideal.gyro.size(); ++i) {
      const slam::InertialSample& gyro = ideal.gyro[i];
      if (!imu_begin) imu_begin = imu_end = gyro.begin;
      require(gyro.begin == imu_end && gyro.end > gyro.begin, "inertial readings do not chain");
      require(gyro.end <= ideal.t, "an inertial reading is not of its frame");
      imu_end = gyro.end;
      imu.add(gyro.end,
              "," + files::csv_fields(gyro.value) + "," + files::csv_fields(ideal.accelerometer[i].value));
    }
  }
};

RecordingWriter::RecordingWriter(const fs::path& folder, const RecordingSetup& setup)
    : files_(std::make_unique<Files>(folder, setup)) {}

RecordingWriter::~RecordingWriter() = default;

void RecordingWriter::add(const slam::Observation& ideal, std::string_view png,
                          const std::vector<std::string>& /*rig_pngs*/) {
  Files& f = *files_;
  f.frames.add(ideal.t, "");
  f.add_inertial(ideal);
  if (!ideal.image.empty()) f.add_image(ideal.t, ideal.image, png);
  if (ideal.plan) f.add_plan(ideal.t, *ideal.plan);
}

void RecordingWriter::add(const BodyReading& reading) {
  require(reading.q.size() == static_cast<Eigen::Index>(files_->setup.joints.size()),
          "the encoders do not give one angle for each joint");
  for (std::size_t i = 0; i < files_->body.size(); ++i)
    files_->body[i].add(reading.t, body_sensors()[i].values(reading));
}

void RecordingWriter::add(const TruePoses& poses) {
  files_->true_camera.add(poses.t, "," + files::csv_fields(poses.X_WC));
  files_->true_waist.add(poses.t, "," + files::csv_fields(poses.X_WB));
  files_->planned_waist.add(poses.t, "," + files::csv_fields(poses.X_PB));
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
  files_->feet.add(feet.t, fields);
}

void RecordingWriter::add(const score::Surface& surface) {
  files_->surfaces.file.write(fmt::format("{},{},{}\n", kSurfaceKinds.at(std::size_t(surface.kind)),
                                          files::csv_fields(surface.X_WS), files::csv_fields(surface.size)));
}

void RecordingWriter::add(const std::vector<score::StepCorrection>& steps) {
  std::string text = kCorrectedSteps.header + "\n";
  for (const score::StepCorrection& step : steps)
    text += fmt::format("{},{},{},{},{}\n", file_stamp(step.t), kSupport[step.left ? 1 : 2],
                        files::csv_fields(step.desired), files::csv_fields(step.expected),
                        files::csv_fields(Eigen::Vector3d(step.ahead, step.aside, step.turn)));
  files_->write_whole(kCorrectedSteps.file, text);
}

void RecordingWriter::add(const std::string& name, std::string_view text) { files_->write_whole(name, text); }

void RecordingWriter::finish() {
  Files& f = *files_;
  if (!f.with_legs) f.plan.file.write(kPlanHeader + "\n");
  f.write_whole(kBody, body_yaml());
  f.write_whole(kCameraSensor, camera_yaml(f.setup));
  f.write_whole(kImuSensor, imu_yaml(f.setup, std::nullopt, f.imu_begin));
  for (const BodySensor& sensor : body_sensors())
    f.write_whole(body_sensor_file(sensor.name), body_sensor_yaml(sensor, f.setup));
  f.write_whole(kPlanSensor, plan_yaml(f.setup));
  f.write_whole(kMotionSensor, motion_yaml());
  std::vector<Rows*> all{&f.frames, &f.camera, &f.imu};
  for (Rows& rows : f.body) all.push_back(&rows);
  for (Rows* rows :
       {&f.plan, &f.motion, &f.true_camera, &f.true_waist, &f.planned_waist, &f.feet, &f.surfaces})
    all.push_back(rows);
  for (Rows* rows : all) {
    rows->file.close();
    f.manifest.add(rows->name, rows->file.hash());
  }
  f.manifest.finish();
}

}  // namespace sim::recording
