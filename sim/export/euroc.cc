// Formats in the EuRoC/ASL layout.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <deque>
#include <iterator>
#include <map>
#include <utility>

#include "sim/export/export_context.h"
#include "sim/files/hash.h"
#include "sim/recording/image_file.h"
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
  ImageWriter(const ExportContext& out, bool images_within_imu, const std::string& folder)
      : out_(out),
        within_(images_within_imu),
        folder_(folder),
        camera_(rows(out, folder + "data.csv", kCameraHeader)) {}

  void add(const ExportedReading& image) {
    if (within_ && (!first_reading_ || image.t <= *first_reading_)) return;
    waiting_.push_back({image.t, image.image});
    if (!within_) write_until(image.t);
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
      out_.write(folder_ + "data/" + name, recording::encode_png(waiting_.front().second));
      camera_.write(fmt::format("{},{}\n", stamp, name));
      times_.push_back(stamp);
    }
  }

  const ExportContext& out_;
  bool within_;
  const std::string folder_;
  files::HashedFile camera_;
  std::vector<std::int64_t> times_;
  std::optional<slam::Stamp> first_reading_;
  std::deque<std::pair<slam::Stamp, cv::Mat>> waiting_;  // for a later reading
};

std::string lines(const std::vector<std::int64_t>& stamps) {
  return fmt::format("{}{}", fmt::join(stamps, "\n"), stamps.empty() ? "" : "\n");
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

constexpr const char* kCvMatrix = "!!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: f\n   data: ";
constexpr double kCloseBaselines = 40;  // nearer points count as close: as in ORB-SLAM3's own files

// Both images overlap over their whole width.
std::string stereo_section(const slam::CameraIntrinsics& left, const rig::RigSensor& right) {
  std::string overlaps;
  if (equidistant_lens(left))
    overlaps = fmt::format(
        "Camera1.overlappingBegin: 0\nCamera1.overlappingEnd: {}\n"
        "Camera2.overlappingBegin: 0\nCamera2.overlappingEnd: {}\n",
        left.width_px - 1, right.camera.width_px - 1);
  return fmt::format("{}{}Stereo.T_c1_c2: {}[{}]\nStereo.ThDepth: {}\n\n",
                     intrinsics("Camera2", right.camera), overlaps, kCvMatrix,
                     matrix_text(right.X_CS, "", "", ", "), real(kCloseBaselines));
}

std::string imu_section(const ExportContext& out) {
  const recording::ImuNoise noise = noise_of(out.sensor(out.chest()));
  return fmt::format(
      "IMU.T_b_c1: {}[{}]\n"
      "IMU.NoiseGyro: {}\nIMU.NoiseAcc: {}\nIMU.GyroWalk: {}\nIMU.AccWalk: {}\nIMU.Frequency: {}\n\n",
      kCvMatrix, matrix_text(out.X_GS(out.head()), "", "", ", "), real(noise.gyro_density),
      real(noise.accelerometer_density), real(noise.gyro_walk), real(noise.accelerometer_walk),
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
  files::HashedFile plan = rows(out, sensor_rows("plan0"), "");
  bool plan_begun = false;
  const std::vector<int> eyes = out.all(rig::Kind::grey), imus = out.all(rig::Kind::imu);
  std::map<int, ImageWriter> images;  // by sensor
  for (std::size_t i = 0; i < eyes.size(); ++i)
    images.emplace(eyes[i], ImageWriter(out, images_within_imu, folder_of("cam", i)));
  std::map<int, files::HashedFile> readings;
  for (std::size_t i = 0; i < imus.size(); ++i)
    readings.emplace(imus[i], rows(out, folder_of("imu", i) + "data.csv", kImuHeader));
  for (Frames frames(out); const auto frame = frames.next();) {
    for (const ExportedReading& reading : frame->readings)
      if (const auto eye = images.find(reading.sensor); eye != images.end()) {
        eye->second.add(reading);
      } else if (const auto imu = readings.find(reading.sensor); imu != readings.end()) {
        if (!reading.has_acceleration) continue;
        imu->second.write(fmt::format("{},{},{}\n", recording::file_stamp(reading.t),
                                      files::csv_fields(reading.gyro),
                                      files::csv_fields(reading.accelerometer)));
        if (reading.sensor == out.chest())
          for (auto& [sensor, writer] : images) writer.note_reading(reading.t);
      }
    if (!frame->plan) continue;
    if (!std::exchange(plan_begun, true)) plan.write(recording::plan_header(*frame->plan) + "\n");
    plan.write(fmt::format("{},{}\n", recording::file_stamp(frame->t), recording::plan_fields(*frame->plan)));
  }
  if (!plan_begun) plan.write(kPlanHeader + "\n");
  plan.close();
  std::vector<std::vector<std::int64_t>> times;
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    const rig::RigSensor& eye = out.sensor(eyes[i]);
    times.push_back(images.at(eyes[i]).close());
    out.write(
        folder_of("cam", i) + "sensor.yaml",
        recording::camera_yaml({eye.camera, eye.X_CS.inverse() * out.setup.calibration.X_CG}, eye.rate_hz));
  }
  out.write("times.txt", lines(times[0]));
  if (std::vector<std::int64_t> both; times.size() > 1) {
    std::ranges::set_intersection(times[0], times[1], std::back_inserter(both));
    out.write("times_stereo.txt", lines(both));
  }
  for (std::size_t i = 0; i < imus.size(); ++i) {
    const rig::RigSensor& imu = out.sensor(imus[i]);
    readings.at(imus[i]).close();
    out.write(
        folder_of("imu", i) + "sensor.yaml",
        recording::imu_yaml(imu.name + "; +g up at rest", out.X_GS(imus[i]), imu.rate_hz, noise_of(imu)));
  }
  out.write(kBody, recording::body_yaml());
  out.write(sensor_file("plan0"), recording::plan_yaml(out.setup));
  out.write_truth(sensor_file(kMotion), recording::motion_yaml());
  if (out.run.with_truth) out.write(sensor_rows(kMotion), out.motion());
}

void export_euroc(const ExportContext& out) {
  write_mav0(out);
  out.write_readme(kEurocReadme);
}

// OpenCV reads color images as BGR; gray ones have no order.
std::string orbslam3_settings(const ExportContext& out, int camera, std::optional<int> depth, bool inertial) {
  const slam::CameraIntrinsics& lens = out.sensor(camera).camera;
  std::string text = fmt::format(
      "%YAML:1.0\nFile.version: \"1.0\"\n\nCamera.type: \"{}\"\n{}Camera.width: {}\nCamera.height: {}\n"
      "Camera.fps: {:.0f}\nCamera.RGB: 0\n\n",
      equidistant_lens(lens) ? "KannalaBrandt8" : "PinHole", intrinsics("Camera1", lens), lens.width_px,
      lens.height_px, out.sensor(camera).rate_hz);
  if (depth)
    text += fmt::format("RGBD.DepthMapFactor: 1000.0\nStereo.ThDepth: {}\nStereo.b: {}\n\n",
                        real(kCloseBaselines), real(out.sensor(*depth).baseline_m));
  if (const auto eyes = out.all(rig::Kind::grey); inertial && eyes.size() > 1)
    text += stereo_section(lens, out.sensor(eyes[1]));
  return text + (inertial ? imu_section(out) : "") + kOtherSections;
}

void export_orbslam3(const ExportContext& out) {
  write_mav0(out, true);
  out.write("settings.yaml", orbslam3_settings(out, out.head(), std::nullopt, true));
  out.write_truth("groundtruth.tum", tum_text(out.truth().camera));
  out.write_readme(std::string(kOrbslam3Readme) +
                   (out.all(rig::Kind::grey).size() > 1 ? kOrbslam3StereoReadme : "") +
                   (out.all(rig::Kind::depth).empty() ? "" : kOrbslam3DepthReadme));
}

}  // namespace sim::exports
