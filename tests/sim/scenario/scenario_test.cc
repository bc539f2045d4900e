#include "sim/scenario/scenario.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>

#include "sim/scenario/value.h"
#include "tests/sim/scenario/complaint.h"
#include "tests/sim/scenario/scenario_files.h"

namespace sim::scenario {
namespace {

using testing::HasSubstr;

const std::filesystem::path kSource = GAITSLAM_SOURCE_DIR;

TEST(Scenario, EveryShippedScenarioIsReadAndWrittenWhole) {
  EXPECT_GE(scenario_files().size(), 20u);
  for (const std::filesystem::path& file : scenario_files()) {
    const std::string whole = to_yaml(read_scenario(file).scenario);
    EXPECT_EQ(to_yaml(read_text(whole).scenario), whole) << file;
  }
}

TEST(Scenario, TangentCircleIsThePapersFirstExperiment) {
  const Scenario s = read_scenario(kSource / "scenarios/tangent_circle.yaml").scenario;
  EXPECT_EQ(s.name, "tangent_circle");
  const auto& diagonal = std::get<walking::Straight>(s.walk.commands.at(1));
  EXPECT_EQ(diagonal.forward_m, 1.0);
  EXPECT_EQ(diagonal.left_m, -0.5);
  int arcs = 0;
  for (const walking::Command& command : s.walk.commands) {
    if (const auto* arc = std::get_if<walking::TangentArc>(&command)) {
      EXPECT_EQ(arc->radius_m, 0.75);
      EXPECT_EQ(arc->angle_rad, std::numbers::pi / 2);
      ++arcs;
    }
  }
  EXPECT_EQ(arcs, 4);
  EXPECT_TRUE(s.camera && s.slam);
}

// Cases start with the line "# expect: " and the message, which "..." cuts off before names of keys.
TEST(Scenario, EachBadOneIsRejectedWithItsPlaceAndWhatWasExpected) {
  const std::string marker = "# expect: ", all = file_text(kSource / "tests/sim/scenario/bad_scenarios.txt");
  int count = 0;
  for (std::size_t at = 0; at < all.size(); ++count) {
    const std::size_t end = std::min(all.find(marker, at + 1), all.size());
    const std::string text = all.substr(at, end - at);
    const std::string expected = text.substr(marker.size(), text.find('\n') - marker.size());
    if (expected.ends_with("..."))
      EXPECT_THAT(complaint(text),
                  testing::StartsWith("test.yaml:" + expected.substr(0, expected.size() - 3)));
    else
      EXPECT_EQ(complaint(text), "test.yaml:" + expected) << text;
    at = end;
  }
  EXPECT_GE(count, 70);
  EXPECT_EQ(complaint(std::string("world: {room: \0x}", 18)),
            "test.yaml:1:1: has a zero byte, expected text");
}

TEST(Scenario, WrittenAndReadAgainIsTheSameBitForBit) {
  Scenario s = read_text(kAll).scenario;
  s.seed = std::numeric_limits<std::uint64_t>::max();
  s.walk.step_length_m = std::nextafter(0.1, 1);
  s.slam->gyro.sigma_rad_s = 1.0 / 3 * 1e-7;
  s.walk.commands = {walking::TangentArc{0.1 + 0.2, to_radians(std::nextafter(90.0, 91))},
                     walking::PerpendicularArc{1.0 / 3, -std::numbers::pi / 2},
                     walking::Straight{-0.0, 1e-300},
                     walking::Steps{{{0.1, -0.19, 1.0 / 7}, {1.0 / 9, 0.19, 0}}}};
  s.limits.metrics = {{"rmse_m", "median", Bound::at_most, 2.0 / 3},
                      {"loop_closed", "", Bound::at_least, -1e300}};
  s.limits.ending = {"diverged", "fell"};
  const Scenario again = read_text(to_yaml(s)).scenario;
  EXPECT_EQ(to_yaml(again), to_yaml(s));
  EXPECT_EQ(again.seed, s.seed);
  EXPECT_EQ(again.walk.step_length_m, s.walk.step_length_m);
  EXPECT_EQ(again.slam->gyro.sigma_rad_s, s.slam->gyro.sigma_rad_s);
  const auto& arc = std::get<walking::TangentArc>(again.walk.commands.at(0));
  EXPECT_EQ(arc.radius_m, 0.1 + 0.2);
  EXPECT_EQ(arc.angle_rad, to_radians(std::nextafter(90.0, 91)));
  EXPECT_EQ(std::get<walking::PerpendicularArc>(again.walk.commands.at(1)).angle_rad, -std::numbers::pi / 2);
  EXPECT_TRUE(std::signbit(std::get<walking::Straight>(again.walk.commands.at(2)).forward_m));
  const auto& steps = std::get<walking::Steps>(again.walk.commands.at(3)).list;
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_EQ(steps[0].turn_rad, 1.0 / 7);
  EXPECT_EQ(steps[1].forward_m, 1.0 / 9);
  EXPECT_EQ(again.limits.metrics, s.limits.metrics);
  EXPECT_EQ(again.limits.ending, s.limits.ending);
}

TEST(Scenario, OmittedSectionsStayOmittedWhenWrittenAndReadAgain) {
  const Scenario s = read_text(kAll, {{}, {"camera", "slam"}}).scenario;
  EXPECT_FALSE(s.camera || s.slam);
  const Scenario again = read_text(to_yaml(s)).scenario;
  EXPECT_FALSE(again.camera || again.slam);
}

TEST(Scenario, DegreesOfAFileComeBackExactly) {
  for (int i = 1; i <= 20000; ++i) {
    const double radians = to_radians(i * 0.037);
    ASSERT_EQ(std::bit_cast<std::uint64_t>(to_radians(to_degrees(radians))),
              std::bit_cast<std::uint64_t>(radians));
  }
  EXPECT_EQ(to_degrees(std::numbers::pi / 2), 90);
}

const std::string kLongWalk = "walk: {commands: [{stand: {duration_s: 100}}]}\ncamera: {}\n";

TEST(Scenario, WhatNeverHappensIsRejected) {
  for (const auto& [argument, problem] : std::vector<std::pair<std::string, std::string>>{
           {"errors.faults=[{frames_lost: {from_s: 300}}]",
            "errors.faults: frames_lost: never happens: it begins at 300 s, the walk ends at 10"},
           {"errors.faults=[{gyro_silent: {duration_s: 0}}]", "never happens: its duration_s is 0"},
           {"errors.faults=[{frames_lost: {fraction: 0}}]", "never happens: its fraction is 0"},
           {"world.pushes=[{push: {time_s: 300, impulse_ns: 5}}]",
            "world.pushes: push: never happens: it begins"},
           {"world.pushes=[{push: {time_s: 3}}]", "never happens: its impulse_ns is 0"},
           {"world.lights_off.from_s=3", "world.lights_off: never happens: its duration_s is 0"},
           {"world.lights_off={from_s: 300, duration_s: 1}", "world.lights_off: never happens: it begins"},
           {"limits.rmse_m={at_most: 0.1, at_least: 0.2}",
            "limits.rmse_m: contradicts itself: at_least 0.2 is above at_most 0.1"},
           {"limits.loop_closed.worst.at_least=1",
            "limits.loop_closed.worst: cannot be met: the walk turns by 0 degrees, expected at least 350"}})
    EXPECT_THAT(complaint(kLongWalk, {{argument}, {}}), HasSubstr(problem)) << argument;
  for (const std::string text : {"errors.faults: [{frames_lost: {}}]", "world.lights_off.duration_s: 1"}) {
    EXPECT_THAT(complaint(kWalk + text), HasSubstr("never happens: this scenario has no section 'camera'"));
    EXPECT_EQ(complaint(kAll + text, {{}, {"camera", "slam"}}), "");
  }
}

TEST(Faults, AreReadInOrderAndPrintedBack) {
  const std::string faults = R"(
errors:
  faults:
    - frames_lost: {from_s: 20, duration_s: 2}
    - gyro_spike: {from_s: 3.5, size_rad_s: 5}
    - plan_scaled: {duration_s: 100, factor: 0.8}
    - frames_frozen: {}
)";
  const Scenario scenario = read_text(kLongWalk + faults).scenario;
  ASSERT_EQ(scenario.errors.faults.size(), 4u);
  EXPECT_EQ(std::get<sensor_errors::FramesLost>(scenario.errors.faults[0]).from_s, 20);
  EXPECT_EQ(std::get<sensor_errors::GyroSpike>(scenario.errors.faults[1]).size_rad_s, 5);
  EXPECT_EQ(std::get<sensor_errors::GyroSpike>(scenario.errors.faults[1]).duration_s, 0.005);
  EXPECT_EQ(std::get<sensor_errors::PlanScaled>(scenario.errors.faults[2]).factor, 0.8);
  const std::string printed = to_yaml(scenario);
  EXPECT_EQ(to_yaml(read_text(printed).scenario), printed);
  EXPECT_EQ(read_text(printed).scenario.errors.faults.size(), 4u);
}

TEST(Faults, ThatAreWrongAreNamed) {
  const auto of = [](const std::string& faults) {
    return complaint(kLongWalk, {{"errors.faults=" + faults}, {}});
  };
  EXPECT_EQ(of("[]"), "");
  EXPECT_EQ(of("[frames_lost: {from_s: 1}]"), "");
  EXPECT_EQ(of("3"),
            "<argument>:1:15: errors.faults: expected a list of faults, as in [{frames_lost: {from_s: 20, "
            "duration_s: 2}}]");
  EXPECT_THAT(of("[{frame_lost: {}}]"), testing::EndsWith("did you mean 'frames_lost'?"));
  EXPECT_EQ(of("[{gyro_silent: {size_rad_s: 1}}]"),
            "<argument>:1:31: errors.faults: gyro_silent: unknown field 'size_rad_s', expected from_s, "
            "duration_s");
  EXPECT_EQ(of("[{gyro_silent: {duration_s: -1}}]"),
            "<argument>:1:43: duration_s: is '-1', expected a number from 0 to 1000000");
}

TEST(Overrides, AcceptSections) {
  const ReadScenario read = read_text(
      kAll, {{"limits.rmse_m={at_most: 0.01, worst.at_most: 0.02}",
              "errors={gyro: {sigma_rad_s: 0.3}, accelerometer.sigma_m_s2: 0.4}", "seed=2", "seed=3"},
             {}});
  EXPECT_EQ(read.scenario.limits.metrics.size(), 2u);
  EXPECT_EQ(read.scenario.errors.gyro.sigma_rad_s, 0.3);
  EXPECT_EQ(read.scenario.errors.accelerometer.sigma_m_s2, 0.4);
  EXPECT_EQ(read.scenario.seed, 3u);
  EXPECT_EQ(read.origin.at("errors.gyro.sigma_rad_s"), "argument 2");
  EXPECT_THAT(complaint(kWalk, {{"slam={gyro: {sigma_rad_s: 1}}"}, {}}), HasSubstr("has no section 'slam'"));
  EXPECT_THAT(complaint(kAll, {{"errors.gyro={sgima_rad_s: 1}"}, {}}),
              HasSubstr("errors.gyro.sgima_rad_s: unknown key; did you mean 'errors.gyro.sigma_rad_s'?"));
}

TEST(Overrides, GoThroughTheSameTableAsTheFile) {
  const ReadScenario r = read_text(
      kAll + "seed: 3\nlimits: {rmse_m: {at_most: 1}}\n",
      {{"seed=7", "slam.gyro.sigma_rad_s=0.02", "walk.commands=[{straight: {forward_m: 2}}]",
        "limits.rmse_m.at_most=0.5", "limits.rmse_m.median.at_most=0.25", "limits.ending=[fell]", "seed=8"},
       {}});
  EXPECT_EQ(r.scenario.seed, 8u);
  EXPECT_EQ(r.scenario.slam->gyro.sigma_rad_s, 0.02);
  EXPECT_EQ(std::get<walking::Straight>(r.scenario.walk.commands.at(0)).forward_m, 2);
  ASSERT_EQ(r.scenario.limits.metrics.size(), 2u);
  EXPECT_EQ(r.scenario.limits.metrics[0].value, 0.5);
  EXPECT_EQ(r.scenario.limits.metrics[1].aggregate, "median");
  EXPECT_EQ(r.scenario.limits.ending, std::vector<std::string>{"fell"});
  EXPECT_EQ(r.origin.at("seed"), "argument 7");
  EXPECT_EQ(r.origin.at("walk.commands"), "argument 3");
}

TEST(Overrides, ThatAreWrongAreNamedByTheirPlaceOnTheCommandLine) {
  const auto of = [](const std::string& argument) { return complaint(kAll, {{"seed=1", argument}, {}}); };
  EXPECT_EQ(of("slam.gyro.sgima_rad_s=1"),
            "<argument>:2:1: slam.gyro.sgima_rad_s: unknown key; did you mean 'slam.gyro.sigma_rad_s'?");
  EXPECT_EQ(of("seed=nan"),
            "<argument>:2:6: seed: is 'nan', expected a whole number from 0 to 18446744073709551615");
  EXPECT_EQ(of("seed="),
            "<argument>:2:1: seed: is empty, expected a whole number from 0 to 18446744073709551615");
  EXPECT_EQ(of("seed"), "<argument>:2:1: 'seed': expected key=value");
  EXPECT_EQ(of("=3"), "<argument>:2:1: '=3': expected key=value");
  EXPECT_EQ(of("slam.height=3"),
            "<argument>:2:1: slam.height: is a section, expected keys below it: enabled, sigma_m");
  EXPECT_EQ(
      of("walk.commands=[{hop: {}}]"),
      "<argument>:2:17: walk.commands: unknown command 'hop', expected one of stand, straight, tangent_arc, "
      "perpendicular_arc, steps, turn, go_to, repeat");
}

TEST(Overrides, DoNotStartASectionThatTheFileLeavesOut) {
  EXPECT_EQ(complaint(kWalk, {{"slam.gyro.sigma_rad_s=1"}, {}}),
            "<argument>:1:1: slam.gyro.sigma_rad_s: this scenario has no section 'slam'");
}

TEST(Without, NamesSectionsOnly) {
  EXPECT_EQ(complaint(kAll, {{}, {"slamm"}}),
            "--without slamm: expected camera or slam; did you mean 'slam'?");
  EXPECT_EQ(complaint(kAll, {{}, {"slam"}}), "");
  EXPECT_NE(complaint(kAll, {{}, {"camera"}}), "");
}

TEST(Scenario, FilesThatCannotBeReadAreNamed) {
  EXPECT_EQ(complaint_of([] { read_scenario("no/such.yaml"); }),
            "no/such.yaml: cannot be read: No such file or directory");
  EXPECT_EQ(complaint_of([] { read_scenario("/"); }), "/: is a folder, expected a scenario file");
  EXPECT_EQ(complaint_of([] { read_scenario("/dev/null"); }),
            "/dev/null: is not a regular file, expected one: pipes, devices and sockets are not read");
}

TEST(Scenario, AWalkOfMoreThanTwoHoursIsRejectedAtTheCommandThatMakesItTooLong) {
  const std::string hour = "    - stand: {duration_s: 3600}\n", begin = "walk:\n  commands:\n";
  EXPECT_EQ(complaint(begin + hour + hour), "");
  EXPECT_EQ(complaint(begin + hour + hour + hour),
            "test.yaml:5:7: walk.commands[2]: stand: makes the walk longer than 7200 s");
  EXPECT_EQ(complaint(begin + hour + "    - repeat: {last: 1, times: 1000}\n"),
            "test.yaml:4:7: walk.commands[1]: repeat: makes the walk longer than 7200 s");
  EXPECT_EQ(complaint(kWalk, {{"walk.commands=[{tangent_arc: {radius_m: 1000, angle_deg: 36000}}]"}, {}}),
            "<argument>:1:16: walk.commands[0]: tangent_arc: makes the walk longer than 7200 s");
}

std::string repeated(const std::string& piece, int times) {
  std::string text;
  for (int i = 0; i < times; ++i) text += piece;
  return text;
}

// 1 MiB is the largest file that is read.
TEST(Scenario, RepeatedCharactersAndDeepNestingAreRejected) {
  std::string many_keys, nested = "walk:\n";
  for (int i = 0; many_keys.size() < (1 << 20) - 20; ++i) many_keys += "k" + std::to_string(i) + ": 1\n";
  for (int i = 1; i < 700; ++i) nested += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  const int n = 1 << 20;
  for (const std::string& text :
       {repeated("[", n), repeated("{", n), repeated("- ", n / 2), repeated("a: ", n / 3),
        repeated("[{a: ", n / 5), repeated("? ", n / 2), repeated("\n", n), repeated("#", n),
        repeated("'", n), repeated("&a ", n / 3), repeated("\xff", n), repeated("---\n", n / 4),
        repeated("\"\\x", n / 3), std::string(n, 'a'), "seed: " + std::string(n - 8, '9'),
        "name: " + std::string(n - 8, 'a'), "a: [" + repeated("1,", n / 2 - 4) + "]", many_keys, nested})
    EXPECT_THAT(complaint(text), testing::MatchesRegex("test.yaml:[0-9]+:[0-9]+: [^\n]+"))
        << text.substr(0, 60);
}

TEST(Scenario, PushesAndFloorPatchesAreReadAndPrintedAlike) {
  const ReadScenario read =
      read_text(kLongWalk +
                "world:\n"
                "  pushes: [{push: {time_s: 4, impulse_ns: 12, direction_deg: 90}}]\n"
                "  floor_patches:\n"
                "    - patch: {x_min_m: 1, x_max_m: 2, y_min_m: -1, y_max_m: 1, friction: 0.3}\n");
  const physics::WorldOptions& world = read.scenario.world;
  ASSERT_EQ(world.pushes.size(), 1u);
  EXPECT_EQ(world.pushes[0].impulse_ns, 12);
  EXPECT_EQ(world.pushes[0].direction_rad, std::numbers::pi / 2);
  EXPECT_EQ(world.pushes[0].duration_s, 0.1);
  ASSERT_EQ(world.floor_patches.size(), 1u);
  EXPECT_EQ(world.floor_patches[0].y_min_m, -1);
  EXPECT_EQ(to_yaml(read_text(to_yaml(read.scenario)).scenario), to_yaml(read.scenario));
}

TEST(Ending, IsFoundByItsName) {
  for (std::size_t i = 0; i < kEndings.size(); ++i) {
    const auto ending = static_cast<Ending>(i);
    EXPECT_EQ(ending_named(name_of(ending)), ending);
  }
  EXPECT_EQ(name_of(Ending::not_started), "not started");
  EXPECT_FALSE(ending_named("done"));
}

TEST(Scenario, ErrorsInDisturbancesAreNamed) {
  EXPECT_EQ(complaint(kWalk + "world.pushes: [{push: {times_s: 4}}]"),
            "test.yaml:2:24: world.pushes: push: unknown field 'times_s', expected time_s, impulse_ns, "
            "direction_deg, duration_s; did you mean 'time_s'?");
  EXPECT_EQ(complaint(kWalk + "world.pushes: 4"),
            "test.yaml:2:15: world.pushes: expected a list of disturbances, as in [{push: {time_s: 4, "
            "impulse_ns: 10, "
            "direction_deg: 90}}]");
  EXPECT_EQ(complaint(kWalk + "world.floor_patches: [{patch: {x_min_m: 1, x_max_m: 1, y_max_m: 1}}]"),
            "test.yaml:2:31: world.floor_patches: patch: is empty, expected x_min_m below x_max_m");
}

}  // namespace
}  // namespace sim::scenario
