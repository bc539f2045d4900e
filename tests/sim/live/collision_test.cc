// Runs with collisions with walls and furniture, without camera and filter.
#include <fstream>

#include "sim/live/recorded.h"
#include "tests/sim/live/run_folder.h"

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
constexpr const char* kStanding = "walk: {commands: [{stand: {duration_s: 4}}]}\nworld: {room: narrow}\n";

// A cupboard 0.4 m ahead of the start.
constexpr const char* kNarrow =
    "<mujoco><worldbody><geom name='floor' type='plane' size='20 20 1' condim='3'/>"
    "<body name='cupboard' pos='0.9 0 1'><geom type='box' size='0.5 1 1' contype='0' conaffinity='0'/></body>"
    "</worldbody></mujoco>";

class CollisionTest : public tests::RunFolder {
 protected:
  Outcome run_in_narrow_room(const std::string& name, const ReadScenario& scenario) const {
    const fs::path models = folder_ / "models";
    fs::create_directories(models);
    for (const char* model : {"hrp2.xml", "floor.xml"})
      fs::copy_file(kModels / model, models / model, fs::copy_options::overwrite_existing);
    std::ofstream(models / "narrow.xml") << kNarrow;
    return sim::live::run(scenario, place(name, models), [](double) {});
  }
};

TEST_F(CollisionTest, APlanThroughTheFurnitureIsRejectedAtItsCommandAndLeavesNothing) {
  const std::string place = "walk.yaml:5:7: walk.commands[1]: straight: at ";
  EXPECT_THAT([&] { run("ahead", read(kAhead)); },
              testing::ThrowsMessage<sim::scenario::ConfigError>(
                  AllOf(StartsWith(place), HasSubstr("is within 0.05 m of chair_2, at (2.9"))));
  EXPECT_FALSE(fs::exists(folder_ / "ahead"));
}

TEST_F(CollisionTest, AnArgumentIsNamedWhenItContainsTheCommands) {
  EXPECT_THAT(
      [&] {
        sim::live::clear_plan(
            read(kAhead, {"seed=2", "walk.commands=[{stand: {duration_s: 1}}, {straight: {forward_m: 5}}]"}),
            {"hrp2", "office", kModels});
      },
      testing::ThrowsMessage<sim::scenario::ConfigError>(
          StartsWith("<argument>:2:42: walk.commands[1]: straight: at ")));
}

TEST_F(CollisionTest, NineMetersAheadEndAtTheFurnitureWhereTheScenarioAllowsIt) {
  const Outcome outcome = run("ahead", read(kAhead, {"limits.ending=[collided]"}));
  EXPECT_EQ(outcome.ending, Ending::collided);
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.cause,
              testing::MatchesRegex(
                  "[A-Z]+_[A-Z]+[0-9]* touched chair_2 at \\([23].*, .*, .*\\) m in the room after 1.* s"));
  const nlohmann::json about = json("ahead", "about.json");
  EXPECT_EQ(about["walk_ending"], "collided");
  EXPECT_EQ(about["walk_cause"], outcome.cause);
  EXPECT_EQ(json("ahead", "score.json")["ending"], "collided");
}

// The plan is clear: what pushes do is not planned.
TEST_F(CollisionTest, ARobotThatIsPushedIntoFurnitureCollides) {
  const ReadScenario standing = read(kStanding);
  EXPECT_EQ(run_in_narrow_room("still", standing).ending, Ending::completed);
  const ReadScenario pushed = read(kStanding, {"world.pushes=[{push: {time_s: 2, impulse_ns: 40}}]"});
  const Outcome outcome = run_in_narrow_room("pushed", pushed);
  EXPECT_EQ(outcome.ending, Ending::collided);
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.cause, HasSubstr(" touched cupboard at (0.4"));
  const ReadScenario elsewhere =
      read(kStanding, {"world.room=floor", "world.pushes=[{push: {time_s: 2, impulse_ns: 40}}]"});
  EXPECT_EQ(run("fall", elsewhere).ending, Ending::fell) << "without the cupboard the same push";
}

TEST_F(CollisionTest, AWalkThatTouchesNothingHasTheSameBitsInEveryRoom) {
  const char* const walk = "walk: {commands: [{straight: {forward_m: 0.3}}]}\n";
  for (const char* room : {"floor", "office", "hall"})
    ASSERT_EQ(run(room, read(walk, {std::string("world.room=") + room})).ending, Ending::completed);
  for (const char* room : {"office", "hall"})
    EXPECT_THAT(tests::differences(folder_ / "floor/recording", folder_ / room / "recording", "manifest.csv"),
                IsEmpty());
}

}  // namespace
