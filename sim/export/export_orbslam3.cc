#include "sim/export/export_orbslam3.h"

#include "sim/export/export_euroc.h"
#include "sim/export/export_text.h"
#include "sim/export/orbslam3_settings.h"

namespace sim::exports {
namespace {

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

}  // namespace

void export_orbslam3(const ExportContext& out) {
  write_mav0(out, true);
  out.write("settings.yaml", orbslam3_settings(out, true));
  out.write_truth("groundtruth.tum", tum_text(out.truth().camera));
  out.write_readme(kOrbslam3Readme);
}

}  // namespace sim::exports
