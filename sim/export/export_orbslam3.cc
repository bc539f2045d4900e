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

Its trajectory `f_run.txt` has stamps in ns. `groundtruth.tum` has the true camera poses, with stamps in s. To compare:

    awk '{$1 = sprintf("%.9f", $1 / 1e9); print}' f_run.txt > run.tum
    evo_ape tum FOLDER/groundtruth.tum run.tum --align --correct_scale
)";

}  // namespace

void export_orbslam3(const ExportContext& out) {
  write_mav0(out);
  out.write("settings.yaml", orbslam3_settings(out, true));
  out.write("groundtruth.tum", tum_text(out.truth().camera));
  out.write_readme(kOrbslam3Readme);
}

}  // namespace sim::exports
