// Files of keys laid over a scenario, as the best.yaml of a tuning.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "sim/bench/scenario.h"
#include "sim/bench/scenario_yaml.h"
#include "tests/sim/stream/temporary_folder.h"

namespace sim::bench {
namespace {

class Overlay : public testing::Test {
 protected:
  std::string file(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  static ReadScenario read(const Changes& changes) {
    return read_scenario_text(
        "walk: {commands: [{stand: {duration_s: 1}}]}\ncamera: {}\nslam: {gyro.sigma_rad_s: 0.02}\n",
        "s.yaml", changes);
  }
  std::string complaint(const std::string& overlay) const {
    try {
      read({{}, {}, {overlay}});
    } catch (const ConfigError& e) {
      return e.what();
    }
    return "no complaint";
  }
  stream::TemporaryFolder folder_;
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
  EXPECT_THAT(complaint(file("o.yaml", "\nslam.gyro.sigma_rads: 1\n")),
              testing::HasSubstr("o.yaml:2:1: slam.gyro.sigma_rads: unknown key"));
  EXPECT_THAT(complaint(file("o.yaml", "slam.height.sigma_m: 1\nslam: {height: {sigma_m: 2}}\n")),
              testing::HasSubstr("given twice, first at"));
  EXPECT_THAT(complaint(file("o.yaml", "- 1\n")), testing::HasSubstr("expected keys and values"));
  EXPECT_THAT(complaint(folder_ / "none.yaml"), testing::HasSubstr("cannot be read"));
}

}  // namespace
}  // namespace sim::bench
