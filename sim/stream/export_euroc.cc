#include <fmt/format.h>

#include "sim/stream/export_parts.h"
#include "sim/stream/manifest.h"
#include "sim/stream/plan_row.h"
#include "sim/stream/recording_format.h"

namespace sim::stream {
namespace {

using namespace recording_format;

constexpr const char* kEurocReadme =
    R"(Layout of EuRoC/ASL (Burri et al. 2016). `mav0/cam0` and `mav0/imu0` are the sensors,
`mav0/state_groundtruth_estimate0` the true motion of the chest IMU, `times.txt` the images' stamps in ns,
one a line. `mav0/plan0` is an extension: what the walking plan says of the camera at each frame.

GaitSLAM itself reads the folder with `gaitslam replay FOLDER`.
)";

constexpr const char* kOrbReadme =
    R"(For ORB-SLAM3 (v1.0). `settings.yaml` serves its programs without and with the IMU; in their folder:

    ./Examples/Monocular/mono_euroc Vocabulary/ORBvoc.txt FOLDER/settings.yaml FOLDER FOLDER/times.txt run
    ./Examples/Monocular-Inertial/mono_inertial_euroc Vocabulary/ORBvoc.txt FOLDER/settings.yaml FOLDER \
      FOLDER/times.txt run

Its trajectory `f_run.txt` has stamps in ns. `groundtruth.tum` has the true camera poses in s; to compare:

    awk '{$1 = sprintf("%.9f", $1 / 1e9); print}' f_run.txt > run.tum
    evo_ape tum FOLDER/groundtruth.tum run.tum --align --correct_scale
)";

// A file of rows, made with its folder.
HashedFile rows(const Export& out, const std::string& name, const std::string& header) {
  out.write(name, "");
  HashedFile file(out.folder / name);
  if (!header.empty()) file.write(header + "\n");
  return file;
}

void write_imu(HashedFile& imu, const ImuReading& reading, bool& begun) {
  if (!begun) imu.write((reading.accelerometer ? kImuHeader : kGyroHeader) + "\n");
  begun = true;
  imu.write(fmt::format("{},{}{}\n", written(reading.t), csv_fields(reading.gyro),
                        reading.accelerometer ? "," + csv_fields(*reading.accelerometer) : ""));
}

void write_sensors(const Export& out) {
  const RecordingSetup setup = out.setup_of_others();
  out.write(kBody, body_yaml());
  out.write(kCameraSensor, camera_yaml(setup));
  out.write(kImuSensor, imu_yaml(setup, out.noise));
  out.write(kPlanSensor, plan_yaml(setup));
  out.write(kMotionSensor, motion_yaml());
  out.write(kMotionRows, Manifest(out.run.result / "recording").read(kMotionRows));
}

std::string orb_settings(const Export& out) {
  const slam::CameraIntrinsics& camera = out.equidistant.camera;
  const auto& k = std::get<slam::Equidistant>(camera.lens);
  return fmt::format(
      "%YAML:1.0\nFile.version: \"1.0\"\n\nCamera.type: \"KannalaBrandt8\"\nCamera1.fx: {}\nCamera1.fy: {}\n"
      "Camera1.cx: {}\nCamera1.cy: {}\nCamera1.k1: {}\nCamera1.k2: {}\nCamera1.k3: {}\nCamera1.k4: {}\n"
      "Camera.width: {}\nCamera.height: {}\nCamera.fps: {:.0f}\nCamera.RGB: 1\n\n"
      "IMU.T_b_c1: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: f\n   data: [{}]\n"
      "IMU.NoiseGyro: {}\nIMU.NoiseAcc: {}\nIMU.GyroWalk: {}\nIMU.AccWalk: {}\nIMU.Frequency: {}\n\n"
      "{}",
      real(camera.fu_px), real(camera.fv_px), real(camera.u0_px), real(camera.v0_px), real(k.k1), real(k.k2),
      real(k.k3), real(k.k4), camera.width_px, camera.height_px, out.setup.camera_rate_hz,
      matrix_text(out.setup.calibration.X_CG.inverse(), "", "", ", "), real(out.noise.gyro_density),
      real(out.noise.accelerometer_density), real(out.noise.gyro_walk), real(out.noise.accelerometer_walk),
      real(out.setup.imu_rate_hz), orb_rest());
}

}  // namespace

void export_mav0(const Export& out) {
  HashedFile camera = rows(out, kCameraRows, kCameraHeader), imu = rows(out, kImuRows, ""),
             plan = rows(out, kPlanRows, kPlanHeader), times = rows(out, "times.txt", "");
  WholeReadings whole(out.setup.imu_rate_hz);
  bool imu_begun = false;
  for (Seen seen = out.seen(); auto o = seen.next_in_order();) {
    for (const ImuReading& reading : whole.take(*o)) write_imu(imu, reading, imu_begun);
    if (o->plan) plan.write(plan_row(written(o->t), *o->plan));
    if (o->image.empty()) continue;
    const std::string name = fmt::format("{}.png", written(o->t));
    out.write_png(kCameraFolder + name, o->image);
    camera.write(fmt::format("{},{}\n", written(o->t), name));
    times.write(fmt::format("{}\n", written(o->t)));
  }
  for (HashedFile* file : {&camera, &imu, &plan, &times}) file->close();
  write_sensors(out);
}

void export_euroc(const Export& out) {
  export_mav0(out);
  out.write_readme(kEurocReadme, out.lens_fitted());
}

void export_orbslam3(const Export& out) {
  export_mav0(out);
  out.write("settings.yaml", orb_settings(out));
  out.write("groundtruth.tum", tum_of(out.truth().camera));
  out.write_readme(kOrbReadme, out.lens_fitted());
}

}  // namespace sim::stream
