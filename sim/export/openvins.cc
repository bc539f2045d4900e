// A bag and the EuRoC/ASL layout, with settings and calibrations for OpenVINS.
#include <numeric>

#include "sim/export/export_context.h"

namespace sim::exports {
namespace {

std::string rows_text(const Eigen::Isometry3d& X) { return matrix_text(X, "    - [", "]", "\n"); }

// T_imu_cam maps from the camera to the IMU, T_cn_cnm1 from the previous camera. timeshift_cam_imu: the IMU's
// stamps minus the camera's; the camera's clock may be ahead of the head camera's.
std::string camera_chain(const ExportContext& out) {
  const std::vector<int> eyes = out.all(rig::Kind::gray);
  std::string text = "%YAML:1.0\n\n";
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    const rig::RigSensor& eye = out.sensor(eyes[i]);
    const slam::CameraIntrinsics& camera = eye.camera;
    const auto lens = equidistant_lens(camera);
    const auto k = lens.value_or(std::array<double, 4>{});
    std::vector<std::size_t> others(eyes.size());
    std::iota(others.begin(), others.end(), 0u);
    others.erase(others.begin() + std::ptrdiff_t(i));
    const std::string from_previous =
        i == 0
            ? ""
            : fmt::format("  T_cn_cnm1:\n{}\n", rows_text(eye.X_CS.inverse() * out.sensor(eyes[i - 1]).X_CS));
    text += filled_text("openvins_camera.yaml", i, rows_text(out.X_GS(eyes[i])), from_previous,
                        fmt::join(others, ", "), real(k[0]), real(k[1]), real(k[2]), real(k[3]),
                        lens ? "equidistant" : "radtan", real(camera.fu_px), real(camera.fv_px),
                        real(camera.u0_px), real(camera.v0_px), camera.width_px, camera.height_px,
                        real(out.sensor(out.chest()).time_offset_s - eye.time_offset_s));
  }
  return text;
}

// T_i_b maps from the chest IMU to this one. time_offset: the chest IMU's stamps minus this IMU's.
std::string imu_chain(const ExportContext& out) {
  std::string text = "%YAML:1.0\n\n";
  for (int number = 0; const int i : out.all(rig::Kind::imu)) {
    const recording::ImuNoise noise = noise_of(out.sensor(i));
    text += filled_text("openvins_imu.yaml", number++, rows_text(out.X_GS(i).inverse()),
                        real(noise.accelerometer_density), real(noise.accelerometer_walk),
                        real(noise.gyro_density), real(noise.gyro_walk), real(out.sensor(i).rate_hz),
                        real(out.sensor(out.chest()).time_offset_s - out.sensor(i).time_offset_s));
  }
  return text;
}

// OpenVINS starts once it tracks three quarters of this many corners, so even a small image must always
// have this many.
int initial_features(const slam::CameraIntrinsics& camera) {
  constexpr double kPixels = 320 * 240, kFewest = 25, kMost = 50;
  return int(std::clamp(kFewest * camera.width_px * camera.height_px / kPixels, kFewest, kMost));
}

// For its start, OpenVINS picks `poses` images (at most 6) that are at least window/(poses + 1) apart. It
// never starts if the window has fewer of them.
int initial_poses(double period_s) {
  constexpr double kWindow_s = 2;  // init_window_time
  int poses = 6;
  while (poses > 2 && poses * std::ceil(kWindow_s / (poses + 1) / period_s) * period_s > kWindow_s) --poses;
  return poses;
}

}  // namespace

double percentile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0;
  const auto at = values.begin() + std::lround(fraction * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

TrackedImages tracked_images(const slam::CameraIntrinsics& camera, double rate_hz, const WalkMotion& motion) {
  constexpr double kWindow_m = 0.15, kIntervals = 10, kStep = 0.1, kFastTurns = 0.9;
  const double speed = percentile(motion.speeds_m_s, 0.5),
               turn = std::max(1e-3, percentile(motion.turns_rad_s, kFastTurns)),
               wanted = speed > 0 ? kWindow_m / (kIntervals * speed) * rate_hz : 1,
               most = std::max(1.0, kStep * camera.width_px / (camera.fu_px * turn) * rate_hz);
  const int every = int(std::lround(std::clamp(wanted, 1.0, most)));
  return {every, rate_hz / (every - 0.5)};
}

void export_openvins(const ExportContext& out) {
  const WalkMotion motion = write_mav0(out);
  write_ros_bag(out, "bag/", false);
  const TrackedImages tracked =
      tracked_images(out.sensor(out.head()).camera, out.setup.camera_rate_hz, motion);
  const int features = initial_features(out.sensor(out.head()).camera);
  out.write(
      "estimator_config.yaml",
      text_of("openvins_estimator.yaml") +
          fmt::format("init_max_features: {}\ninit_dyn_num_pose: {}\nuse_stereo: {}\nmax_cameras: "
                      "{}\ntrack_frequency: {:.1f}\n",
                      features, initial_poses(tracked.every / out.setup.camera_rate_hz), has_stereo(out),
                      out.all(rig::Kind::gray).size() > 1 ? 2 : 1, tracked.frequency_hz));
  out.write("kalibr_imu_chain.yaml", imu_chain(out));
  out.write("kalibr_imucam_chain.yaml", camera_chain(out));
  if (out.run.with_truth) out.write("groundtruth.csv", out.motion());
  out.write_truth("groundtruth.tum", tum_text(out.truth().camera));
  out.write_readme({}, out.all(rig::Kind::gray),
                   filled_text("openvins.md", percentile(motion.speeds_m_s, 0.5), tracked.every,
                               tracked.frequency_hz, features));
}

}  // namespace sim::exports
