// Formats in the EuRoC/ASL layout.
#include <fmt/format.h>

#include <deque>
#include <optional>
#include <utility>

#include "sim/export/export_context.h"
#include "sim/export/ros_messages.h"
#include "sim/files/hash.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording_format.h"

namespace sim::exports {
namespace {

using namespace recording::recording_format;

constexpr const char* kEurocReadme =
    R"(Layout of EuRoC/ASL (Burri et al. 2016). `mav0/cam0` and `mav0/imu0` are the sensors,
`mav0/state_groundtruth_estimate0` the true motion of the chest IMU, `times.txt` the images' stamps in ns,
one per line. `mav0/plan0` is an extension: the planned motion of the camera at each frame.

GaitSLAM itself reads the folder with `gaitslam replay FOLDER`.
)";

files::HashedFile rows(const ExportContext& out, const std::string& name, const std::string& header) {
  files::HashedFile file(out.new_file(name));
  if (!header.empty()) file.write(header + "\n");
  return file;
}

/// Images and their stamps. Some programs read beyond their arrays if an image lacks readings on either side:
/// images_within_imu skips such images.
class ImageWriter {
 public:
  ImageWriter(const ExportContext& out, bool images_within_imu)
      : out_(out),
        within_(images_within_imu),
        camera_(rows(out, kCameraRows, kCameraHeader)),
        times_(rows(out, "times.txt", "")) {}

  void add(const slam::Observation& o) {
    if (o.image.empty() || (within_ && (!first_reading_ || o.t <= *first_reading_))) return;
    waiting_.push_back({o.t, o.image});
    if (!within_) write_until(o.t);
  }
  void note_reading(slam::Stamp t) {
    if (!first_reading_) first_reading_ = t;
    if (within_) write_until(t - slam::Stamp(1));
  }
  void close() {
    camera_.close();
    times_.close();
  }

 private:
  void write_until(slam::Stamp t) {
    for (; !waiting_.empty() && waiting_.front().first <= t; waiting_.pop_front()) {
      const std::int64_t stamp = recording::file_stamp(waiting_.front().first);
      const std::string name = fmt::format("{}.png", stamp);
      out_.write_png(kCameraFolder + name, waiting_.front().second);
      camera_.write(fmt::format("{},{}\n", stamp, name));
      times_.write(fmt::format("{}\n", stamp));
    }
  }

  const ExportContext& out_;
  bool within_;
  files::HashedFile camera_, times_;
  std::optional<slam::Stamp> first_reading_;
  std::deque<std::pair<slam::Stamp, cv::Mat>> waiting_;  // for a later reading
};

constexpr const char* kOrbslam3Readme =
    R"(For ORB-SLAM3 (v1.0). `settings.yaml` serves its programs without and with the IMU. In the folder of ORB-SLAM3:

    ./Examples/Monocular/mono_euroc Vocabulary/ORBvoc.txt FOLDER/settings.yaml FOLDER FOLDER/times.txt run
    ./Examples/Monocular-Inertial/mono_inertial_euroc Vocabulary/ORBvoc.txt FOLDER/settings.yaml FOLDER \
      FOLDER/times.txt run

Both write `f_run.txt`, with stamps in ns: `mono_euroc` poses of the camera, whose scale is unknown, `mono_inertial_euroc` poses
of the IMU. The truth of the camera is `groundtruth.tum`, that of the IMU `mav0/state_groundtruth_estimate0/data.csv`. To compare:

    gaitslam score FOLDER/groundtruth.tum f_run.txt --align sim3                                  # mono_euroc
    gaitslam score FOLDER/mav0/state_groundtruth_estimate0/data.csv f_run.txt --align se3         # mono_inertial_euroc

evo wants stamps in s: awk '{$1 = sprintf("%.9f", $1 / 1e9); print}' f_run.txt > run.tum

Images before the first reading of the IMU and after its last one are left out: `mono_inertial_euroc` reads beyond its arrays
where there are such images.
)";

