// Walks that collide with their room.
#include <gmock/gmock.h>

#include "tests/sim/scenario/scenario_files.h"
#include "tests/tools/command_line.h"

namespace {

using testing::HasSubstr;
using testing::StartsWith;
using tests::Ran;

constexpr const char* kAhead = R"(walk:
  commands:
    - stand: {duration_s: 1}
    - straight: {forward_m: 9}
)";
constexpr const char* kPlace = "ahead.yaml:4:7: walk.commands[1]: straight: at ";

class Room : public tests::CommandLineWithCache {
 protected:
  Room() { write("ahead.yaml", kAhead); }
};

TEST_F(Room, AllShippedScenariosAreClearOfIt) {
  std::string files;
  for (const auto& file : sim::scenario::scenario_files()) files += " '" + file.string() + "'";
  const Ran ran = gaitslam("check" + files);
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_EQ(ran.err, "");
}

#if GAITSLAM_HAS_WORLD
TEST_F(Room, APlanThroughItIsRefusedByEachCommandThatWouldWalkIt) {
  for (const std::string command :
       {"check ahead.yaml", "run ahead.yaml", "record ahead.yaml", "run ahead.yaml --seeds 1..2",
        "record ahead.yaml --seeds 1..2", "run ahead.yaml --cached"}) {
    const Ran ran = gaitslam(command);
    EXPECT_EQ(ran.exit_code, 2) << command;
    EXPECT_THAT(ran.err, StartsWith(kPlace)) << command;
    EXPECT_THAT(ran.err, HasSubstr(" is within 0.05 m of chair_2, at (")) << command;
    EXPECT_EQ(ran.out, "") << command;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "results")) << command;
  }
}

TEST_F(Room, ARoomThatIsLargeEnoughIsAccepted) {
  EXPECT_EQ(gaitslam("check ahead.yaml world.room=hall").exit_code, 0);
  write("hall.yaml", "base: ahead.yaml\nworld.room: hall\n");
  EXPECT_EQ(gaitslam("check hall.yaml").exit_code, 0);
}

TEST_F(Room, WhereTheScenarioAllowsACollisionTheWalkIsMadeAndSaysWhatWasTouched) {
  const Ran ran = gaitslam("run ahead.yaml limits.ending=[completed,collided]");
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("collided"));
  EXPECT_THAT(text_of("results/ahead/seed-1/about.json"), HasSubstr(" touched chair_2 at ("));
}

TEST_F(Room, ACollisionThatIsNotAllowedIsExitCodeThreeAndNamesWhatWhereAndWhen) {
  shell("mkdir models && cp '" GAITSLAM_SOURCE_DIR "/models/hrp2.xml' '" GAITSLAM_SOURCE_DIR
        "/models/floor.xml' models");
  write("models/narrow.xml",
        "<mujoco><worldbody><geom name='floor' type='plane' size='20 20 1' condim='3'/>"
        "<body name='cupboard' pos='0.9 0 1'><geom type='box' size='0.5 1 1' contype='0' "
        "conaffinity='0'/></body></worldbody></mujoco>");
  write("pushed.yaml", R"(walk.commands: [{stand: {duration_s: 4}}]
world: {room: narrow, pushes: [{push: {time_s: 2, impulse_ns: 40}}]}
)");
  const Ran ran = gaitslam("run pushed.yaml --models models");
  EXPECT_EQ(ran.exit_code, 3);
  EXPECT_THAT(ran.err,
              testing::ContainsRegex("gaitslam: collided: [A-Z_0-9]+ touched cupboard at \\(0\\.4.*\\) "
                                     "m in the room after 2\\.[0-9]+ s\n"));
}
#else
TEST_F(Room, WithoutASimulatorCheckSaysThatItDidNotLook) {
  EXPECT_THAT(gaitslam("check ahead.yaml").out, HasSubstr("whether it is clear of its room was not checked"));
}
#endif

}  // namespace
