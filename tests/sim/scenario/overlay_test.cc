#include <gmock/gmock.h>

#include <fstream>
#include <set>

#include "sim/files/text.h"
#include "sim/scenario/keys.h"
#include "tests/sim/files/temporary_folder.h"
#include "tests/sim/scenario/complaint.h"

namespace sim::scenario {
namespace {

using testing::EndsWith;
using testing::HasSubstr;

class Base : public testing::Test {
 protected:
  /// Writes a file and gives its path.
  std::string file(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
    return path(name);
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  static std::string complaint_about(const std::string& scenario, const Changes& changes = {}) {
    return complaint_of([&] { read_scenario(scenario, changes); });
  }
  files::TemporaryFolder folder_;
};
using Overlay = Base;

TEST_F(Base, SetsWhatTheScenarioDoesNotSetItself) {
  const std::string circle = file("circle.yaml", kAll + "seed: 4\nwalk.step_length_m: 0.1\nname: circle\n"),
                    hall = file("hall.yaml", "base: circle.yaml\nworld.room: hall\nseed: 5\n");
  const ReadScenario read = read_scenario(hall);
  EXPECT_EQ(read.scenario.name, "hall");
  EXPECT_EQ(read.scenario.seed, 5u);
  EXPECT_EQ(read.scenario.walk.step_length_m, 0.1);
  EXPECT_EQ(read.scenario.world.room, "hall");
  EXPECT_TRUE(read.scenario.camera && read.scenario.slam);
  EXPECT_EQ(read.origin.at("walk.step_length_m"), circle + ":5");
  EXPECT_EQ(read.origin.at("seed"), hall + ":3");
  EXPECT_FALSE(read.origin.contains("name"));
  const std::string whole = to_yaml(read.scenario);
  EXPECT_EQ(whole.find("base"), whole.npos);
  EXPECT_EQ(to_yaml(read_text(whole).scenario), whole);
}

TEST_F(Base, HasABaseOfItsOwnRelativeToItselfAndTheLastOneSettingAKeyCounts) {
  file("a.yaml", kAll + "seed: 1\nwalk.step_length_m: 0.1\nwalk.preview_s: 2\nlimits.rmse_m.at_most: 1\n");
  file("bases/b.yaml", "base: ../a.yaml\nwalk: {step_length_m: 0.2}\n");
  file("noise.yaml", "slam.gyro.sigma_rad_s: 0.2\nwalk.preview_s: 1.8\n");
  file("c.yaml", "base: [bases/b.yaml, noise.yaml]\nseed: 3\nlimits: {rmse_m: {at_most: 2}}\n");
  const Scenario s = read_scenario(path("c.yaml")).scenario;
  EXPECT_EQ(s.seed, 3u);
  EXPECT_EQ(s.walk.step_length_m, 0.2);
  EXPECT_EQ(s.walk.preview_s, 1.8);
  EXPECT_EQ(s.slam->gyro.sigma_rad_s, 0.2);
  ASSERT_EQ(s.limits.metrics.size(), 1u);
  EXPECT_EQ(s.limits.metrics[0].value, 2);
  const std::string d = file("d.yaml", "base: c.yaml\nlimits: {}\n");
  EXPECT_TRUE(read_scenario(d).scenario.limits.metrics.empty());
}

TEST_F(Base, ThatIsMissingOrNoFileIsNamedWhereItIsAskedFor) {
  EXPECT_EQ(
      complaint_about(file("s.yaml", "seed: 1\nbase: none.yaml\n")),
      path("s.yaml") + ":2:7: base: " + path("none.yaml") + ": cannot be read: No such file or directory");
  EXPECT_THAT(complaint_about(file("s.yaml", "base: ..\n")), HasSubstr("s.yaml:1:7: base: "));
  for (const std::string nothing : {"", "[]", "{a: 1}", "[[a.yaml]]", "''"})
    EXPECT_THAT(complaint_about(file("s.yaml", "base: " + nothing + "\n")),
                HasSubstr("base: expected a scenario file or a list of them, as in base: "));
}

TEST_F(Base, ThatComesBackToItselfIsRefused) {
  file("a.yaml", "seed: 1\nbase: b.yaml\n");
  file("c/c.yaml", "");
  file("b.yaml", "base: [./c/../a.yaml]\n");
  EXPECT_EQ(complaint_about(path("a.yaml")), path("b.yaml") + ":1:8: base: " + path("a.yaml") +
                                                 " is a base of itself, by way of " + path("b.yaml"));
  EXPECT_THAT(complaint_about(file("s.yaml", "base: s.yaml\n")), HasSubstr("s.yaml is a base of itself"));
}

TEST_F(Base, IsNoKeyOfTheCommandLineAndNoneBelowASection) {
  EXPECT_THAT(complaint(kAll, {{"base=a.yaml"}, {}}), HasSubstr("1:1: base: belongs in a scenario"));
  EXPECT_THAT(complaint(kWalk + "world: {base: a.yaml}"), HasSubstr("world.base: unknown key"));
  EXPECT_THAT(complaint("bsae: a.yaml\n"), EndsWith("did you mean 'base'?"));
}

TEST_F(Overlay, GivesWayToTheNextOneAndToArguments) {
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

using walking::SteeredBy;

std::string key_of(Scenario scenario, SteeredBy by = SteeredBy::plan) {
  scenario.walk.steering.by = by;
  return recording_key(scenario, "models", "program");
}

TEST(RecordingKey, EachKeyOfWalkAndWorldIsInItAndThoseOfErrorsAndFilterOnlyIfTheySteer) {
  static const std::set<std::string> kSections{"seed", "walk", "stabilizer", "world", "camera", "imu", "rig"};
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
