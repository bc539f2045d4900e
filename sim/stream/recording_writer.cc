#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "sim/stream/manifest.h"
#include "sim/stream/plan_row.h"
#include "sim/stream/recording.h"
#include "sim/stream/recording_format.h"
#include "sim/stream/sensor_yaml.h"

namespace sim::stream {
namespace {

namespace fs = std::filesystem;
using namespace recording_format;

void require(bool holds, const char* what) {
  if (!holds) throw std::logic_error(std::string("recording: ") + what);
}

void make_folders(const fs::path& folder) {
  std::error_code error;
  if (!fs::create_directories(folder, error))
    throw FileError(folder, error ? "cannot be made: " + error.message() : "exists already");
  for (const char* part : {"mav0/cam0/data", "mav0/imu0", "mav0/encoders0", "mav0/forces0", "mav0/plan0",
                           "mav0/state_groundtruth_estimate0", "truth"})
    fs::create_directories(folder / part);
}

std::string encoders_header(const std::vector<std::string>& joints) {
  std::string header = kStampColumn;
  for (const std::string& joint : joints) header += "," + joint + " [rad]";
  return header;
}

std::string encoder_row(const BodyReading& reading) {
  std::string row = fmt::format("{}", written(reading.t));
  for (const double angle : reading.q) row += fmt::format(",{}", angle);
  return row + "\n";
}

std::string force_row(const BodyReading& reading) {
  return fmt::format("{},{},{},{},{}\n", written(reading.t), csv_fields(reading.left.force),
                     csv_fields(reading.left.torque), csv_fields(reading.right.force),
                     csv_fields(reading.right.torque));
}

std::string motion_row(const TrueMotion& motion) {
  Eigen::Quaterniond q(motion.X_WG.linear());
  q.normalize();
  return fmt::format("{},{},{},{},{},{},{},0,0,0,0,0,0\n", written(motion.t),
                     csv_fields(Eigen::Vector3d(motion.X_WG.translation())), q.w(), q.x(), q.y(), q.z(),
                     csv_fields(motion.v_WG));
}

std::string foot_fields(const TrueFoot& foot) {
  return fmt::format("{},{},{},{},{}", csv_fields(foot.truth), csv_fields(foot.plan),
                     foot.planned_down ? 1 : 0, foot.load_n, csv_fields(foot.creep));
}

// One csv file of the recording, written row by row.
struct Rows {
  Rows(const fs::path& folder, const std::string& name_) : name(name_), file(folder / name_) {}
  Rows(const fs::path& folder, const std::string& name_, const std::string& header) : Rows(folder, name_) {
    file.write(header + "\n");
  }
  std::string name;
  HashedFile file;
};

}  // namespace

struct RecordingWriter::Files {
  Files(const fs::path& folder_, const RecordingSetup& setup_)
      : folder((make_folders(folder_), folder_)), setup(setup_) {}

  fs::path folder;
  RecordingSetup setup;
  ManifestWriter manifest{folder};
  Rows frames{folder, kFrames, kStampColumn}, camera{folder, kCameraRows, kCameraHeader},
      imu{folder, kImuRows}, encoders{folder, kEncoderRows, encoders_header(setup.joints)},
      forces{folder, kForceRows, kForcesHeader}, plan{folder, kPlanRows, kPlanHeader},
      motion{folder, kMotionRows, kMotionHeader}, true_camera{folder, kTrueCamera, kTrueCameraHeader},
      true_waist{folder, kTrueWaist, kTrueWaistHeader},
      planned_waist{folder, kPlannedWaist, kPlannedWaistHeader}, feet{folder, kFeet, kFeetHeader},
      surfaces{folder, kSurfaces, kSurfacesHeader};
  std::optional<slam::Stamp> last_frame, last_poses, last_motion, last_body, last_feet;
  std::optional<slam::Stamp> imu_begin, imu_end;
  std::optional<bool> with_accelerometer;  // known from the first reading on

  void write_whole(const std::string& name, std::string_view bytes) {
    HashedFile file(folder / name);
    file.write(bytes);
    file.close();
    manifest.add(name, file.hash());
  }

