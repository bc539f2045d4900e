// Walks by external controllers.
#include "sim/recording/recording.h"
#include "tests/sim/live/run_folder.h"

namespace {

using sim::scenario::Ending;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kWalk = R"(
walk: {commands: [{stand: {duration_s: 0.2}}, {tangent_arc: {radius_m: 0.75, angle_deg: 5}}]}
camera: {width_px: 160, height_px: 120}
slam: {}
limits: {ending: [completed]}
)";

class ControllerTest : public tests::RunFolder {
 protected:
  static std::string program(const std::string& options = "") {
    return fmt::format("walk.controller={{program: [\"{}\", walker]{}}}", GAITSLAM_PROGRAM, options);
  }
};

TEST_F(ControllerTest, TheBuiltInOneAsAProgramGivesTheSameBytes) {
  ASSERT_EQ(run("inside", read(kWalk)).exit_code, 0);
  ASSERT_EQ(run("program", read(kWalk, {program()})).exit_code, 0);
  const auto differ = tests::differences(folder_ / "inside", folder_ / "program");
  EXPECT_THAT(differ, testing::IsSubsetOf({"about.json", "scenario.yaml", "score.json"}));  // they name it
  EXPECT_FALSE(file("program", "estimate.tum").empty());
}

TEST_F(ControllerTest, AProgramThatFailsEndsTheWalkAsWalkerFailed) {
  const auto outcome =
      run("failed", read(kWalk, {fmt::format("walk.controller={{program: [\"{}\"], options: {{fault: exit}}}}",
                                             GAITSLAM_FAULTY_WALKER)}));
  EXPECT_EQ(outcome.ending, Ending::walker_failed);
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.cause, HasSubstr("its last lines: loading | the policy is broken"));
}

}  // namespace
