// Formats in the EuRoC/ASL layout.
#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <iterator>
#include <map>
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
one per line. `mav0/plan0` is an extension: the planned motion of the camera at each frame. Further gray cameras
of the rig are `mav0/cam1` and on, further IMUs `mav0/imu1` and on, each mounted as its `T_BS` states;
`times_stereo.txt` has the stamps of which both `cam0` and `cam1` have an image.

GaitSLAM itself reads the folder with `gaitslam replay FOLDER`.
)";

files::HashedFile rows(const ExportContext& out, const std::string& name, const std::string& header) {
  files::HashedFile file(out.new_file(name));
  if (!header.empty()) file.write(header + "\n");
  return file;
}

std::string folder_of(const char* kind, std::size_t number) {
  return fmt::format("mav0/{}{}/", kind, number);
}

/// Images of a camera and their stamps. Some programs read beyond their arrays if an image lacks readings on
/// either side: images_within_imu skips such images.
class ImageWriter {
 public:
  /// folder: mav0/cam0/ or another; sensor: of the rig, or kHead.
  ImageWriter(const ExportContext& out, bool images_within_imu, const std::string& folder, int sensor)
      : out_(out),
        within_(images_within_imu),
        folder_(folder),
        sensor_(sensor),
        camera_(rows(out, folder + "data.csv", kCameraHeader)) {}

  void add(slam::Stamp t, const cv::Mat& image) {
    if (image.empty() || (within_ && (!first_reading_ || t <= *first_reading_))) return;
    waiting_.push_back({t, image});
    if (!within_) write_until(t);
  }
  void note_reading(slam::Stamp t) {
    if (!first_reading_) first_reading_ = t;
    if (within_) write_until(t - slam::Stamp(1));
  }
  /// Returns the stamps of the images.
  std::vector<std::int64_t> close() {
    camera_.close();
    return std::move(times_);
  }

 private:
  void write_until(slam::Stamp t) {
    for (; !waiting_.empty() && waiting_.front().first <= t; waiting_.pop_front()) {
      const std::int64_t stamp = recording::file_stamp(waiting_.front().first);
      const std::string name = fmt::format("{}.png", stamp);
      out_.write_png(folder_ + "data/" + name, waiting_.front().second, sensor_);
      camera_.write(fmt::format("{},{}\n", stamp, name));
      times_.push_back(stamp);
    }
  }

  const ExportContext& out_;
  bool within_;
  const std::string folder_;
  const int sensor_;
  files::HashedFile camera_;
  std::vector<std::int64_t> times_;
  std::optional<slam::Stamp> first_reading_;
  std::deque<std::pair<slam::Stamp, cv::Mat>> waiting_;  // for a later reading
};

std::string lines(const std::vector<std::int64_t>& stamps) {
  std::string text;
  for (const std::int64_t stamp : stamps) text += fmt::format("{}\n", stamp);
  return text;
}

void write_imu_row(files::HashedFile& file, slam::Stamp t, const Eigen::Vector3d& gyro,
                   const Eigen::Vector3d& accelerometer) {
  file.write(fmt::format("{},{},{}\n", recording::file_stamp(t), files::csv_fields(gyro),
                         files::csv_fields(accelerometer)));
}

// sensor.yaml of a further gray camera: as that of the head camera, from its place.
std::string camera_yaml(const ExportContext& out, const rig::RigSensor& sensor) {
  recording::RecordingSetup setup;
  setup.calibration = {sensor.camera, sensor.X_CS.inverse() * out.setup.calibration.X_CG};
  setup.camera_rate_hz = sensor.rate_hz;
  return recording::camera_yaml(setup);
}

std::string imu_yaml(const ExportContext& out, const rig::RigSensor& sensor) {
  const recording::ImuNoise noise = ExportContext::noise_of(sensor);
  return fmt::format(
      "%YAML:1.0\nsensor_type: imu\ncomment: \"{}; +g up at rest\"\nT_BS:\n  cols: 4\n  rows: 4\n"
      "  data: [{}]\nrate_hz: {}\ngyroscope_noise_density: {}\ngyroscope_random_walk: {}\n"
      "accelerometer_noise_density: {}\naccelerometer_random_walk: {}\n",
      sensor.name, matrix_text(out.setup.calibration.X_CG.inverse() * sensor.X_CS, "", "", ",\n         "),
      sensor.rate_hz, noise.gyro_density, noise.gyro_walk, noise.accelerometer_density,
      noise.accelerometer_walk);
}

