// The formats whose readers know the pinhole alone: TUM RGB-D and KITTI odometry, with the lens taken out of
// the images.
#include <fmt/format.h>

#include "sim/stream/export_parts.h"
#include "sim/stream/manifest.h"

namespace sim::stream {
namespace {

constexpr const char* kTumReadme =
    R"(Layout of the TUM RGB-D benchmark (Sturm et al. 2012): `rgb/`, `rgb.txt`, `accelerometer.txt`, and true
camera poses in `groundtruth.txt`; `plan.txt` has the walking plan's camera poses, `estimate.txt` (if a filter
ran) those of GaitSLAM's filter. `settings.yaml` is for ORB-SLAM3 (v1.0); in its folder:

    ./Examples/Monocular/mono_tum Vocabulary/ORBvoc.txt FOLDER/settings.yaml FOLDER
    evo_ape tum FOLDER/groundtruth.txt KeyFrameTrajectory.txt --align --correct_scale
)";

constexpr const char* kKittiReadme =
    R"(Layout of the KITTI odometry benchmark (Geiger et al. 2012): images of one grey camera, numbered;
`times.txt` in s from the first; `calib.txt`; `poses/00.txt`: true poses of the camera in axes of the first
one, the first three rows by rows. `settings.yaml` is for ORB-SLAM3 (v1.0); in its folder:

    ./Examples/Monocular/mono_kitti Vocabulary/ORBvoc.txt FOLDER/settings.yaml FOLDER/sequences/00

    evo_traj kitti FOLDER/poses/00.txt --plot
)";

// Three lines before the first row: readers skip as many.
std::string header(const char* what, const Export& out, const char* columns) {
  return fmt::format("# {}\n# file: {}, seed {}\n# {}\n", what, out.run.name, out.run.seed, columns);
}

std::string kitti_row(const Eigen::Isometry3d& X) {
  std::string text;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      text += fmt::format("{}{}", row + column ? " " : "", X(row, column));
  return text + "\n";
}

}  // namespace

void export_tum(const Export& out) {
  const char* poses = "timestamp tx ty tz qx qy qz qw";
  std::string images = header("color images", out, "timestamp filename"),
              accelerations = header("accelerometer data, chest IMU", out, "timestamp ax ay az"),
              plan = header("planned camera poses", out, poses);
  WholeReadings whole(out.setup.imu_rate_hz);
  for (Seen seen = out.seen(); auto o = seen.next_in_order();) {
    for (const ImuReading& reading : whole.take(*o))
      if (const auto& a = reading.accelerometer)
        accelerations += fmt::format("{} {} {} {}\n", written_seconds(reading.t), a->x(), a->y(), a->z());
    if (o->plan) plan += tum_row(kEpoch + o->t, o->plan->X_PC);
    if (o->image.empty()) continue;
    const std::string name = fmt::format("rgb/{}.png", written_seconds(o->t));
    out.write_png(name, o->image);
    images += fmt::format("{} {}\n", written_seconds(o->t), name);
  }
  out.write("rgb.txt", images);
  out.write("accelerometer.txt", accelerations);
  out.write("plan.txt", plan);
  out.write("groundtruth.txt", header("ground truth trajectory", out, poses) + tum_of(out.truth().camera));
  if (const auto rows = out.estimate(); !rows.empty())
    out.write("estimate.txt",
              header("estimated trajectory", out, poses) + tum_of({rows.begin(), rows.end()}));
  out.write("settings.yaml", orb_camera(out) + orb_rest());
  out.write_readme(kTumReadme);
}

void export_kitti(const Export& out) {
  const slam::CameraIntrinsics& f = out.camera();
  std::string times, poses;
  std::optional<Eigen::Isometry3d> X_CW_first;
  std::optional<slam::Stamp> first;
  const std::vector<TimedPose> truth = out.truth().camera;
  auto pose = truth.begin();
  int count = 0;
  for (Seen seen = out.seen(); auto o = seen.next_in_order();) {
    while (pose != truth.end() && pose->t < o->t) ++pose;
    if (o->image.empty() || pose == truth.end() || pose->t != o->t) continue;
    if (!first) first = o->t, X_CW_first = pose->X.inverse();
    out.write_png(fmt::format("sequences/00/image_0/{:06}.png", count++), o->image);
    times += fmt::format("{:.9f}\n", slam::seconds(o->t - *first));
    poses += kitti_row(*X_CW_first * pose->X);
  }
  const std::string P = fmt::format("{} 0 {} 0 0 {} {} 0 0 0 1 0\n", f.fu_px, f.u0_px, f.fv_px, f.v0_px);
  out.write("sequences/00/times.txt", times);
  out.write("sequences/00/calib.txt", "P0: " + P + "P1: " + P + "P2: " + P + "P3: " + P);
  out.write("poses/00.txt", poses);
  out.write("settings.yaml", orb_camera(out) + orb_rest());
  out.write_readme(kKittiReadme);
}

}  // namespace sim::stream