  void add_image(slam::Stamp t, const cv::Mat& image) {
    const slam::CameraIntrinsics& size = setup.calibration.camera;
    require(image.type() == CV_8UC1 && image.cols == size.width_px && image.rows == size.height_px,
            "an image is not 8-bit grey of the camera's size");
    std::vector<unsigned char> png;
    require(cv::imencode(".png", image, png, {cv::IMWRITE_PNG_COMPRESSION, 1}), "an image cannot be encoded");
    const std::string name = fmt::format("{}.png", written(t));
    write_whole(kCameraFolder + name, {reinterpret_cast<const char*>(png.data()), png.size()});
    camera.file.write(fmt::format("{},{}\n", written(t), name));
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
    imu.file.write(fmt::format("{},{}", written(gyro.end), csv_fields(gyro.value)));
    if (accelerometer) {
      require(accelerometer->begin == gyro.begin && accelerometer->end == gyro.end,
              "gyro and accelerometer differ in time");
      imu.file.write("," + csv_fields(accelerometer->value));
    }
    imu.file.write("\n");
    imu_end = gyro.end;
  }

  void add_inertial(const slam::Observation& ideal) {
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

void RecordingWriter::add(const slam::Observation& ideal) {
  require(!files_->last_frame || ideal.t > *files_->last_frame, "a frame is not after the one before");
  files_->frames.file.write(fmt::format("{}\n", written(ideal.t)));
  files_->add_inertial(ideal);
  if (!ideal.image.empty()) files_->add_image(ideal.t, ideal.image);
  if (ideal.plan) files_->plan.file.write(plan_row(written(ideal.t), *ideal.plan));
  files_->last_frame = ideal.t;
}

void RecordingWriter::add(const BodyReading& reading) {
  Files& f = *files_;
  require(!f.last_body || reading.t > *f.last_body, "readings of the body are not in order of time");
  require(reading.q.size() == static_cast<Eigen::Index>(f.setup.joints.size()),
          "not one angle for each joint");
  f.encoders.file.write(encoder_row(reading));
  f.forces.file.write(force_row(reading));
  f.last_body = reading.t;
}

void RecordingWriter::add(const TruePoses& poses) {
  require(!files_->last_poses || poses.t > *files_->last_poses, "true poses are not in order of time");
  files_->true_camera.file.write(fmt::format("{},{}\n", written(poses.t), csv_fields(poses.X_WC)));
  files_->true_waist.file.write(fmt::format("{},{}\n", written(poses.t), csv_fields(poses.X_WB)));
  files_->planned_waist.file.write(fmt::format("{},{}\n", written(poses.t), csv_fields(poses.X_PB)));
  files_->last_poses = poses.t;
}

void RecordingWriter::add(const TrueMotion& motion) {
  require(!files_->last_motion || motion.t > *files_->last_motion, "true motions are not in order of time");
  files_->motion.file.write(motion_row(motion));
  files_->last_motion = motion.t;
}

void RecordingWriter::add(const TrueFeet& feet) {
  require(!files_->last_feet || feet.t > *files_->last_feet, "true feet are not in order of time");
  files_->feet.file.write(
      fmt::format("{},{},{}\n", written(feet.t), foot_fields(feet.left), foot_fields(feet.right)));
  files_->last_feet = feet.t;
}

void RecordingWriter::add(const RecordedSurface& surface) {
  require(std::find(kSurfaceKinds.begin(), kSurfaceKinds.end(), surface.kind) != kSurfaceKinds.end(),
          "a surface is of no known kind");
  files_->surfaces.file.write(
      fmt::format("{},{},{}\n", surface.kind, csv_fields(surface.X_WS), csv_fields(surface.size)));
}

void RecordingWriter::add(const std::string& name, std::string_view text) { files_->write_whole(name, text); }

void RecordingWriter::finish() {
  Files& f = *files_;
  if (!f.with_accelerometer) f.imu.file.write(kImuHeader + "\n");
  f.write_whole(kBody, body_yaml());
  f.write_whole(kCameraSensor, camera_yaml(f.setup));
  f.write_whole(kImuSensor, imu_yaml(f.setup, f.imu_begin));
  f.write_whole(kEncodersSensor, encoders_yaml(f.setup));
  f.write_whole(kForcesSensor, forces_yaml(f.setup));
  f.write_whole(kPlanSensor, plan_yaml(f.setup));
  f.write_whole(kMotionSensor, motion_yaml());
  for (Rows* rows : {&f.frames, &f.camera, &f.imu, &f.encoders, &f.forces, &f.plan, &f.motion, &f.true_camera,
                     &f.true_waist, &f.planned_waist, &f.feet, &f.surfaces}) {
    rows->file.close();
    f.manifest.add(rows->name, rows->file.hash());
  }
  f.manifest.finish();
}

}  // namespace sim::stream
