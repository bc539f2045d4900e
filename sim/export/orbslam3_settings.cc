#include "sim/export/orbslam3_settings.h"

#include <fmt/format.h>

#include "sim/export/export_text.h"

namespace sim::exports {
namespace {

std::string camera_section(const ExportContext& out) {
  const slam::CameraIntrinsics& camera = out.camera();
  const auto [equidistant, k] = lens_model(camera);
  return fmt::format(
      "%YAML:1.0\nFile.version: \"1.0\"\n\nCamera.type: \"{}\"\nCamera1.fx: {}\nCamera1.fy: {}\n"
      "Camera1.cx: {}\nCamera1.cy: {}\n{}Camera.width: {}\nCamera.height: {}\nCamera.fps: {:.0f}\n"
      "Camera.RGB: 1\n\n",
      equidistant ? "KannalaBrandt8" : "PinHole", real(camera.fu_px), real(camera.fv_px), real(camera.u0_px),
      real(camera.v0_px),
      equidistant ? fmt::format("Camera1.k1: {}\nCamera1.k2: {}\nCamera1.k3: {}\nCamera1.k4: {}\n",
                                real(k[0]), real(k[1]), real(k[2]), real(k[3]))
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

std::string orbslam3_settings(const ExportContext& out, bool with_imu) {
  return camera_section(out) + (with_imu ? imu_section(out) : "") + kOtherSections;
}

}  // namespace sim::exports
