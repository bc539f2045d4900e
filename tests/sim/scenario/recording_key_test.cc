#include "sim/scenario/recording_key.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include "sim/files/text.h"
#include "tests/sim/files/temporary_folder.h"
#include "tests/sim/scenario/complaint.h"

namespace sim::scenario {
namespace {

using testing::HasSubstr;
using walking::SteeredBy;

std::string key_of(Scenario scenario, SteeredBy by = SteeredBy::plan) {
  scenario.walk.steering.by = by;
  return recording_key(scenario, "models", "program");
}

TEST(RecordingKey, EachKeyOfWalkAndWorldIsInItAndThoseOfErrorsAndFilterOnlyIfTheySteer) {
  static const std::set<std::string> kSections{"seed", "walk", "stabilizer", "world", "camera"};
  for (const auto& key : scenario_keys()) {
    if (key.name == "walk.steering.by") continue;
    const std::optional<Scenario> other = changed(key);
    ASSERT_TRUE(other) << key.name << ": the test has no other value for it";
    const auto changes = [&](SteeredBy by) { return key_of(*other, by) != key_of(default_scenario(), by); };
    const bool walk = kSections.contains(key.name.substr(0, key.name.find('.')));
    EXPECT_EQ(changes(SteeredBy::plan), walk) << key.name;
    EXPECT_EQ(changes(SteeredBy::estimate), walk || shapes_estimate(key.name)) << key.name;
    EXPECT_EQ(changes(SteeredBy::truth), walk || key.name == "errors.faults") << key.name;
  }
  EXPECT_NE(key_of(default_scenario(), SteeredBy::truth), key_of(default_scenario()));
}

TEST(RecordingKey, KnowsCameraProgramAndModelsAndNotWhetherThereIsAFilter) {
  Scenario scenario = default_scenario();
  const std::string unchanged = key_of(scenario);
  EXPECT_NE(recording_key(scenario, "models", "program 2"), unchanged);
  EXPECT_NE(recording_key(scenario, "others", "program"), unchanged);
  scenario.slam.reset();
  EXPECT_EQ(key_of(scenario), unchanged);
  scenario.camera.reset();
  EXPECT_NE(key_of(scenario), unchanged);
}

TEST(Counterfactual, IsAReplayWhoseEstimateWouldHaveSteeredAnotherWalk) {
  Scenario recorded = default_scenario(), tuned = recorded, seeded = recorded, limited = recorded;
  tuned.slam->gyro.sigma_rad_s *= 2;
  seeded.seed = 7;
  limited.limits.ending = {"fell"};
  EXPECT_EQ(counterfactual(recorded, tuned), "") << "nobody steered";
  recorded.walk.steering.by = SteeredBy::estimate;
  for (const Scenario& same : {recorded, limited}) EXPECT_EQ(counterfactual(recorded, same), "");
  EXPECT_THAT(counterfactual(recorded, tuned), HasSubstr("slam.gyro.sigma_rad_s"));
  EXPECT_THAT(counterfactual(recorded, seeded), HasSubstr("seed"));
}

TEST(ModelsHash, ChangesWithAnyFileAndNotWithTheirDescription) {
  const files::TemporaryFolder folder;
  const auto hash_with = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder / name) << text;
    return models_hash(folder.path());
  };
  hash_with("robot.xml", "<a/>");
  const std::string before = hash_with("room.xml", "<b/>");
  EXPECT_EQ(hash_with("README.md", "of robot and room"), before);
  EXPECT_NE(hash_with("room.xml", "<c/>"), before);
  EXPECT_EQ(hash_with("room.xml", "<b/>"), before);
  EXPECT_NE(hash_with("texture.png", "x"), before);
  EXPECT_THROW(models_hash(folder / "nowhere"), files::FileError);
}

}  // namespace
}  // namespace sim::scenario
