// A result folder, or the folder of a tuning, of which one file is the input; the input's first byte says
// which.
#include <array>
#include <utility>

#include "sim/pages/pages.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using File = std::pair<const char*, const char*>;
constexpr const char* kPoses = "0.0 0 0 1 0 0 0 1\n0.5 0.1 0 1 0 0 0 1\n1.0 0.2 0 1 0 0 0 1\n";
constexpr const char* kPoints =
    "p_W_x [m],p_W_y [m],p_W_z [m],P_xx [m^2],P_xy [m^2],P_xz [m^2],P_yy [m^2],P_yz [m^2],P_zz [m^2]";

constexpr std::array kFiles{
    File{
        "score.json",
        R"({"scenario": "walk", "seed": 1, "ending": "completed", "metrics": {"rmse_m": {"value": 1, "unit": "m"}},
             "limits": [{"metric": "rmse_m", "at_most": 2, "value": 1, "passed": true}]})"},
    File{"about.json", R"({"program": "gaitslam", "cause": "", "set_by": {"seed": "argument 1"}})"},
    File{"timing.json", R"({"frame_cpu_ms_median": 0.5})"},
    File{"truth.tum", kPoses},
    File{"plan.tum", kPoses},
    File{"waist_truth.tum", kPoses},
    File{"waist_plan.tum", kPoses},
    File{"estimate_cov.txt",
         "0.0 0 0 1 0 0 0 1 1 0 0 1 0 1 1 0 0 1 0 1\n1.0 0 0 1 0 0 0 1 1 0 0 1 0 1 1 0 0 1 0 1\n"},
    File{"frames.csv",
         "#timestamp "
         "[ns],landmarks,predicted,measured,accepted,begun,deleted,nis_vision,dof_vision,nis_gyro,dof_gyro,"
         "nis_plan_velocity,dof_plan_velocity,nis_height,dof_height,health,cause,refused\n"
         "0,5,5,5,5,0,0,1,2,1,3,1,3,1,1,lost,\"dark, \"\"all\"\" of "
         "it\",\n1000000000,5,5,5,5,0,0,1,2,,,1,3,1,1,ok,,\n"},
    File{"map.csv", "#id,kind,@,begun [ns],attempts,successes\n1,point,1,2,3,1,0,0,1,0,1,0,5,4\n"},
    File{"map_over_time.csv",
         "#timestamp [ns],id,@\n0,1,1,2,3,1,0,0,1,0,1\n1000000000,1,1,2,3,1,0,0,1,0,1\n"},
    File{"searches.csv",
         "#timestamp [ns],landmark,u [px],v [px],S_uu [px^2],S_uv [px^2],S_vv [px^2],found_u [px],found_v "
         "[px]\n"
         "0,1,5,6,1,0,1,5,6\n"},
    File{"feet.csv",
         "#begin [ns],end [ns],foot,phase,moved_x [m],moved_y [m],moved_yaw [rad],creep_x [m],creep_y "
         "[m],creep_yaw "
         "[rad],drift_x [m],drift_y [m],drift_yaw [rad]\n0,500000000,left,stance,1,2,3,0,0,0,1,1,1\n"},
    File{"timing.csv",
         "#timestamp [ns],plan_and_physics [ms],render [ms],encode [ms],record [ms],filter [ms],landmarks\n"
         "0,1,1,1,1,1,5\n"},
    File{
        "tune.json",
        R"({"accepted": true, "name": "a", "objective": "pose_nll", "parameters": [{"key": "k", "unit": "m", "from": 1,
             "to": 2, "scale": "log", "start": 1, "best": 2}], "profiles": [{"key": "k", "at": [1, 2], "rises": [0, 1],
             "threshold": 1, "low": 1, "high": null, "identifiable": true}], "training": {"runs": ["a"], "values":
             {"pose_nll": {"start": [1], "best": [2]}}}, "holdout": {"runs": ["a"], "values": {"pose_nll": {"start": [1],
             "best": [2]}, "nees_position_mean": {"start": [1], "best": [2]}, "nees_orientation_mean": {"start": [1],
             "best": [2]}}}})"},
    File{"history.csv", "#setting,origin,complete,k,pose_nll\n0,start,1,1,3\n1,search,1,2,2\n"}};

bool is_of_tuning(const File& file) {
  const std::string_view name = file.first;
  return name == "tune.json" || name == "history.csv";
}

void restore(const File& file) {
  std::string text = file.second;
  if (const std::size_t at = text.find('@'); at != text.npos) text.replace(at, 1, kPoints);
  fuzz::file(file.first, text);
}

bool make_folder() {
  for (const File& file : kFiles) restore(file);
  fuzz::file("scenario.yaml", "walk: {commands: [{stand: {duration_s: 1}}]}\ncamera: {}\nslam: {}\n");
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const bool made = make_folder();
  if (!made || size == 0) return 0;
  const File& changed = kFiles[data[0] % kFiles.size()];
  fuzz::file(changed.first, fuzz::text_of(data + 1, size - 1));
  if (is_of_tuning(changed)) {
    fuzz::read_or_refuse([] { sim::pages::tune_page(fuzz::folder()); });
  } else {
    fuzz::read_or_refuse([] { sim::pages::runs_page({sim::pages::read_run(fuzz::folder())}); });
  }
  restore(changed);
  return 0;
}
