// Values to try: how they are read, scaled and spread.
#include "sim/trials/values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace sim::trials {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// The values of slam.vision.sigma_px in YAML.
Values values(const std::string& text, const std::string& key = "slam.vision.sigma_px") {
  const scenario::Yaml map = scenario::parse_yaml(key + ": " + text, {"spec.yaml"});
  return read_values(map.keys[0], map.items[0]);
}

std::string error_of(const std::string& text, const std::string& key = "slam.vision.sigma_px") {
  try {
    values(text, key);
  } catch (const scenario::ConfigError& e) {
    return e.what();
  }
  return "none";
}

std::vector<std::string> grid(const std::string& text) {
  std::vector<std::string> texts;
  for (const double value : std::get<Range>(values(text)).grid())
    texts.push_back(number_node(value, {}, true).text);
  return texts;
}

TEST(Values, AreAListOrOneValueOrARange) {
  EXPECT_EQ(std::get<0>(values("0.50"))[0].text, "0.50");
  EXPECT_EQ(std::get<0>(values("[1, 2, 3]")).size(), 3u);
  const Range range =
      std::get<Range>(values("{from: 1, to: 4, start: 3, scale: linear, also: [slam.height.sigma_m]}"));
  EXPECT_FALSE(range.logarithmic);
  EXPECT_EQ(range.start, 3);
  EXPECT_THAT(range.also, ElementsAre("slam.height.sigma_m"));
  EXPECT_EQ(std::get<Range>(values("[{from: 1, to: 2}]")).high, 2);
}

TEST(Values, OfAGridHaveEvenDistancesOrFactors) {
  EXPECT_THAT(grid("{from: 1, to: 2, points: 5, scale: linear}"),
              ElementsAre("1", "1.25", "1.5", "1.75", "2"));
  EXPECT_THAT(grid("{from: 0.01, to: 10, points: 4}"), ElementsAre("0.01", "0.1", "1", "10"));
}

TEST(Values, ErrorsNameThePlace) {
  EXPECT_EQ(error_of("{from: 1, too: 2}"), "spec.yaml:1:33: too: unknown key; did you mean 'to'?");
  EXPECT_THAT(error_of("{from: 1}"), HasSubstr("expected both from and to"));
  EXPECT_THAT(error_of("{from: 2, to: 1}"), HasSubstr("expected a rising range"));
  EXPECT_THAT(error_of("{from: 1, to: abc}"), testing::StartsWith("spec.yaml:1:37: slam.vision.sigma_px: "));
  EXPECT_THAT(error_of("{from: -1, to: 1}"), testing::StartsWith("spec.yaml:1:30: slam.vision.sigma_px: "));
  EXPECT_THAT(error_of("{from: 0, to: 1}", "slam.depth.linearity"), HasSubstr("must start above 0"));
  EXPECT_THAT(error_of("{from: 1, to: 2, points: 1}"), HasSubstr("points: is '1', expected a whole number"));
  EXPECT_THAT(error_of("{from: 1, to: 2, start: 3}"), HasSubstr("start 3 is outside 1 to 2"));
  EXPECT_THAT(error_of("{from: 1, to: 2}", "slam.gyro.enabled"),
              HasSubstr("expected a key that is a number"));
  EXPECT_THAT(error_of("{from: 1, to: 2, also: [slam.visio.sigma_px]}"), HasSubstr("did you mean"));
  EXPECT_THAT(error_of("[]"), HasSubstr("has no values"));
}

TEST(Range, GoesFromLowToHighByItsLogarithmOrLinearly) {
  const Range log{"k", {}, 0.001, 0.1, 0.01, true}, linear{"k", {}, -1, 3, 0, false};
  EXPECT_NEAR(log.value_at(0.5), 0.01, 1e-16);
  EXPECT_EQ(log.value_at(0), 0.001);
  EXPECT_EQ(log.value_at(1), 0.1);
  EXPECT_NEAR(log.coordinate_of(0.01), 0.5, 1e-15);
  EXPECT_EQ(linear.value_at(0.5), 1);
  EXPECT_EQ(linear.coordinate_of(0), 0.25);
}

TEST(Set, GivesAKeyExactlyTheNumber) {
  scenario::Scenario scenario =
      scenario::read_scenario_text("walk: {commands: [stand: {duration_s: 1}]}\ncamera: {}\nslam: {}\n",
                                   "s.yaml")
          .scenario;
  set(scenario, "slam.gyro.sigma_rad_s", 0.1 + 0.2);
  EXPECT_EQ(scenario.slam->gyro.sigma_rad_s, 0.1 + 0.2);
}

TEST(Sobol, FirstPointsAreThoseOfJoeAndKuo) {
  const auto points = sobol_points(7, 3);  // the worked example beside their direction numbers
  EXPECT_THAT(points, ElementsAre(ElementsAre(0.5, 0.5, 0.5), ElementsAre(0.75, 0.25, 0.25),
                                  ElementsAre(0.25, 0.75, 0.75), ElementsAre(0.375, 0.375, 0.625),
                                  ElementsAre(0.875, 0.875, 0.125), ElementsAre(0.625, 0.125, 0.875),
                                  ElementsAre(0.125, 0.625, 0.375)));
}

TEST(Sobol, FillsDimensionsAndSquaresOfNeighborsEvenly) {
  constexpr std::size_t kPoints = 1023, kDimensions = 11;
  const auto points = sobol_points(kPoints, kDimensions);
  for (std::size_t d = 0; d < kDimensions; ++d) {
    std::set<int> parts{0};  // of the origin
    std::vector<int> hits(64);
    ++hits[0];
    for (const auto& p : points) {
      parts.insert(static_cast<int>(p[d] * (kPoints + 1)));
      if (d > 0) ++hits[static_cast<std::size_t>(p[d - 1] * 8) * 8 + static_cast<std::size_t>(p[d] * 8)];
    }
    EXPECT_EQ(parts.size(), kPoints + 1) << "dimension " << d;
    for (std::size_t i = 0; d > 0 && i < hits.size(); ++i)
      EXPECT_NEAR(hits[i], 16, 8) << "dimensions " << d - 1 << ", " << d;  // random ones: 16 ± 4
  }
}

}  // namespace
}  // namespace sim::trials
