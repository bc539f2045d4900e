// Tuning through the program, on short walks in a synthetic room.
#include <gmock/gmock.h>

#include "tests/sim/trials/synthetic_result.h"
#include "tests/tools/command_line.h"

namespace {

using testing::AllOf;
using testing::HasSubstr;
using tests::Ran;

class Tune : public tests::CommandLine {
 protected:
  void write_walks() const {
    tests::write_result(folder_ / "walks/seed-1", tests::short_walk(24));
    for (const char* seed : {"2", "3"})
      shell(std::string("cp -r walks/seed-1 walks/seed-") + seed + " && echo 'seed: " + seed +
            "' >> walks/seed-" + seed + "/scenario.yaml");
  }
  void write_spec(const std::string& more = "") const {
    write("spec.yaml",
          "parameters: {slam.gyro.sigma_rad_s: {from: 0.001, to: 0.3, start: 0.1}}\n"
          "training: [{recordings: walks, seeds: 1..2}]\n"
          "holdout: [{recordings: walks, seeds: 3" +
              more + "}]\ntrials: 16\npopulation: 5\n");
  }
};

TEST_F(Tune, LeavesAnOverlayThatOtherCommandsTakeAndAReport) {
  write_walks();
  write_spec();
  const Ran ran = gaitslam("tune spec.yaml --jobs 2");
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_EQ(ran.complaints(), "");  // no progress line without a terminal
  EXPECT_THAT(ran.out, AllOf(HasSubstr("slam.gyro.sigma_rad_s"), HasSubstr("pose_nll on hold-out")));
  EXPECT_THAT(gaitslam("config walks/seed-1/scenario.yaml --with results/tune-spec/best.yaml").out,
              HasSubstr("best.yaml:3"));
  EXPECT_THAT(text_of("results/tune-spec/report.html"),
              AllOf(HasSubstr("The search"), HasSubstr("better on hold-out runs")));
}

TEST_F(Tune, WorseOnHoldoutIsRefusedWithExitOne) {
  write_walks();
  write_spec(", set: [errors.gyro.sigma_rad_s=0.2]");
  const Ran ran = gaitslam("tune spec.yaml --out out");
  EXPECT_EQ(ran.exit_code, 1) << ran.out;
  EXPECT_THAT(ran.err, HasSubstr("rejected: worse than the start on the hold-out recordings"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/best.yaml"));
  EXPECT_THAT(text_of("out/report.html"), HasSubstr("rejected: worse on hold-out runs"));
  write("out/best.yaml", "mine");
  EXPECT_THAT(refusal("tune spec.yaml --out out"), HasSubstr("out/best.yaml: was not made by this version"));
  EXPECT_EQ(text_of("out/best.yaml"), "mine");
}

TEST_F(Tune, TheResultOfAnotherTuningIsNotReplaced) {
  write_walks();
  write_spec();
  ASSERT_EQ(gaitslam("tune spec.yaml --out out").exit_code, 0);
  const std::string result = text_of("out/tune.json");
  write("other.yaml", text_of("spec.yaml"));
  EXPECT_THAT(refusal("tune other.yaml --out out"),
              HasSubstr("out/trials.jsonl: is another log: gaitslam tune spec, "));
  EXPECT_EQ(text_of("out/tune.json"), result);
  EXPECT_EQ(gaitslam("tune spec.yaml --out out").exit_code, 0) << "the same tuning may be repeated";
}

}  // namespace
