// The EuRoC/ASL layout with settings for ORB-SLAM3. The TUM RGB-D layout uses them too.
#include "sim/export/export_context.h"

namespace sim::exports {
namespace {

std::string intrinsics(const std::string& name, const slam::CameraIntrinsics& camera) {
  std::string text =
      fmt::format("{0}.fx: {1}\n{0}.fy: {2}\n{0}.cx: {3}\n{0}.cy: {4}\n", name, real(camera.fu_px),
                  real(camera.fv_px), real(camera.u0_px), real(camera.v0_px));
  const auto k = equidistant_lens(camera);
  for (std::size_t i = 0; k && i < k->size(); ++i)
    text += fmt::format("{}.k{}: {}\n", name, i + 1, real((*k)[i]));
  return text;
}

// Points count as close up to the depth z at which a disparity error changes it by a tenth: z/b = f / (10
// sigma). A matched corner of the two gray cameras has an error of a quarter of a pixel.
constexpr double kCloseError = 0.1, kCornerSigma_px = 0.25;

double close_baselines(double focal_px, double disparity_sigma_px) {
  return kCloseError * focal_px / disparity_sigma_px;
}

// Both images overlap over their whole width.
std::string stereo_section(const slam::CameraIntrinsics& left, const rig::RigSensor& right) {
  std::string overlaps;
  if (equidistant_lens(left))
    overlaps = fmt::format(
        "Camera1.overlappingBegin: 0\nCamera1.overlappingEnd: {}\n"
        "Camera2.overlappingBegin: 0\nCamera2.overlappingEnd: {}\n",
        left.width_px - 1, right.camera.width_px - 1);
  return filled_text("orbslam3_right.yaml", intrinsics("Camera2", right.camera), overlaps,
                     matrix_text(right.X_CS, "", "", ", "), close_baselines(left.fu_px, kCornerSigma_px));
}

std::string imu_section(const ExportContext& out) {
  const recording::ImuNoise noise = noise_of(out.sensor(out.chest()));
  return filled_text("orbslam3_imu.yaml", matrix_text(out.X_GS(out.head()), "", "", ", "),
                     real(noise.gyro_density), real(noise.accelerometer_density), real(noise.gyro_walk),
                     real(noise.accelerometer_walk), real(out.setup.imu_rate_hz));
}

}  // namespace

bool has_stereo(const ExportContext& out) {
  constexpr double kDistance_m = 3, kLeastOverlap = 0.5;
  const auto eyes = out.all(rig::Kind::gray);
  if (eyes.size() < 2) return false;
  const double part = overlap(out.sensor(out.head()), out.sensor(eyes[1]), kDistance_m);
  if (part < kLeastOverlap)
    out.run.warn(fmt::format("{} sees {:.0f} % of the head camera's view at {} m: no stereo settings",
                             out.sensor(eyes[1]).name, 100 * part, kDistance_m));
  return part >= kLeastOverlap;
}

// OpenCV reads color images as BGR. For gray images the order does not matter.
std::string orbslam3_settings(const ExportContext& out, int camera, std::optional<int> depth, bool inertial) {
  const slam::CameraIntrinsics& lens = out.sensor(camera).camera;
  std::string text =
      filled_text("orbslam3_head.yaml", equidistant_lens(lens) ? "KannalaBrandt8" : "PinHole",
                  intrinsics("Camera1", lens), lens.width_px, lens.height_px, out.sensor(camera).rate_hz);
  if (depth) {
    const rig::RigSensor& measured = out.sensor(*depth);
    const double close = close_baselines(measured.camera.fu_px, measured.disparity_sigma_px);
    text +=
        fmt::format("RGBD.DepthMapFactor: 1000.0\nStereo.ThDepth: {:.1f}\nStereo.b: {}\n\n",
                    std::min(close, measured.furthest_m / measured.baseline_m), real(measured.baseline_m));
  }
  if (inertial && has_stereo(out)) text += stereo_section(lens, out.sensor(out.all(rig::Kind::gray)[1]));
  return (text + (inertial ? imu_section(out) : "")).append(text_of("orbslam3_settings.yaml"));
}

void export_orbslam3(const ExportContext& out) {
  write_mav0(out, true);
  const std::string settings = orbslam3_settings(out, out.head(), std::nullopt, true);
  out.write("settings.yaml", settings);
  out.write_truth("groundtruth.tum", tum_text(out.truth().camera));
  out.write_readme({"orbslam3.md", settings.find("Stereo.") != settings.npos ? "orbslam3_stereo.md" : "",
                    out.all(rig::Kind::depth).empty() ? "" : "orbslam3_depth.md"},
                   out.all(rig::Kind::gray));
}

}  // namespace sim::exports
