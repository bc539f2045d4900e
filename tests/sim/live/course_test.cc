// Runs that do not end where their plan does: steered by the truth or by the estimate, or stopped by walls
// and furniture.
#include "tests/sim/live/run_folder.h"
#include "tests/sim/scenario/test_scenarios.h"

namespace {

namespace fs = std::filesystem;
using sim::result::Outcome;
using sim::scenario::Ending;
using sim::scenario::ReadScenario;
using testing::HasSubstr, testing::IsEmpty;

// Walks on the slippery floor, so that a few steps suffice for a drift.
constexpr const char* kWalk = R"(
walk: {commands: [{stand: {duration_s: 0.5}}, {perpendicular_arc: {radius_m: 0.75, angle_deg: 90}}]}
walk.single_support_s: 0.78
walk.double_support_s: 0.02
walk.step_length_m: 0.15
world.room: floor
)";
constexpr const char* kShortWalkInOffice = R"(
walk: {commands: [{stand: {duration_s: 0.5}}, {tangent_arc: {radius_m: 0.75, angle_deg: 10}}]}
walk.steering.by: estimate
camera: {width_px: 160, height_px: 120}
slam: {}
)";

using SteeredRunTest = tests::RunFolder;
using LongSteeredRunTest = tests::RunFolder;

TEST_F(SteeredRunTest, SteeredByTheTruthTheRobotReachesTheEndOfTheUncorrectedPlan) {
  ASSERT_EQ(run("plan", read(kWalk)).ending, Ending::completed);
  ASSERT_EQ(run("truth", read(kWalk, {"walk.steering.by=truth"})).ending, Ending::completed);
  EXPECT_GT(score("plan", "navigation_end_position_error_m"), 0.03);
  EXPECT_LT(score("truth", "navigation_end_position_error_m"), 0.01);
  EXPECT_LT(score("truth", "navigation_end_yaw_error_deg"), 1);
  EXPECT_LT(score("truth", "navigation_rmse_m"), score("plan", "navigation_rmse_m"));
  EXPECT_GT(score("truth", "steps_corrected"), 5);
  EXPECT_LE(score("truth", "correction_largest_deg"), 3 + 1e-9);
  EXPECT_FALSE(fs::exists(folder_ / "plan/corrected_steps.csv"));
  EXPECT_FALSE(fs::exists(folder_ / "plan/recording/truth/waist_desired.csv"));
  EXPECT_TRUE(fs::exists(folder_ / "truth/recording/truth/corrected_steps.csv"));
  // The recording of the steered walk contains the path planned by the other walk, even while steps are
  // added.
  const auto rows = [](const std::string& csv) { return csv.substr(csv.find('\n')); };
  const std::string planned = rows(file("plan", "recording/truth/waist_plan.csv"));
  EXPECT_EQ(rows(file("truth", "recording/truth/waist_desired.csv")).substr(0, planned.size()), planned);
  EXPECT_NE(rows(file("truth", "recording/truth/waist_plan.csv")).substr(0, planned.size()), planned);
}

// The filter receives the corrected plan: a replay, which has only the recording, gives the estimate that
// steered.
TEST_F(SteeredRunTest, SteeredByTheEstimateTheBitsAreTheSameHoweverImagesAreDrawnAndInAReplay) {
  ASSERT_EQ(run("one", read(kShortWalkInOffice)).ending, Ending::completed);
  ASSERT_EQ(run("two", read(kShortWalkInOffice), 2).ending, Ending::completed);
  EXPECT_THAT(tests::differences(folder_ / "one", folder_ / "two"), IsEmpty());
  EXPECT_GT(score("one", "steps_corrected"), 0);
  replay("one", "replay", read(kShortWalkInOffice));
  EXPECT_THAT(changed_by_replay("one", "replay"), IsEmpty());
}

TEST_F(SteeredRunTest, AnAnswerSteersOnlyAfterItsComputingTime) {
  const auto walk = [&](const std::string& name, const std::string& time) {
    EXPECT_EQ(run(name, read(kShortWalkInOffice, {"estimator.time={model: " + time + "}"})).ending,
              Ending::completed);
    return file(name, "truth.tum");
  };
  const std::string late = walk("late", "fixed, frame_ms: 60");
  EXPECT_NE(walk("later", "fixed, frame_ms: 200"), late);
  EXPECT_NEAR(score("late", "dropped_frames_fraction"), 0.5, 0.01);
  EXPECT_NEAR(score("late", "latency_p99_ms"), 60, 1e-9);
  EXPECT_NEAR(score("late", "budget_fraction_mean"), 1.8, 1e-9);
}

// plan_alone returns the planned poses as its estimate: without a difference nothing is corrected, even if
// the true robot drifts. Steering that used the truth would correct it.
TEST_F(SteeredRunTest, SteeringSeesOnlyTheEstimate) {
  ASSERT_EQ(run("blind", read(kShortWalkInOffice, {"estimator=plan_alone", "world.floor_friction=0.08",
                                                   "walk.steering.dead_band_sigma=0"}))
                .ending,
            Ending::completed);
  EXPECT_GT(score("blind", "navigation_end_position_error_m"), 0.002);
  EXPECT_LT(score("blind", "correction_largest_m"), 1e-9);  // rounding
  EXPECT_LT(score("blind", "correction_largest_deg"), 1e-6);
}