constexpr const char* kOrbslam3Readme =
    R"(For ORB-SLAM3 (v1.0). `settings.yaml` serves all programs named here. In the folder of ORB-SLAM3:

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

constexpr const char* kOrbslam3StereoReadme = R"(
The stereo programs find the second gray eye in `mav0/cam1`; `times_stereo.txt` has the stamps of which both eyes have an image:

    ./Examples/Stereo/stereo_euroc Vocabulary/ORBvoc.txt FOLDER/settings.yaml FOLDER FOLDER/times_stereo.txt run
    ./Examples/Stereo-Inertial/stereo_inertial_euroc Vocabulary/ORBvoc.txt FOLDER/settings.yaml FOLDER \
      FOLDER/times_stereo.txt run

They write the poses of the camera and of the IMU in meters: `--align se3`.
)";

constexpr const char* kOrbslam3DepthReadme = R"(
For `rgbd_tum` use `gaitslam export ... --format tum`: ORB-SLAM3 takes depth images only as those of a pinhole.
)";

// The keys of one camera: Camera1 or Camera2.
std::string intrinsics(const std::string& name, const slam::CameraIntrinsics& camera) {
  std::string text =
      fmt::format("{0}.fx: {1}\n{0}.fy: {2}\n{0}.cx: {3}\n{0}.cy: {4}\n", name, real(camera.fu_px),
                  real(camera.fv_px), real(camera.u0_px), real(camera.v0_px));
  const auto k = equidistant_lens(camera);
  for (std::size_t i = 0; k && i < k->size(); ++i)
    text += fmt::format("{}.k{}: {}\n", name, i + 1, real((*k)[i]));
  return text;
}

// OpenCV reads color images as BGR; gray ones have no order.
std::string camera_section(const slam::CameraIntrinsics& camera, double rate_hz) {
  return fmt::format(
      "%YAML:1.0\nFile.version: \"1.0\"\n\nCamera.type: \"{}\"\n{}Camera.width: {}\nCamera.height: {}\n"
      "Camera.fps: {:.0f}\nCamera.RGB: 0\n\n",
      equidistant_lens(camera) ? "KannalaBrandt8" : "PinHole", intrinsics("Camera1", camera), camera.width_px,
      camera.height_px, rate_hz);
}

constexpr const char* kCvMatrix = "!!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: f\n   data: ";
constexpr double kCloseBaselines = 40;  // nearer points count as close: as in ORB-SLAM3's own files

// Both images overlap over their whole width.
std::string stereo_section(const ExportContext& out, const rig::RigSensor& right) {
  std::string overlaps;
  if (equidistant_lens(out.camera()))
    overlaps = fmt::format(
        "Camera1.overlappingBegin: 0\nCamera1.overlappingEnd: {}\n"
        "Camera2.overlappingBegin: 0\nCamera2.overlappingEnd: {}\n",
        out.camera().width_px - 1, right.camera.width_px - 1);
  return fmt::format("{}{}Stereo.T_c1_c2: {}[{}]\nStereo.ThDepth: {}\n\n",
                     intrinsics("Camera2", right.camera), overlaps, kCvMatrix,
                     matrix_text(right.X_CS, "", "", ", "), real(kCloseBaselines));
}

std::string depth_section(const rig::RigSensor& depth) {
  return fmt::format("RGBD.DepthMapFactor: 1000.0\nStereo.ThDepth: {}\nStereo.b: {}\n\n",
                     real(kCloseBaselines), real(depth.baseline_m));
}

