// Scenario files that change others: bases, and files laid over a scenario as the best.yaml of a tuning.
#include <gmock/gmock.h>

#include <fstream>

#include "tests/sim/files/temporary_folder.h"
#include "tests/sim/scenario/complaint.h"

namespace sim::scenario {
namespace {

using testing::EndsWith;
using testing::HasSubstr;

class Files : public testing::Test {
 protected:
  /// Writes a file and gives its path.
  std::string file(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  static std::string complaint_about(const std::string& scenario) {
    return complaint_of([&] { read_scenario(scenario); });
  }
  files::TemporaryFolder folder_;
};

class Base : public Files {};

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
}

// Eight files that name the next one ten times would be 10^8 files to read.
TEST_F(Base, FilesThatNameEachOtherOftenAreRefused) {
  file("0.yaml", kAll);
  for (int i = 1; i <= 8; ++i) {
    std::string bases;
    for (int k = 0; k < 10; ++k) bases += std::to_string(i - 1) + ".yaml, ";
    file(std::to_string(i) + ".yaml", "base: [" + bases + "0.yaml]\n");
  }
  EXPECT_THAT(complaint_about((folder_ / "8.yaml").string()),
              HasSubstr("base: more than 100 files in all, those of bases included"));
}

TEST_F(Base, HasABaseOfItsOwnRelativeToItself) {
  file("a.yaml", kAll + "seed: 1\nwalk.step_length_m: 0.1\nwalk.preview_s: 2\n");
  file("bases/b.yaml", "base: ../a.yaml\nwalk: {step_length_m: 0.2}\n");
  const Scenario s = read_scenario(file("c.yaml", "base: bases/b.yaml\nseed: 3\n")).scenario;
  EXPECT_EQ(s.seed, 3u);
  EXPECT_EQ(s.walk.step_length_m, 0.2);
  EXPECT_EQ(s.walk.preview_s, 2);
}

TEST_F(Base, OfSeveralTheLastOneSettingAKeyCounts) {
  file("walk.yaml", kAll + "slam.gyro.sigma_rad_s: 0.1\nlimits.rmse_m.at_most: 1\n");
  file("noise.yaml", "slam.gyro.sigma_rad_s: 0.2\n");
  const Scenario s =
      read_scenario(file("s.yaml", "base: [walk.yaml, noise.yaml]\nlimits: {rmse_m: {at_most: 2}}\n"))
          .scenario;
  EXPECT_EQ(s.slam->gyro.sigma_rad_s, 0.2);
  ASSERT_EQ(s.limits.metrics.size(), 1u);
  EXPECT_EQ(s.limits.metrics[0].value, 2);
}

TEST_F(Base, GivesWayToOverlaysAndArguments) {
  file("a.yaml", kAll + "seed: 1\nwalk.preview_s: 2\n");
  const std::string s = file("s.yaml", "base: a.yaml\n"), over = file("o.yaml", "walk.preview_s: 3\n");
  const ReadScenario read = read_scenario(s, {{"seed=9"}, {}, {over}});
  EXPECT_EQ(read.scenario.seed, 9u);
  EXPECT_EQ(read.origin.at("seed"), "argument 1");
  EXPECT_EQ(read.scenario.walk.preview_s, 3);
  EXPECT_EQ(read.origin.at("walk.preview_s"), over + ":1");
}

TEST_F(Base, IsNotInTheScenarioThatIsWritten) {
  file("a.yaml", kAll + "seed: 7\n");
  const Scenario s = read_scenario(file("s.yaml", "base: a.yaml\n")).scenario;
  EXPECT_EQ(to_yaml(s).find("base"), std::string::npos);
  EXPECT_EQ(to_yaml(read_text(to_yaml(s)).scenario), to_yaml(s));
}

TEST_F(Base, ThatIsMissingOrNoFileIsNamedWhereItIsAskedFor) {
  EXPECT_EQ(complaint_about(file("s.yaml", "seed: 1\nbase: none.yaml\n")),
            (folder_ / "s.yaml").string() + ":2:7: base: " + (folder_ / "none.yaml").string() +
                ": cannot be read: No such file or directory");
  EXPECT_THAT(complaint_about(file("s.yaml", "base: ..\n")), HasSubstr("s.yaml:1:7: base: "));
  for (const std::string nothing : {"", "[]", "{a: 1}", "[[a.yaml]]", "''"})
    EXPECT_THAT(
        complaint_about(file("s.yaml", "base: " + nothing + "\n")),
        EndsWith("base: expected a scenario file or a list of them, as in base: tangent_circle.yaml"));
}

TEST_F(Base, ThatComesBackToItselfIsRefused) {
  file("a.yaml", "seed: 1\nbase: b.yaml\n");
  file("b.yaml", "base: [./c/../a.yaml]\n");
  std::filesystem::create_directories(folder_ / "c");
  EXPECT_EQ(complaint_about((folder_ / "a.yaml").string()),
            (folder_ / "b.yaml").string() + ":1:8: base: " + (folder_ / "a.yaml").string() +
                " is a base of itself, by way of " + (folder_ / "b.yaml").string());
  EXPECT_THAT(complaint_about(file("s.yaml", "base: s.yaml\n")), HasSubstr("s.yaml is a base of itself"));
}

TEST_F(Base, IsReadAsStrictlyAsAScenario) {
  file("a.yaml", kAll + "\nwalk.step_lenght_m: 1\n");
  EXPECT_EQ(complaint_about(file("s.yaml", "base: a.yaml\n")),
            (folder_ / "a.yaml").string() +
                ":5:1: walk.step_lenght_m: unknown key; did you mean 'walk.step_length_m'?");
  file("a.yaml", "- 1\n");
  EXPECT_THAT(complaint_about(file("s.yaml", "base: a.yaml\n")), HasSubstr("a.yaml:1:1: expected keys"));
}

TEST_F(Base, IsNoKeyOfTheCommandLineAndNoneBelowASection) {
  EXPECT_THAT(complaint(kAll, {{"base=a.yaml"}, {}}),
              HasSubstr("<argument>:1:1: base: belongs in a scenario"));
  EXPECT_THAT(complaint(kWalk + "world: {base: a.yaml}"), HasSubstr("world.base: unknown key"));
  EXPECT_THAT(complaint("bsae: a.yaml\n"), EndsWith("did you mean 'base'?"));
}

class Overlay : public Files {
 protected:
  static ReadScenario read(const Changes& changes) {
    return read_scenario_text(
        "walk: {commands: [{stand: {duration_s: 1}}]}\ncamera: {}\nslam: {gyro.sigma_rad_s: 0.02}\n",
        "s.yaml", changes);
  }
  static std::string complaint_about_overlay(const std::string& overlay) {
    return complaint_of([&] { read({{}, {}, {overlay}}); });
  }
};

TEST_F(Overlay, SetsAnewWhatTheScenarioSetAndSaysSo) {
  const ReadScenario with = read({{}, {}, {file("best.yaml", "slam.gyro.sigma_rad_s: 0.003\n")}});
  EXPECT_EQ(with.scenario.slam->gyro.sigma_rad_s, 0.003);
  EXPECT_EQ(with.origin.at("slam.gyro.sigma_rad_s"), (folder_ / "best.yaml").string() + ":1");
}

TEST_F(Overlay, GivesWayToTheNextOneAndToArguments) {
  const std::string a = file("a.yaml", "slam: {gyro: {sigma_rad_s: 0.1}, height: {sigma_m: 0.1}}\n"),
                    b = file("b.yaml", "slam.gyro.sigma_rad_s: 0.2\n");
  EXPECT_EQ(read({{}, {}, {a, b}}).scenario.slam->gyro.sigma_rad_s, 0.2);
  EXPECT_EQ(read({{}, {}, {a, b}}).scenario.slam->height.sigma_m, 0.1);
  EXPECT_EQ(read({{"slam.gyro.sigma_rad_s=0.3"}, {}, {a, b}}).scenario.slam->gyro.sigma_rad_s, 0.3);
}

TEST_F(Overlay, IsReadAsStrictlyAsAScenario) {
  EXPECT_THAT(complaint_about_overlay(file("o.yaml", "\nslam.gyro.sigma_rads: 1\n")),
              HasSubstr("o.yaml:2:1: slam.gyro.sigma_rads: unknown key"));
  EXPECT_THAT(
      complaint_about_overlay(file("o.yaml", "slam.height.sigma_m: 1\nslam: {height: {sigma_m: 2}}\n")),
      HasSubstr("given twice, first at"));
  EXPECT_THAT(complaint_about_overlay(file("o.yaml", "- 1\n")), HasSubstr("expected keys and values"));
  EXPECT_THAT(complaint_about_overlay(folder_ / "none.yaml"), HasSubstr("cannot be read"));
}

}  // namespace
}  // namespace sim::scenario
