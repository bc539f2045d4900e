#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "sim/recording/grey_png.h"
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

void make_folder(const fs::path& folder) {
  std::error_code error;
  if (!fs::create_directories(folder, error))
    throw files::FileError(folder, error ? "cannot be made: " + error.message() : "exists already");
  fs::create_directories(folder / kCameraFolder);
}

files::HashedFile new_file(const fs::path& file) {
  fs::create_directories(file.parent_path());
  return files::HashedFile(file);
}

std::string motion_fields(const TrueMotion& motion) {
  Eigen::Quaterniond q(motion.X_WG.linear());
  q.normalize();
  return fmt::format(",{},{},{},{},{},{},0,0,0,0,0,0",
                     files::csv_fields(Eigen::Vector3d(motion.X_WG.translation())), q.w(), q.x(), q.y(),
                     q.z(), files::csv_fields(motion.v_WG));
}

std::string foot_fields(const TrueFoot& foot) {
  return fmt::format(",{},{},{},{},{}", files::csv_fields(foot.truth), files::csv_fields(foot.plan),
                     foot.planned_down ? 1 : 0, foot.load_n, files::csv_fields(foot.creep));
}

// One csv file of the recording, written row by row.
struct Rows {
  Rows(const fs::path& folder, const std::string& name_) : name(name_), file(new_file(folder / name_)) {}
  Rows(const fs::path& folder, const std::string& name_, const std::string& header) : Rows(folder, name_) {
    file.write(header + "\n");
  }
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
  Files(const fs::path& folder_, const RecordingSetup& setup_)
      : folder((make_folder(folder_), folder_)), setup(setup_) {
    for (const BodySensor& sensor : body_sensors())
      body.emplace_back(folder, body_sensor_rows(sensor.name), kStampColumn + sensor.columns(setup.joints));
  }

  fs::path folder;
  RecordingSetup setup;
  ManifestWriter manifest{folder};
  Rows frames{folder, kFrames, kStampColumn}, camera{folder, kCameraRows, kCameraHeader},
      imu{folder, kImuRows}, plan{folder, kPlanRows}, motion{folder, kMotionRows, kMotionHeader},
      true_camera{folder, kTrueCamera, kTrueCameraHeader}, true_waist{folder, kTrueWaist, kTrueWaistHeader},
      planned_waist{folder, kPlannedWaist, kPlannedWaistHeader}, feet{folder, kFeet, kFeetHeader},
      surfaces{folder, kSurfaces, kSurfacesHeader};
  std::vector<Rows> body;  // in the order of body_sensors()
  std::optional<slam::Stamp> imu_begin, imu_end;
  std::optional<bool> with_accelerometer;  // known from the first reading on
  std::optional<bool> with_legs;           // known from the first plan on

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

  void begin_inertial(const slam::InertialSample& first, bool accelerometer) {
    imu_begin = imu_end = first.begin;
    with_accelerometer = accelerometer;
    imu.file.write((accelerometer ? kImuHeader : kGyroHeader) + "\n");
  }

  void add_inertial(const slam::InertialSample& gyro, const slam::InertialSample* accelerometer) {
    if (!with_accelerometer) begin_inertial(gyro, accelerometer != nullptr);
    require(gyro.begin == *imu_end && gyro.end > gyro.begin, "inertial readings do not chain");
    require(*with_accelerometer == (accelerometer != nullptr), "the accelerometer comes and goes");
    imu.file.write(fmt::format("{},{}", file_stamp(gyro.end), files::csv_fields(gyro.value)));
    if (accelerometer) {
      require(accelerometer->begin == gyro.begin && accelerometer->end == gyro.end,
              "gyro and accelerometer differ in time");
      imu.file.write("," + files::csv_fields(accelerometer->value));
    }
    imu.file.write("\n");
    imu_end = gyro.end;
  }

  void add_inertial(const slam::Observation& ideal, std::optional<slam::Stamp> last_frame) {
    require(ideal.accelerometer.empty() || ideal.accelerometer.size() == ideal.gyro.size(),
            "gyro and accelerometer differ in number");
    for (std::size_t i = 0; i < ideal.gyro.size(); ++i) {
      require(ideal.gyro[i].end <= ideal.t && (!last_frame || ideal.gyro[i].end > *last_frame),
              "an inertial reading is not of its frame");
      add_inertial(ideal.gyro[i], ideal.accelerometer.empty() ? nullptr : &ideal.accelerometer[i]);
    }
  }
};

RecordingWriter::RecordingWriter(const fs::path& folder, const RecordingSetup& setup)
    : files_(std::make_unique<Files>(folder, setup)) {}

RecordingWriter::~RecordingWriter() = default;

void RecordingWriter::add(const slam::Observation& ideal, std::string_view png) {
  Files& f = *files_;
  const std::optional<slam::Stamp> last_frame = f.frames.last;
  f.frames.add(ideal.t, "");
  f.add_inertial(ideal, last_frame);
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

void RecordingWriter::add(const TrueMotion& motion) { files_->motion.add(motion.t, motion_fields(motion)); }

void RecordingWriter::add(const TrueFeet& feet) {
  files_->feet.add(feet.t, foot_fields(feet.left) + foot_fields(feet.right));
}

void RecordingWriter::add(const score::Surface& surface) {
  files_->surfaces.file.write(fmt::format("{},{},{}\n", kSurfaceKinds.at(std::size_t(surface.kind)),
                                          files::csv_fields(surface.X_WS), files::csv_fields(surface.size)));
}

void RecordingWriter::add(const std::vector<score::StepCorrection>& steps) {
  std::string text = kCorrectedStepsHeader + "\n";
  for (const score::StepCorrection& step : steps)
    text += fmt::format("{},{},{},{},{}\n", file_stamp(step.t), kSupport[step.left ? 1 : 2],
                        files::csv_fields(step.desired), files::csv_fields(step.expected),
                        files::csv_fields(Eigen::Vector3d(step.ahead, step.aside, step.turn)));
  files_->write_whole(kCorrectedSteps, text);
}

void RecordingWriter::add(const std::string& name, std::string_view text) { files_->write_whole(name, text); }

void RecordingWriter::finish() {
  Files& f = *files_;
  if (!f.with_accelerometer) f.imu.file.write(kImuHeader + "\n");
  if (!f.with_legs) f.plan.file.write(kPlanHeader + "\n");
  f.write_whole(kBody, body_yaml());
  f.write_whole(kCameraSensor, camera_yaml(f.setup));
  f.write_whole(kImuSensor, imu_yaml(f.setup, f.imu_begin));
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