std::string camera_section(const ExportContext& out) {
  const slam::CameraIntrinsics& camera = out.camera();
  const auto k = equidistant_lens(camera);
  return fmt::format(
      "%YAML:1.0\nFile.version: \"1.0\"\n\nCamera.type: \"{}\"\nCamera1.fx: {}\nCamera1.fy: {}\n"
      "Camera1.cx: {}\nCamera1.cy: {}\n{}Camera.width: {}\nCamera.height: {}\nCamera.fps: {:.0f}\n"
      "Camera.RGB: 1\n\n",
      k ? "KannalaBrandt8" : "PinHole", real(camera.fu_px), real(camera.fv_px), real(camera.u0_px),
      real(camera.v0_px),
      k ? fmt::format("Camera1.k1: {}\nCamera1.k2: {}\nCamera1.k3: {}\nCamera1.k4: {}\n", real((*k)[0]),
                      real((*k)[1]), real((*k)[2]), real((*k)[3]))
        : "",
      camera.width_px, camera.height_px, out.setup.camera_rate_hz);
}

std::string imu_section(const ExportContext& out) {
  return fmt::format(
      "IMU.T_b_c1: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: f\n   data: [{}]\n"
      "IMU.NoiseGyro: {}\nIMU.NoiseAcc: {}\nIMU.GyroWalk: {}\nIMU.AccWalk: {}\nIMU.Frequency: {}\n\n",
      matrix_text(out.setup.calibration.X_CG.inverse(), "", "", ", "), real(out.noise.gyro_density),
      real(out.noise.accelerometer_density), real(out.noise.gyro_walk), real(out.noise.accelerometer_walk),
      real(out.setup.imu_rate_hz));
}

constexpr const char* kOtherSections = R"(ORBextractor.nFeatures: 1000
ORBextractor.scaleFactor: 1.2
ORBextractor.nLevels: 8
ORBextractor.iniThFAST: 20
ORBextractor.minThFAST: 7

Viewer.KeyFrameSize: 0.05
Viewer.KeyFrameLineWidth: 1.0
Viewer.GraphLineWidth: 0.9
Viewer.PointSize: 2.0
Viewer.CameraSize: 0.08
Viewer.CameraLineWidth: 3.0
Viewer.ViewpointX: 0.0
Viewer.ViewpointY: -0.7
Viewer.ViewpointZ: -3.5
Viewer.ViewpointF: 500.0
)";

}  // namespace

void write_mav0(const ExportContext& out, bool images_within_imu) {
  files::HashedFile imu = rows(out, kImuRows, kImuHeader), plan = rows(out, kPlanRows, "");
  bool plan_begun = false;
  ImageWriter images(out, images_within_imu);
  ImuMerger imu_merger(out.setup.imu_rate_hz);
  for (recording::FilterInput input = out.filter_input(); auto o = out.next(input);) {
    for (const ImuReading& reading : imu_merger.merge(*o)) {
      if (!reading.accelerometer) continue;  // silent
      imu.write(fmt::format("{},{},{}\n", recording::file_stamp(reading.t), files::csv_fields(reading.gyro),
                            files::csv_fields(*reading.accelerometer)));
      images.note_reading(reading.t);
    }
    if (o->plan && !std::exchange(plan_begun, true)) plan.write(recording::plan_header(*o->plan) + "\n");
    if (o->plan)
      plan.write(fmt::format("{},{}\n", recording::file_stamp(o->t), recording::plan_fields(*o->plan)));
    images.add(*o);
  }
  images.close();
  if (!plan_begun) plan.write(kPlanHeader + "\n");
  for (files::HashedFile* file : {&imu, &plan}) file->close();
  out.write(kBody, recording::body_yaml());
  out.write(kCameraSensor, recording::camera_yaml(out.setup));
  out.write(kImuSensor, recording::imu_yaml(out.setup, out.noise));
  out.write(kPlanSensor, recording::plan_yaml(out.setup));
  out.write_truth(kMotionSensor, recording::motion_yaml());
  out.write_truth(kMotionRows, recording::Manifest(out.run.result / "recording").read(kMotionRows));
}

void export_euroc(const ExportContext& out) {
  write_mav0(out);
  out.write_readme(kEurocReadme);
}

std::string orbslam3_settings(const ExportContext& out, bool with_imu) {
  return camera_section(out) + (with_imu ? imu_section(out) : "") + kOtherSections;
}

void export_orbslam3(const ExportContext& out) {
  write_mav0(out, true);
  out.write("settings.yaml", orbslam3_settings(out, true));
  out.write_truth("groundtruth.tum", tum_text(out.truth().camera));
  out.write_readme(kOrbslam3Readme);
}

}  // namespace sim::exports
