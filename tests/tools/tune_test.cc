// Tuning through the program, on short walks in a synthetic room.
#include "tests/sim/trials/synthetic_result.h"
#include "tests/tools/command_line.h"

namespace tests {
namespace {

class Tune : public CommandLine {
 protected:
  Tune() {
    write_result(folder_ / "walks/seed-1", short_walk(24));
    for (const std::string seed : {"2", "3"})
      shell("cp -r walks/seed-1 walks/seed-" + seed + " && echo 'seed: " + seed + "' >> walks/seed-" + seed +
            "/scenario.yaml");
    write_spec("");
  }
  void write_spec(const std::string& more) const {
    write("spec.yaml",
          "parameters: {slam.gyro.sigma_rad_s: {from: 0.001, to: 0.3, start: 0.1}}\n"
          "training: [{recordings: walks, seeds: 1..2}]\n"
          "holdout: [{recordings: walks, seeds: 3" +
              more + "}]\ntrials: 16\npopulation: 5\n");
  }
};

TEST_F(Tune, LeavesAnOverlayThatOtherCommandsTakeAndAReportThatNoOtherTuningReplaces) {
  const Ran ran = gaitslam("tune spec.yaml --jobs 2 --out out").ends(0);
  EXPECT_EQ(ran.complaints(), "");  // no progress line without a terminal
  EXPECT_THAT(ran.out, AllOf(HasSubstr("slam.gyro.sigma_rad_s"), HasSubstr("pose_nll on hold-out")));
  EXPECT_THAT(ok("config walks/seed-1/scenario.yaml --with out/best.yaml"), HasSubstr("best.yaml:3"));
  EXPECT_THAT(text_of("out/report.html"),
              AllOf(HasSubstr("The search"), HasSubstr("better on hold-out runs")));
  const std::string result = text_of("out/tune.json");
  write("other.yaml", text_of("spec.yaml"));
  expect_refused("tune other.yaml --out out", "out/trials.jsonl: is another log: gaitslam tune spec, ");
  EXPECT_EQ(text_of("out/tune.json"), result);
  ok("tune spec.yaml --out out");
}

TEST_F(Tune, WorseOnHoldoutIsRefusedWithExitOne) {
  write_spec(", set: [errors.gyro.sigma_rad_s=0.2]");
  EXPECT_THAT(gaitslam("tune spec.yaml --out out").ends(1).err,
              HasSubstr("rejected: worse than the start on the hold-out recordings"));
  EXPECT_FALSE(fs::exists(folder_ / "out/best.yaml"));
  EXPECT_THAT(text_of("out/report.html"), HasSubstr("rejected: worse on hold-out runs"));
  write("out/best.yaml", "mine");
  expect_refused("tune spec.yaml --out out", "out/best.yaml: was not made by this version");
  EXPECT_EQ(text_of("out/best.yaml"), "mine");
}

}  // namespace
}  // namespace tests