std::string imu_section(const ExportContext& out) {
  return fmt::format(
      "IMU.T_b_c1: {}[{}]\n"
      "IMU.NoiseGyro: {}\nIMU.NoiseAcc: {}\nIMU.GyroWalk: {}\nIMU.AccWalk: {}\nIMU.Frequency: {}\n\n",
      kCvMatrix, matrix_text(out.setup.calibration.X_CG.inverse(), "", "", ", "),
      real(out.noise.gyro_density), real(out.noise.accelerometer_density), real(out.noise.gyro_walk),
      real(out.noise.accelerometer_walk), real(out.setup.imu_rate_hz));
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
  const std::vector<int> eyes = out.further(rig::Kind::grey), further_imus = out.further(rig::Kind::imu);
  std::map<int, ImageWriter> images;  // by sensor
  images.emplace(kHead, ImageWriter(out, images_within_imu, folder_of("cam", 0), kHead));
  for (std::size_t i = 0; i < eyes.size(); ++i)
    images.emplace(eyes[i], ImageWriter(out, images_within_imu, folder_of("cam", i + 1), eyes[i]));
  std::map<int, files::HashedFile> imus;
  for (std::size_t i = 0; i < further_imus.size(); ++i)
    imus.emplace(further_imus[i], rows(out, folder_of("imu", i + 1) + "data.csv", kImuHeader));
  ImuMerger imu_merger(out.setup.imu_rate_hz);
  for (recording::FilterInput input = out.filter_input(); auto o = out.next(input);) {
    for (const ImuReading& reading : imu_merger.merge(*o)) {
      if (!reading.accelerometer) continue;  // silent
      write_imu_row(imu, reading.t, reading.gyro, *reading.accelerometer);
      for (auto& [sensor, writer] : images) writer.note_reading(reading.t);
    }
    for (const slam::RigReading& reading : o->rig)
      if (const auto at = imus.find(reading.sensor); at != imus.end())
        write_imu_row(at->second, middle(reading), reading.gyro, reading.accelerometer);
      else if (const auto eye = images.find(reading.sensor); eye != images.end())
        eye->second.add(reading.t, reading.image);
    if (o->plan && !std::exchange(plan_begun, true)) plan.write(recording::plan_header(*o->plan) + "\n");
    if (o->plan)
      plan.write(fmt::format("{},{}\n", recording::file_stamp(o->t), recording::plan_fields(*o->plan)));
    images.at(kHead).add(o->t, o->image);
  }
  const std::vector<std::int64_t> times = images.at(kHead).close();
  out.write("times.txt", lines(times));
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    const std::vector<std::int64_t> others = images.at(eyes[i]).close();
    out.write(folder_of("cam", i + 1) + "sensor.yaml", camera_yaml(out, out.sensor(eyes[i])));
    std::vector<std::int64_t> both;
    std::ranges::set_intersection(times, others, std::back_inserter(both));
    if (i == 0) out.write("times_stereo.txt", lines(both));
  }
  for (std::size_t i = 0; i < further_imus.size(); ++i) {
    imus.at(further_imus[i]).close();
    out.write(folder_of("imu", i + 1) + "sensor.yaml", imu_yaml(out, out.sensor(further_imus[i])));
  }
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

std::string orbslam3_settings(const ExportContext& out) {
  const std::vector<int> eyes = out.further(rig::Kind::grey);
  return camera_section(out.camera(), out.setup.camera_rate_hz) +
         (eyes.empty() ? "" : stereo_section(out, out.sensor(eyes.front()))) + imu_section(out) +
         kOtherSections;
}

std::string orbslam3_settings(const ExportContext& out, int camera, std::optional<int> depth) {
  return (camera == kHead ? camera_section(out.camera(), out.setup.camera_rate_hz)
                          : camera_section(out.sensor(camera).camera, out.sensor(camera).rate_hz)) +
         (depth ? depth_section(out.sensor(*depth)) : "") + kOtherSections;
}

void export_orbslam3(const ExportContext& out) {
  write_mav0(out, true);
  out.write("settings.yaml", orbslam3_settings(out));
  out.write_truth("groundtruth.tum", tum_text(out.truth().camera));
  out.write_readme(std::string(kOrbslam3Readme) +
                   (out.further(rig::Kind::grey).empty() ? "" : kOrbslam3StereoReadme) +
                   (out.further(rig::Kind::depth).empty() ? "" : kOrbslam3DepthReadme));
}

}  // namespace sim::exports
