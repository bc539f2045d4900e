#include "sim/export/export_kitti.h"

#include <fmt/format.h>

#include "sim/export/orbslam3_settings.h"

namespace sim::exports {
namespace {

constexpr const char* kKittiReadme =
    R"(Layout of the KITTI odometry benchmark (Geiger et al. 2012): images of one grey camera, numbered;
`times.txt` in s from the first image; `calib.txt`; `poses/00.txt`: true poses of the camera in the axes of the
first one, as the upper three rows of a matrix, row by row, with their times in `poses/times.txt`. `settings.yaml` is for ORB-SLAM3 (v1.0). In the folder of
ORB-SLAM3:

    ./Examples/Monocular/mono_kitti Vocabulary/ORBvoc.txt FOLDER/settings.yaml FOLDER/sequences/00

    gaitslam score FOLDER/poses/00.txt YOUR/00.txt --align sim3     # with a times.txt beside yours
)";

std::string kitti_row(const Eigen::Isometry3d& X) {
  std::string text;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      text += fmt::format("{}{}", row + column ? " " : "", X(row, column));
  return text + "\n";
}

}  // namespace

void export_kitti(const ExportContext& out) {
  const slam::CameraIntrinsics& f = out.camera();
  std::string times, poses;
  std::optional<Eigen::Isometry3d> X_CW_first;
  std::optional<slam::Stamp> first;
  const std::vector<files::TimedPose> truth = out.truth().camera;
  auto pose = truth.begin();
  int count = 0;
  for (recording::FilterInput input = out.filter_input(); auto o = out.next(input);) {
    while (pose != truth.end() && pose->t < o->t) ++pose;
    const bool known = pose != truth.end() && pose->t == o->t;
    if (o->image.empty() || (out.run.with_truth && !known)) continue;
    if (!first) first = o->t;
    if (known && !X_CW_first) X_CW_first = pose->X.inverse();
    out.write_png(fmt::format("sequences/00/image_0/{:06}.png", count++), o->image);
    times += fmt::format("{:.9f}\n", slam::seconds(o->t - *first));
    if (known) poses += kitti_row(*X_CW_first * pose->X);
  }
  const std::string P = fmt::format("{} 0 {} 0 0 {} {} 0 0 0 1 0\n", f.fu_px, f.u0_px, f.fv_px, f.v0_px);
  out.write("sequences/00/times.txt", times);
  out.write("sequences/00/calib.txt", "P0: " + P + "P1: " + P + "P2: " + P + "P3: " + P);
  out.write_truth("poses/00.txt", poses);
  out.write_truth("poses/times.txt", times);  // where readers of such poses look for their times
  out.write("settings.yaml", orbslam3_settings(out, false));
  out.write_readme(kKittiReadme);
}

}  // namespace sim::exports
