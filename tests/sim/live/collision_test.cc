// Runs in which the robot meets walls and furniture, without camera and filter.
#include <gmock/gmock.h>

#include <fstream>

#include "sim/live/room_check.h"
#include "sim/live/run.h"
#include "tests/sim/result/result_folder.h"

namespace {

namespace fs = std::filesystem;
using sim::result::Outcome;
using sim::scenario::Ending;
using sim::scenario::ReadScenario;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

constexpr const char* kAhead = R"(
walk:
  commands:
    - stand: {duration_s: 0.5}
    - straight: {forward_m: 9}
)";
constexpr const char* kToTheWall =
    "walk: {commands: [{straight: {forward_m: -1.3}}, {tangent_arc: {radius_m: 0.3, angle_deg: 90}}, "
    "{straight: {forward_m: 4}}]}\n";
constexpr const char* kStanding = "walk: {commands: [{stand: {duration_s: 4}}]}\nworld: {room: narrow}\n";

// A cupboard 0.4 m ahead of the start.
constexpr const char* kNarrow =
    "<mujoco><worldbody><geom name='floor' type='plane' size='20 20 1' condim='3'/>"
    "<body name='cupboard' pos='0.9 0 1'><geom type='box' size='0.5 1 1' contype='0' conaffinity='0'/></body>"
    "</worldbody></mujoco>";

class CollisionTest : public testing::Test {
 protected:
  CollisionTest() {
    fs::create_directories(folder_ / "models");
    for (const char* model : {"hrp2.xml", "floor.xml"})
      fs::copy_file(kModels / model, folder_ / "models" / model);
    std::ofstream(folder_ / "models/narrow.xml") << kNarrow;
  }
  ~CollisionTest() override { fs::remove_all(folder_); }

  static ReadScenario scenario(const char* text, const std::vector<std::string>& overrides = {}) {
    return sim::scenario::read_scenario_text(text, "walk.yaml", {overrides, {}});
  }
  Outcome run(const std::string& name, const ReadScenario& read, const fs::path& models = kModels) const {
    return sim::live::run(read, {folder_ / name, sim::files::Existing::reject, models, "1", "test", {}},
                          [](double) {});
  }

  inline static const fs::path kModels = fs::path(GAITSLAM_SOURCE_DIR) / "models";
  const fs::path folder_ =
      fs::temp_directory_path() /
      ("gaitslam collision " + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) +
       " " + std::to_string(getpid()));
};

TEST_F(CollisionTest, APlanThroughTheFurnitureIsRefusedAtItsCommandAndLeavesNothing) {
  const std::string place = "walk.yaml:5:7: walk.commands[1]: straight: at ";
  EXPECT_THAT([&] { run("ahead", scenario(kAhead)); },
              testing::ThrowsMessage<sim::scenario::ConfigError>(
                  AllOf(StartsWith(place), HasSubstr("is within 0.05 m of chair_2, at (2.9"))));
  EXPECT_FALSE(fs::exists(folder_ / "ahead"));
}

TEST_F(CollisionTest, AnArgumentIsNamedWhenItHoldsTheCommands) {
  EXPECT_THAT(
      [&] {
        sim::live::require_clear_walk(
            scenario(kAhead,
                     {"seed=2", "walk.commands=[{stand: {duration_s: 1}}, {straight: {forward_m: 5}}]"}),
            kModels);
      },
      testing::ThrowsMessage<sim::scenario::ConfigError>(
          StartsWith("<argument>:2:42: walk.commands[1]: straight: at ")));
}

TEST_F(CollisionTest, NineMetersAheadEndAtTheFurnitureWhereTheScenarioAllowsIt) {
  const Outcome outcome = run("ahead", scenario(kAhead, {"limits.ending=[collided]"}));
  EXPECT_EQ(outcome.ending, Ending::collided);
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.cause,
              testing::MatchesRegex(
                  "[A-Z]+_[A-Z]+[0-9]* touched chair_2 at \\([23].*, .*, .*\\) m in the room after 1.* s"));
  const nlohmann::json about = tests::json_of(folder_ / "ahead/about.json");
  EXPECT_EQ(about["walk_ending"], "collided");
  EXPECT_EQ(about["walk_cause"], outcome.cause);
  EXPECT_EQ(tests::json_of(folder_ / "ahead/score.json")["ending"], "collided");
}

TEST_F(CollisionTest, TheRobotDoesNotLeaveTheBuilding) {
  const Outcome outcome = run("wall", scenario(kToTheWall, {"limits.ending=[collided]"}));
  EXPECT_EQ(outcome.ending, Ending::collided);
  EXPECT_THAT(outcome.cause, HasSubstr(" touched wall_left at ("));
}

// The plan is clear: what pushes do is not planned.
TEST_F(CollisionTest, ARobotThatIsPushedIntoFurnitureCollides) {
  const ReadScenario standing = scenario(kStanding);
  EXPECT_EQ(run("still", standing, folder_ / "models").ending, Ending::completed);
  const ReadScenario pushed = scenario(kStanding, {"world.pushes=[{push: {time_s: 2, impulse_ns: 40}}]"});
  const Outcome outcome = run("pushed", pushed, folder_ / "models");
  EXPECT_EQ(outcome.ending, Ending::collided);
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.cause, HasSubstr(" touched cupboard at (0.4"));
}

// Without the cupboard the same push ends as a fall.
TEST_F(CollisionTest, AFallStaysAFall) {
  const Outcome outcome = run(
      "fall", scenario(kStanding, {"world.room=floor", "world.pushes=[{push: {time_s: 2, impulse_ns: 40}}]"}),
      folder_ / "models");
  EXPECT_EQ(outcome.ending, Ending::fell);
}

TEST_F(CollisionTest, AWalkThatTouchesNothingHasTheSameBitsInEveryRoom) {
  const char* const walk = "walk: {commands: [{straight: {forward_m: 0.3}}]}\n";
  for (const char* room : {"floor", "office", "hall"})
    ASSERT_EQ(run(room, scenario(walk, {std::string("world.room=") + room})).ending, Ending::completed);
  const auto bits = [&](const std::string& room) {
    auto files = tests::files(folder_ / room / "recording");
    for (const char* name : {"manifest.csv"}) files.erase(name);
    return files;
  };
  EXPECT_THAT(tests::differences(bits("floor"), bits("office")), IsEmpty());
  EXPECT_THAT(tests::differences(bits("floor"), bits("hall")), IsEmpty());
}

}  // namespace
