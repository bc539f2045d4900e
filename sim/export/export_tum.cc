#include "sim/export/export_tum.h"

#include <fmt/format.h>

#include "sim/export/export_text.h"
#include "sim/export/imu_merger.h"
#include "sim/export/orbslam3_settings.h"

namespace sim::exports {
namespace {

constexpr const char* kTumReadme =
    R"(Layout of the TUM RGB-D benchmark (Sturm et al. 2012): `rgb/`, `rgb.txt`, `accelerometer.txt`, and true
camera poses in `groundtruth.txt`; `plan.txt` has the camera poses of the walking plan, `estimate.txt` (if a filter
ran) those of GaitSLAM's filter. `settings.yaml` is for ORB-SLAM3 (v1.0). In the folder of ORB-SLAM3:

    ./Examples/Monocular/mono_tum Vocabulary/ORBvoc.txt FOLDER/settings.yaml FOLDER
    evo_ape tum FOLDER/groundtruth.txt KeyFrameTrajectory.txt --align --correct_scale
)";

// Three lines before the first row, which is the number that readers skip.
std::string header(const char* what, const ExportContext& out, const char* columns) {
  return fmt::format("# {}\n# file: {}, seed {}\n# {}\n", what, out.run.name, out.run.seed, columns);
}

}  // namespace

void export_tum(const ExportContext& out) {
  const char* poses = "timestamp tx ty tz qx qy qz qw";
  std::string images = header("color images", out, "timestamp filename"),
              accelerations = header("accelerometer data, chest IMU", out, "timestamp ax ay az"),
              plan = header("planned camera poses", out, poses);
  ImuMerger imu_merger(out.setup.imu_rate_hz);
  for (recording::FilterInput input = out.filter_input(); auto o = out.next(input);) {
    for (const ImuReading& reading : imu_merger.merge(*o))
      if (const auto& a = reading.accelerometer)
        accelerations += fmt::format("{} {} {} {}\n", written_seconds(reading.t), a->x(), a->y(), a->z());
    if (o->plan) plan += files::tum_row(recording::kEpoch + o->t, o->plan->X_PC);
    if (o->image.empty()) continue;
    const std::string name = fmt::format("rgb/{}.png", written_seconds(o->t));
    out.write_png(name, o->image);
    images += fmt::format("{} {}\n", written_seconds(o->t), name);
  }
  out.write("rgb.txt", images);
  out.write("accelerometer.txt", accelerations);
  out.write("plan.txt", plan);
  out.write_truth("groundtruth.txt",
                  header("ground truth trajectory", out, poses) + tum_text(out.truth().camera));
  if (const auto rows = out.estimate(); !rows.empty())
    out.write("estimate.txt",
              header("estimated trajectory", out, poses) + tum_text({rows.begin(), rows.end()}));
  out.write("settings.yaml", orbslam3_settings(out, false));
  out.write_readme(kTumReadme);
}

}  // namespace sim::exports
