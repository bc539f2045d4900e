#include "sim/scenario/scenario.h"

#include <bit>

#include "tests/sim/scenario/test_scenarios.h"
#include "tests/walking/walks.h"

namespace sim::scenario {
namespace {

using testing::EndsWith, testing::HasSubstr, testing::MatchesRegex, testing::StartsWith;

const fs::path kSource = GAITSLAM_SOURCE_DIR;

class ShippedScenario : public testing::TestWithParam<fs::path> {};
INSTANTIATE_TEST_SUITE_P(, ShippedScenario, testing::ValuesIn(scenario_files()), test_name);

TEST_P(ShippedScenario, IsReadAndWrittenCompletelyAndItsWalkIsSmooth) {
  const Scenario scenario = read_scenario(GetParam()).scenario;
  const std::string whole = to_yaml(scenario);
  EXPECT_EQ(to_yaml(read_text(whole).scenario), whole);
  walking::expect_smooth(walking::planned(scenario.walk), scenario.walk.single_support_s);
}

TEST(EstimatorTime, IsTheLatencyOfSteeringAndAddsToAGivenLatency) {
  const std::string steered = kAll + "walk.steering.by: estimate\n",
                    late = steered + "estimator: {time: {model: measured}}\n";
  EXPECT_EQ(read_text(steered).scenario.walk.steering.latency_s, 0.1);
  EXPECT_EQ(read_text(late + "walk.steering.latency_s: 0.1\n").scenario.walk.steering.latency_s, 0.1);
  const ReadScenario derived = read_text(late);
  EXPECT_EQ(derived.scenario.walk.steering.latency_s, 0);
  EXPECT_EQ(derived.scenario.estimator.name, "filter");
  EXPECT_EQ(read_text(to_yaml(derived.scenario)).scenario.walk.steering.latency_s, 0);
}

TEST(Scenario, PushesAfterTheEndOfReplacedCommandsAreIgnoredWithAWarning) {
  const std::string pushed =
      kWalk + "world: {pushes: [{push: {time_s: 0.5, impulse_ns: 1}}, {push: {time_s: 5, impulse_ns: 1}}]}\n";
  EXPECT_THAT(complaint(pushed), HasSubstr("never happens: it starts at 5 s"));
  const ReadScenario read = read_text(pushed, {{"walk.commands=[{stand: {duration_s: 1}}]"}, {}});
  EXPECT_THAT(
      read.warnings,
      testing::ElementsAre(HasSubstr("test.yaml:2:9: world.pushes: push: never happens: it starts at 5 s")));
  EXPECT_EQ(read.scenario.world.pushes.size(), 1U);
}

// Cases start with the line "# expect: " and the message, cut off by "..." before names of keys.
TEST(Scenario, EachBadScenarioIsRejectedWithItsPlaceAndWhatWasExpected) {
  const std::string marker = "# expect: ",
                    all = files::read_text(kSource / "tests/sim/scenario/bad_scenarios.txt");
  int count = 0;
  for (std::size_t at = 0; at < all.size(); ++count) {
    const std::size_t end = std::min(all.find(marker, at + 1), all.size());
    const std::string text = all.substr(at, end - at);
    const std::string expected = text.substr(marker.size(), text.find('\n') - marker.size());
    if (expected.ends_with("..."))
      EXPECT_THAT(complaint(text), StartsWith("test.yaml:" + expected.substr(0, expected.size() - 3)));
    else
      EXPECT_EQ(complaint(text), "test.yaml:" + expected) << text;
    at = end;
  }
  EXPECT_GE(count, 110);
  const std::string two_hours = "walk.commands: [stand: {duration_s: 3600}, stand: {duration_s: 3600}]";
  EXPECT_EQ(complaint(two_hours), "");
  EXPECT_THAT(complaint(std::string("world: {room: \0x}", 18)), StartsWith("test.yaml:1:1: has a zero byte"));
}

TEST(Scenario, IsWrittenAndReadBackBitForBit) {
  Scenario s = read_text(kAll).scenario;
  s.seed = std::numeric_limits<std::uint64_t>::max();
  s.slam->gyro.sigma_rad_s = 1.0 / 3 * 1e-7;
  s.walk.commands = {walking::TangentArc{0.1 + 0.2, to_radians(std::nextafter(90.0, 91))},
                     walking::Straight{-0.0, 1e-300},
                     walking::Steps{{{0.1, -0.19, 1.0 / 7}, {1.0 / 9, 0.19, 0}}}};
  s.limits.metrics = {{"rmse_m", "median", Bound::at_most, 2.0 / 3},
                      {"loop_closed", {}, Bound::at_least, -1e300}};
  s.limits.ending = {"diverged", "fell"};
  const Scenario again = read_text(to_yaml(s)).scenario;
  EXPECT_EQ(to_yaml(again), to_yaml(s));  // these values show that each bit counts in the text
  EXPECT_EQ(again.seed, s.seed);
  EXPECT_EQ(again.slam->gyro.sigma_rad_s, s.slam->gyro.sigma_rad_s);
  EXPECT_EQ(std::get<walking::TangentArc>(again.walk.commands.at(0)).angle_rad,
            to_radians(std::nextafter(90.0, 91)));
  EXPECT_TRUE(std::signbit(std::get<walking::Straight>(again.walk.commands.at(1)).forward_m));
  EXPECT_EQ(std::get<walking::Steps>(again.walk.commands.at(2)).list.at(1).forward_m, 1.0 / 9);
  EXPECT_EQ(again.limits.metrics, s.limits.metrics);
}

TEST(Scenario, OmittedSectionsStayOmittedWhenWrittenAndReadAgain) {
  const Scenario s = read_text(kAll, {{}, {"camera", "slam"}}).scenario;
  EXPECT_FALSE(s.camera || s.slam);
  const Scenario again = read_text(to_yaml(s)).scenario;
  EXPECT_FALSE(again.camera || again.slam);
  EXPECT_EQ(complaint(kAll, {{}, {"slamm"}}),
            "--without slamm: expected camera or slam; did you mean 'slam'?");
  EXPECT_EQ(complaint(kAll, {{}, {"slam"}}), "");
  EXPECT_NE(complaint(kAll, {{}, {"camera"}}), "");
}

TEST(Scenario, AnEstimatorImpliesTheSectionSlamInAFileButNeedsItAsAnArgument) {
  const std::string text = kWalk + "camera: {}\n";
  EXPECT_TRUE(read_text(text + "estimator: odometry\n").scenario.slam);
  EXPECT_EQ(complaint(text, {{"estimator=odometry"}, {}}),
            "<argument>:1:1: estimator: this scenario has no section 'slam'");
  const Scenario without = read_text(text + "estimator: odometry\n", {{}, {"slam"}}).scenario;
  EXPECT_FALSE(read_text(to_yaml(without)).scenario.slam);
}

TEST(Scenario, DegreesInAFileAreWrittenBackExactly) {
  for (int i = 1; i <= 20000; ++i) {
    const double radians = to_radians(i * 0.037);
    ASSERT_EQ(std::bit_cast<std::uint64_t>(to_radians(to_degrees(radians))),
              std::bit_cast<std::uint64_t>(radians));
  }
  EXPECT_EQ(to_degrees(std::numbers::pi / 2), 90);
  EXPECT_EQ(to_degrees(to_radians(52)), 52) << "as typed";
}

const std::string kLongWalk = "walk: {commands: [{stand: {duration_s: 100}}]}\ncamera: {}\n";

TEST(Scenario, FaultsThatTheEstimatorNoticesAndFaultsOfOmittedSectionsAreAccepted) {
  const auto with = [](const std::string& fault, const std::string& rest) {
    return complaint(kLongWalk + "errors.faults: [" + fault + ": {}]\n" + rest);
  };
  EXPECT_EQ(with("gyro_silent", "slam: {vision: {enabled: false}}"), "");
  EXPECT_EQ(with("plan_missing", "slam: {height: {enabled: false}}"), "");
  EXPECT_EQ(with("frames_doubled", "slam: {vision: {enabled: false}}"), "");
  EXPECT_EQ(with("frames_lost", "slam: {vision: {enabled: false}}\nestimator: {program: [./mine]}"), "");
  for (const std::string text : {"errors.faults: [{frames_lost: {}}]", "world.lights_off.duration_s: 1"})
    EXPECT_EQ(complaint(kAll + text, {{}, {"camera", "slam"}}), "");
}

TEST(Lists, AreReadAndPrintedInOrder) {
  const Scenario scenario = read_text(kLongWalk + R"(slam: {}
errors.faults: [frames_lost: {from_s: 20, duration_s: 2}, gyro_spike: {from_s: 3.5, size_rad_s: 5}]
world.pushes: [{push: {time_s: 4, impulse_ns: 12, direction_deg: 90}}]
)")
                                .scenario;
  const auto& faults = scenario.errors.faults;
  EXPECT_EQ(std::get<sensor_errors::FramesLost>(faults.at(0)).from_s, 20);
  EXPECT_EQ(std::get<sensor_errors::GyroSpike>(faults.at(1)).size_rad_s, 5);
  EXPECT_EQ(std::get<sensor_errors::GyroSpike>(faults[1]).duration_s, 0.005);
  const physics::Push& push = scenario.world.pushes.at(0);
  EXPECT_EQ(push.direction_rad, std::numbers::pi / 2);
  EXPECT_EQ(push.duration_s, 0.1);
  EXPECT_EQ(to_yaml(read_text(to_yaml(scenario)).scenario), to_yaml(scenario));
  EXPECT_EQ(complaint(kLongWalk + "slam: {}", {{"errors.faults=[frames_lost: {from_s: 1}]"}, {}}), "");
}

TEST(Overrides, UseTheSameTableAsTheFile) {
  const ReadScenario r =
      read_text(kAll + "seed: 3\nlimits: {rmse_m: {at_most: 1}}\n",
                {{"seed=7", "slam={gyro: {sigma_rad_s: 0.02}, height.sigma_m: 0.4}",
                  "walk.commands=[{straight: {forward_m: 2}}]",
                  "limits.rmse_m={at_most: 0.5, median.at_most: 0.25}", "limits.ending=[fell]", "seed=8"},
                 {}});
  EXPECT_EQ(r.scenario.seed, 8u);
  EXPECT_EQ(r.scenario.slam->gyro.sigma_rad_s, 0.02);
  EXPECT_EQ(r.scenario.slam->height.sigma_m, 0.4);
  EXPECT_EQ(std::get<walking::Straight>(r.scenario.walk.commands.at(0)).forward_m, 2);
  ASSERT_EQ(r.scenario.limits.metrics.size(), 2u);
  EXPECT_EQ(r.scenario.limits.metrics[0].value, 0.5);
  EXPECT_EQ(r.scenario.limits.metrics[1].aggregate, "median");
  EXPECT_EQ(r.scenario.limits.ending, std::vector<std::string>{"fell"});
  EXPECT_EQ(r.origin.at("seed"), "argument 6");
  EXPECT_EQ(r.origin.at("slam.gyro.sigma_rad_s"), "argument 2");
}

TEST(Overrides, AreReportedWithTheirPlaceOnTheCommandLineIfWrong) {
  for (const auto& [argument, problem] : std::vector<std::pair<std::string, std::string>>{
           {"errors.gyro={sgima_rad_s: 1}",
            "14: errors.gyro.sgima_rad_s: unknown key; did you mean 'errors.gyro.sigma_rad_s'?"},
           {"seed=", "1: seed: is empty, expected a whole number from 0 to 18446744073709551615"},
           {"seed", "1: 'seed': expected key=value"},
           {"=3", "1: '=3': expected key=value"},
           {"walk.commands=[{hop: {}}]",
            "17: walk.commands: unknown command 'hop', expected one of stand, straight, tangent_arc, "
            "perpendicular_arc, steps, turn, go_to, repeat"}})
    EXPECT_EQ(complaint(kAll, {{"seed=1", argument}, {}}), "<argument>:2:" + problem);
  for (const std::string argument : {"slam.gyro.sigma_rad_s=1", "slam={gyro: {sigma_rad_s: 1}}"})
    EXPECT_THAT(complaint(kWalk, {{argument}, {}}), HasSubstr("this scenario has no section 'slam'"));
}

TEST(Scenario, FilesThatCannotBeReadAreReported) {
  EXPECT_EQ(files::error_of([] { read_scenario("no/such.yaml"); }),
            "no/such.yaml: cannot be read: No such file or directory");
  EXPECT_EQ(files::error_of([] { read_scenario("/"); }), "/: is a folder, expected a YAML file");
  EXPECT_EQ(files::error_of([] { read_scenario("/dev/null"); }),
            "/dev/null: is not a regular file, expected one: pipes, devices and sockets are not read");
}

TEST(Scenario, RepeatedCharactersAndDeepNestingAreRejected) {
  std::vector<std::string> texts{"seed: " + std::string(1 << 19, '9')};
  for (const char* piece : {"[", "{", "- ", "a: ", "? ", "\n", "'", "&a ", "\xff", "---\n", "\"\\x"})
    for (std::string& text = texts.emplace_back(); text.size() < 1 << 19;) text += piece;
  std::string nested = "walk:\n";
  for (std::size_t i = 1; i < 700; ++i) nested += std::string(i, ' ') + "a:\n";
  texts.push_back(nested);
  for (const std::string& text : texts)
    EXPECT_THAT(complaint(text), MatchesRegex("test.yaml:[0-9]+:[0-9]+: [^\n]+")) << text.substr(0, 60);
}

class Base : public testing::Test {
 protected:
  /// Writes a file and returns its path.
  std::string file(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
    return path(name);
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  static std::string complaint_about(const std::string& scenario, const Changes& changes = {}) {
    return files::error_of([&] { read_scenario(scenario, changes); });
  }
  files::TemporaryFolder folder_;
};
using Overlay = Base;

TEST_F(Base, SetsOnlyWhatTheScenarioDoesNotSetItself) {
  const std::string circle = file("circle.yaml", kAll + "seed: 4\nwalk.step_length_m: 0.1\nname: circle\n"),
                    hall = file("hall.yaml", "base: circle.yaml\nworld.room: hall\nseed: 5\n");
  const ReadScenario read = read_scenario(hall);
  EXPECT_EQ(read.scenario.name, "hall");
  EXPECT_EQ(read.scenario.seed, 5u);
  EXPECT_TRUE(read.scenario.camera && read.scenario.slam);
  EXPECT_EQ(read.origin.at("walk.step_length_m"), circle + ":5");
  EXPECT_EQ(read.origin.at("seed"), hall + ":3");
  EXPECT_FALSE(read.origin.contains("name"));
  const std::string whole = to_yaml(read.scenario);
  EXPECT_EQ(whole.find("base"), whole.npos);
}

TEST(Sessions, AreTheScenarioWithOtherKeysOtherNoiseAndTheSameRobot) {
  const ReadScenario read = read_text(
      kAll +
      "seed: 5\nsessions: [{session: {set: [world.light.level=0.3, 'world.start={x_m: 1, y_m: 2}']}},\n"
      "  {session: {set: []}}]\n");
  const Scenario first = session(read, 0).scenario, second = session(read, 1).scenario;
  const auto origin = session(read, 0).origin;
  EXPECT_EQ(origin.at("world.light.level"), read.origin.at("sessions")) << "wherever its text was";
  EXPECT_EQ(origin.at("seed"), read.origin.at("seed"));
  EXPECT_FALSE(origin.contains("world.robot"));
  EXPECT_EQ(first.world.light.level, 0.3);
  EXPECT_EQ(first.world.start.y_m, 2);
  EXPECT_EQ(second.world.light.level, 1);
  EXPECT_TRUE(first.sessions.empty() && first.slam->map.save && !read.scenario.slam->map.save);
  EXPECT_EQ(first.world.variation.seed, 5U);
  EXPECT_EQ(second.world.variation.seed, 5U);
  EXPECT_EQ(std::set({read.scenario.seed, first.seed, second.seed}).size(), 3U);
  EXPECT_EQ(to_yaml(read_text(to_yaml(read.scenario)).scenario), to_yaml(read.scenario));
  for (const auto& [set, error] :
       {std::pair{"camera.width_px=640",
                  "session 1 sets 'camera.width_px=640', expected keys that start with walk."},
        {"world.light.levl=1", "session 1: <argument>:1:1: world.light.levl: unknown key; did you mean"}})
    EXPECT_THAT(files::error_of([&, set = std::string(set)] {
                  read_text(kAll + "sessions: [{session: {set: [" + set + "]}}]\n");
                }),
                testing::AllOf(testing::HasSubstr(": sessions: "), testing::HasSubstr(error)));
}

TEST_F(Base, TheMapOfAnEarlierSessionIsRelativeToTheFileThatNamesIt) {
  file("bases/b.yaml", kAll + "slam.map.load: ../first/map.bin\n");
  const ReadScenario read = read_scenario(file("c.yaml", "base: bases/b.yaml\n"));
  EXPECT_EQ(read.scenario.slam->map.load, path("first/map.bin"));
  EXPECT_EQ(read_scenario_text(to_yaml(read.scenario), "again.yaml").scenario.slam->map.load,
            path("first/map.bin"));
  EXPECT_EQ(read_scenario(path("c.yaml"), {{"slam.map.load=''"}, {}}).scenario.slam->map.load, "");
  EXPECT_THAT(complaint_about(path("c.yaml"), {{"slam.map.load=[a, b]"}, {}}),
              testing::HasSubstr("slam.map.load: is a list, expected the path of a file"));
}

TEST_F(Base, MayHaveItsOwnBaseRelativeToItselfAndTheLastValueOfAKeyCounts) {
  file("a.yaml", kAll + "walk.step_length_m: 0.1\nwalk.preview_s: 2\nlimits.rmse_m.at_most: 1\n");
  file("bases/b.yaml", "base: ../a.yaml\nwalk: {step_length_m: 0.2}\n");
  file("noise.yaml", "walk.preview_s: 1.8\n");
  file("c.yaml", "base: [bases/b.yaml, noise.yaml]\nlimits: {rmse_m: {at_most: 2}}\n");
  const Scenario s = read_scenario(path("c.yaml")).scenario;
  EXPECT_EQ(s.walk.step_length_m, 0.2);
  EXPECT_EQ(s.walk.preview_s, 1.8);
  ASSERT_EQ(s.limits.metrics.size(), 1u);
  EXPECT_EQ(s.limits.metrics[0].value, 2);
  EXPECT_TRUE(read_scenario(file("d.yaml", "base: c.yaml\nlimits: {}\n")).scenario.limits.metrics.empty());
}

TEST_F(Base, IsReportedWhereItIsRequestedIfMissingOrNotAFile) {
  EXPECT_EQ(
      complaint_about(file("s.yaml", "seed: 1\nbase: none.yaml\n")),
      path("s.yaml") + ":2:7: base: " + path("none.yaml") + ": cannot be read: No such file or directory");
  EXPECT_THAT(complaint_about(file("s.yaml", "base: ..\n")), HasSubstr("s.yaml:1:7: base: "));
  for (const std::string nothing : {"", "[]", "{a: 1}", "[[a.yaml]]", "''"})
    EXPECT_THAT(complaint_about(file("s.yaml", "base: " + nothing + "\n")),
                HasSubstr("base: expected a scenario file or a list of them, as in base: "));
}

TEST_F(Base, IsRejectedIfItLeadsBackToItself) {
  file("a.yaml", "seed: 1\nbase: b.yaml\n");
  file("c/c.yaml", "");
  file("b.yaml", "base: [./c/../a.yaml]\n");
  EXPECT_EQ(complaint_about(path("a.yaml")), path("b.yaml") + ":1:8: base: " + path("a.yaml") +
                                                 " is a base of itself, through " + path("b.yaml"));
  EXPECT_THAT(complaint_about(file("s.yaml", "base: s.yaml\n")), HasSubstr("s.yaml is a base of itself"));
}

TEST_F(Base, IsNotAKeyOnTheCommandLineOrBelowASection) {
  EXPECT_THAT(complaint(kAll, {{"base=a.yaml"}, {}}), HasSubstr("1:1: base: belongs in a scenario"));
  EXPECT_THAT(complaint(kWalk + "world: {base: a.yaml}"), HasSubstr("world.base: unknown key"));
  EXPECT_THAT(complaint("bsae: a.yaml\n"), EndsWith("did you mean 'base'?"));
}

TEST_F(Overlay, IsOverriddenByTheNextOverlayAndByArguments) {
  file("base.yaml", kAll + "slam.gyro.sigma_rad_s: 0.02\n");
  const std::string s = file("s.yaml", "base: base.yaml\nseed: 1\n"),
                    a = file("a.yaml", "slam: {gyro: {sigma_rad_s: 0.1}, height: {sigma_m: 0.1}}\n"),
                    b = file("b.yaml", "slam.gyro.sigma_rad_s: 0.2\n");
  const ReadScenario read = read_scenario(s, {{"seed=9"}, {}, {a, b}});
  EXPECT_EQ(read.scenario.seed, 9u);
  EXPECT_EQ(read.origin.at("seed"), "argument 1");
  EXPECT_EQ(read.scenario.slam->gyro.sigma_rad_s, 0.2);
  EXPECT_EQ(read.origin.at("slam.gyro.sigma_rad_s"), b + ":1");
  EXPECT_EQ(read.scenario.slam->height.sigma_m, 0.1);
  EXPECT_EQ(read_scenario(s, {{"slam.gyro.sigma_rad_s=0.3"}, {}, {a, b}}).scenario.slam->gyro.sigma_rad_s,
            0.3);
}

TEST_F(Base, ARobotsBaseSetsDefaultsOfItsWalkAndMotionNoises) {
  const std::string robot = "world.robot: " + path("robot") + "\n";
  file(
      "robot/robot.yaml",
      "walk: {step_height_m: 0.05, single_support_s: 0.5, double_support_s: 0.1}\nslam: {height: {lasting_s: "
      "7}}\n");
  const ReadScenario read = read_text(kAll + robot);
  EXPECT_EQ(read.scenario.walk.step_height_m, 0.05);
  EXPECT_EQ(read.scenario.slam->height.lasting_s, 7);
  EXPECT_EQ(read.scenario.slam->plan_velocity.sway_period_s, 1.2) << "two steps";
  EXPECT_EQ(read.origin.at("slam.height.lasting_s"), path("robot/robot.yaml") + ":2");
  EXPECT_EQ(read_text(kAll + robot, {{"slam.height.lasting_s=2"}, {}}).scenario.slam->height.lasting_s, 2);
  EXPECT_EQ(read_text(kAll + robot, {{"slam.plan_velocity.sway_period_s=2"}, {}})
                .scenario.slam->plan_velocity.sway_period_s,
            2);
  EXPECT_FALSE(read_text(kWalk + robot).scenario.slam);
  for (const std::string key : {"vision: {sigma_px: 1}", "gyro: {sigma_rad_s: 1}", "height: {lasting: 1}"}) {
    file("robot/robot.yaml", "slam: {" + key + "}\n");
    EXPECT_THAT(complaint(kAll + robot), HasSubstr("robot.yaml:1:")) << key;
  }
}

TEST_F(Base, TheSidewaysGaitOfARobotReplacesItsUsualOne) {
  file("robot/robot.yaml",
       "walk: {step_height_m: 0.05, step_length_m: 0.1}\nwalk_sideways: {step_length_m: 0.06}\n");
  const auto walk = [&](const std::string& keys) {
    return read_text(kAll + "world.robot: " + path("robot") + "\n" + keys).scenario.walk;
  };
  EXPECT_EQ(walk("").step_length_m, 0.1);
  const walking::WalkOptions sideways = walk("walk.gait: sideways\n");
  EXPECT_EQ(sideways.step_length_m, 0.06);
  EXPECT_EQ(sideways.step_height_m, 0.05);
  EXPECT_EQ(walk("walk.gait: sideways\nwalk.step_length_m: 0.2\n").step_length_m, 0.2);
}

TEST_F(Overlay, IsReadAsStrictlyAsAScenario) {
  const std::string s = file("s.yaml", kAll);
  for (const auto& [overlay, problem] :
       {std::pair("\nslam.gyro.sigma_rads: 1\n", "o.yaml:2:1: slam.gyro.sigma_rads: unknown key"),
        {"slam.height.sigma_m: 1\nslam: {height: {sigma_m: 2}}\n", "given twice, first at"},
        {"- 1\n", "expected keys and values"}})
    EXPECT_THAT(complaint_about(s, {{}, {}, {file("o.yaml", overlay)}}), HasSubstr(problem));
  EXPECT_THAT(complaint_about(s, {{}, {}, {path("none.yaml")}}), HasSubstr("cannot be read"));
  EXPECT_THAT(complaint_about(file("b.yaml", "base: o.yaml\n")), HasSubstr("o.yaml:1:1: expected keys"));
}

}  // namespace
}  // namespace sim::scenario