TEST_F(SteeredRunTest, AnEstimatorThatDiesStopsTheRobotOnBothFeet) {
  const ReadScenario lost =
      read(kWalk, {"walk.steering.by=truth", "walk.steering.lost_s=1", "limits.ending=[stopped]",
                   "errors.faults=[{estimate_lost: {from_s: 4, duration_s: 100}}]"});
  const Outcome outcome = run("stopped", lost);
  EXPECT_EQ(outcome.ending, Ending::stopped);
  EXPECT_THAT(outcome.cause, HasSubstr("stopped on both feet"));
  EXPECT_EQ(outcome.exit_code, 0);
}

TEST_F(LongSteeredRunTest, TheRobotSurvivesAJumpOfTheEstimateWithinTheLimits) {
  for (const char* jump : {"x_m: 0.3", "x_m: 0, y_m: -0.3", "x_m: 0, yaw_deg: 10"}) {
    const std::string name = "jump " + std::string(jump);
    const Outcome outcome = run(
        name, read(kWalk,
                   {"walk.steering.by=truth", "errors.faults=[{estimate_jump: {from_s: 4, duration_s: 100, " +
                                                  std::string(jump) + "}}]"}));
    EXPECT_EQ(outcome.ending, Ending::completed) << outcome.cause;
    EXPECT_LE(score(name, "correction_largest_m"), std::hypot(0.03, 0.02) + 1e-9);
  }
}

constexpr const char* kAhead = "walk: {commands: [{stand: {duration_s: 0.5}}, {straight: {forward_m: 9}}]}\n";
constexpr const char* kStanding = "walk: {commands: [{stand: {duration_s: 4}}]}\nworld: {room: narrow}\n";

// A cupboard 0.4 m ahead of the start.
constexpr const char* kNarrow =
    "<mujoco><worldbody><geom name='floor' type='plane' size='20 20 1' condim='3'/>"
    "<body name='cupboard' pos='0.9 0 1'><geom type='box' size='0.5 1 1'/></body>"
    "</worldbody></mujoco>";

class CollisionTest : public tests::RunFolder {
 protected:
  Outcome run_in_narrow_room(const std::string& name, const ReadScenario& scenario) const {
    const fs::path models = folder_ / "models";
    fs::create_directories(models);
    fs::copy_file(kModels / "floor.xml", models / "floor.xml", fs::copy_options::overwrite_existing);
    std::ofstream(models / "narrow.xml") << kNarrow;
    return sim::live::run(scenario, place(name, models), [](double) {});
  }
};

TEST_F(CollisionTest, WalkingNineMetersAheadEndsAtTheFurnitureIfTheScenarioAllowsIt) {
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

// The plan touches nothing, because pushes are not planned.
TEST_F(CollisionTest, ARobotThatIsPushedIntoFurnitureCollides) {
  EXPECT_EQ(run_in_narrow_room("still", read(kStanding)).ending, Ending::completed);
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
  for (const char* room : {"floor", "office"})
    ASSERT_EQ(run(room, read(walk, {std::string("world.room=") + room})).ending, Ending::completed);
  EXPECT_THAT(tests::differences(folder_ / "floor/recording", folder_ / "office/recording", "manifest.csv"),
              IsEmpty());
}

// Whole walks of the shipped scenarios, without camera and filter.

// Without an estimate, the truth steers.
ReadScenario without_filter(const fs::path& file) {
  const auto by = sim::scenario::read_scenario(file).scenario.walk.steering.by;
  std::vector<std::string> overrides;
  if (by == walking::SteeredBy::estimate) overrides.emplace_back("walk.steering.by=truth");
  return sim::scenario::read_scenario(file, {overrides, {"camera", "slam"}});
}

// One scenario per walk: scenarios that differ only in filter, camera, sensor errors or limits have the same
// walk. The regression and the front page walk some of them.
std::vector<fs::path> distinct_walks() {
  const std::set<std::string> elsewhere{"tangent_circle", "perpendicular_circle",
                                        "perpendicular_circle_steered", "hall", "slippery_laps"};
  std::set<std::string> seen;
  std::vector<fs::path> files;
  for (const fs::path& file : sim::scenario::scenario_files()) {
    const auto read = without_filter(file).scenario;
    sim::scenario::Scenario walk;
    walk.seed = read.seed;
    walk.walk = read.walk;
    walk.stabilizer = read.stabilizer;
    walk.world = read.world;
    walk.limits.ending = read.limits.ending;
    if (seen.insert(sim::scenario::to_yaml(walk)).second && !elsewhere.contains(file.stem().string()))
      files.push_back(file);
  }
  return files;
}

class LongWalks : public tests::RunFolder, public testing::WithParamInterface<fs::path> {};
INSTANTIATE_TEST_SUITE_P(, LongWalks, testing::ValuesIn(distinct_walks()), sim::scenario::test_name);

// A warning of MuJoCo (a buffer too small, a bad state) ends a walk as "failed". A scenario that requires
// its filter to give up ("diverged") completes here without a filter.
TEST_P(LongWalks, CompleteAndRaiseNoWarning) {
  const ReadScenario walk = without_filter(GetParam());
  const Outcome outcome = run("walk", walk);
  const std::vector<std::string>& allowed = walk.scenario.limits.ending;
  const bool stops = allowed == std::vector<std::string>{"stopped"};
  EXPECT_EQ(outcome.ending, stops ? Ending::stopped : Ending::completed) << outcome.cause;
  if (std::ranges::count(allowed, "completed") > 0) {
    EXPECT_EQ(outcome.exit_code, 0);
  }
}

}  // namespace
