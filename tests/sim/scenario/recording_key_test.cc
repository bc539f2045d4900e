#include "sim/scenario/recording_key.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <optional>
#include <set>
#include <sstream>

#include "sim/files/text.h"
#include "sim/scenario/keys.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::scenario {
namespace {

std::string key_of(const Scenario& scenario) { return recording_key(scenario, "models", "program"); }

/// The default scenario with another value for this key: the first of many that the key takes and that
/// differs.
std::optional<Scenario> with_other_value(const Key& key) {
  std::istringstream texts(
      "true;false;0.37;0.011;0.0052;0.5;3;17;900;200000;cubic;delayed_zmp;momentum;last;truth;go_on;"
      "particles;plan;pinhole;hall;[fell];plan_alone;[[1, 2, 3]];[{stand: {duration_s: 2}}];"
      "[{gyro_silent: {}}];[{push: {time_s: 1, impulse_ns: 3}}];"
      "[{patch: {x_min_m: 1, x_max_m: 2, y_min_m: 1, y_max_m: 2, friction: 0.3}}];");
  for (std::string text; std::getline(texts, text, ';');) {
    Scenario scenario = default_scenario();
    try {
      key.read(parse_yaml(text, {"test"}), scenario);
    } catch (const ConfigError&) {
      continue;
    }
    if (key.print(scenario) != key.print(default_scenario())) return scenario;
  }
  return std::nullopt;
}

bool is_walk_or_world(const std::string& key) {
  static const std::set<std::string> kSections{"seed", "walk", "stabilizer", "world", "camera"};
  return kSections.contains(key.substr(0, key.find('.')));
}

TEST(RecordingKey, EachKeyOfWalkAndWorldIsInItAndNoKeyOfErrorsFilterAndLimits) {
  const std::string unchanged = key_of(default_scenario());
  for (const auto& key : scenario_keys()) {
    const std::optional<Scenario> other = with_other_value(key);
    ASSERT_TRUE(other) << key.name << ": the test has no other value for it";
    EXPECT_EQ(key_of(*other) != unchanged, is_walk_or_world(key.name)) << key.name;
  }
}

TEST(RecordingKey, OfAWalkSteeredByItsEstimateKnowsErrorsAndFilterToo) {
  const auto steered = [](Scenario scenario, walking::SteeredBy by) {
    scenario.walk.steering.by = by;
    return key_of(scenario);
  };
  for (const auto& key : scenario_keys()) {
    if (key.name == "walk.steering.by") continue;
    const Scenario same = default_scenario(), other = *with_other_value(key);
    const auto changes = [&](walking::SteeredBy by) { return steered(other, by) != steered(same, by); };
    const bool walk = is_walk_or_world(key.name);
    EXPECT_EQ(changes(walking::SteeredBy::estimate), walk || shapes_estimate(key.name)) << key.name;
    EXPECT_EQ(changes(walking::SteeredBy::truth), walk || key.name == "errors.faults") << key.name;
  }
}

TEST(Counterfactual, IsAReplayWhoseEstimateWouldHaveSteeredAnotherWalk) {
  Scenario recorded = default_scenario(), replayed = recorded;
  replayed.slam->gyro.sigma_rad_s *= 2;
  EXPECT_EQ(counterfactual(recorded, replayed), "") << "nobody steered";
  recorded.walk.steering.by = replayed.walk.steering.by = walking::SteeredBy::estimate;
  EXPECT_EQ(counterfactual(recorded, recorded), "");
  EXPECT_NE(counterfactual(recorded, replayed).find("slam.gyro.sigma_rad_s"), std::string::npos);
  replayed = recorded;
  replayed.seed = 7;
  EXPECT_NE(counterfactual(recorded, replayed).find("seed"), std::string::npos);
  replayed = recorded;
  replayed.limits.ending = {"fell"};
  EXPECT_EQ(counterfactual(recorded, replayed), "");
}

TEST(RecordingKey, KnowsWhetherThereIsACameraAndNotWhetherThereIsAFilter) {
  Scenario scenario = default_scenario();
  const std::string unchanged = key_of(scenario);
  scenario.slam.reset();
  EXPECT_EQ(key_of(scenario), unchanged);
  scenario.camera.reset();
  EXPECT_NE(key_of(scenario), unchanged);
}

TEST(RecordingKey, KnowsProgramAndModels) {
  const Scenario scenario = default_scenario();
  EXPECT_NE(recording_key(scenario, "models", "program 2"), key_of(scenario));
  EXPECT_NE(recording_key(scenario, "others", "program"), key_of(scenario));
}

TEST(ModelsHash, ChangesWithAnyFileAndNotWithTheirDescription) {
  const files::TemporaryFolder folder;
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder / name) << text;
  };
  write("robot.xml", "<a/>");
  write("room.xml", "<b/>");
  const std::string before = models_hash(folder.path());
  write("README.md", "of robot and room");
  EXPECT_EQ(models_hash(folder.path()), before);
  write("room.xml", "<c/>");
  EXPECT_NE(models_hash(folder.path()), before);
  write("room.xml", "<b/>");
  write("texture.png", "x");
  EXPECT_NE(models_hash(folder.path()), before);
  EXPECT_THROW(models_hash(folder / "nowhere"), files::FileError);
}

}  // namespace
}  // namespace sim::scenario
