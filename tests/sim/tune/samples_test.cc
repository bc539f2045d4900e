#include "sim/tune/samples.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace sim::tune {
namespace {

using testing::ElementsAre;

constexpr std::size_t kDimensions = 10;

TEST(Sobol, FirstPointsAreThoseOfJoeAndKuo) {
  const auto points = sobol_points(7, 3, 0);  // the worked example beside their direction numbers
  EXPECT_THAT(points[0], ElementsAre(0.5, 0.5, 0.5));
  EXPECT_THAT(points[1], ElementsAre(0.75, 0.25, 0.25));
  EXPECT_THAT(points[2], ElementsAre(0.25, 0.75, 0.75));
  EXPECT_THAT(points[3], ElementsAre(0.375, 0.375, 0.625));
  EXPECT_THAT(points[4], ElementsAre(0.875, 0.875, 0.125));
  EXPECT_THAT(points[5], ElementsAre(0.625, 0.125, 0.875));
  EXPECT_THAT(points[6], ElementsAre(0.125, 0.625, 0.375));
}

/// Points and the origin that fall into each of n equal parts of each dimension.
void expect_one_in_each_part(const std::vector<std::vector<double>>& points, bool with_origin) {
  const std::size_t n = points.size() + (with_origin ? 1 : 0);
  for (std::size_t d = 0; d < points[0].size(); ++d) {
    std::set<int> parts;
    if (with_origin) parts.insert(0);
    for (const auto& point : points) parts.insert(static_cast<int>(point[d] * static_cast<double>(n)));
    EXPECT_EQ(parts.size(), n) << "dimension " << d;
  }
}

TEST(Sobol, EachDimensionHasOnePointInEachEqualPart) {
  expect_one_in_each_part(sobol_points(1023, kDimensions, 0), true);
}

TEST(Sobol, SquaresOfNeighbouringDimensionsAreFilledEvenlyToo) {
  const auto points = sobol_points(1023, kDimensions, 0);
  for (std::size_t d = 1; d < kDimensions; ++d) {
    std::vector<int> hits(64);
    ++hits[0];  // the origin
    for (const auto& p : points)
      ++hits[static_cast<std::size_t>(p[d - 1] * 8) * 8 + static_cast<std::size_t>(p[d] * 8)];
    for (const int n : hits)
      EXPECT_NEAR(n, 16, 8) << "dimensions " << d - 1 << ", " << d;  // random ones: 16 ± 4, worst of 576: 3
  }
}

TEST(Sobol, ASeedShiftsWithoutMakingItUneven) {
  const auto shifted = sobol_points(64, 4, 7);
  EXPECT_NE(shifted, sobol_points(64, 4, 0));
  EXPECT_EQ(shifted, sobol_points(64, 4, 7));
  EXPECT_NE(shifted, sobol_points(64, 4, 8));
  for (const auto& point : shifted)
    for (const double x : point) EXPECT_TRUE(x >= 0 && x < 1);
}

TEST(RandomPoints, DependOnSeedAndPlaceAlone) {
  const auto few = random_points(5, 3, 1), many = random_points(500, 3, 1);
  EXPECT_TRUE(std::equal(few.begin(), few.end(), many.begin()));
  EXPECT_NE(random_points(5, 3, 2), few);
  double sum = 0;
  for (const auto& point : many) sum += point[1];
  EXPECT_NEAR(sum / 500, 0.5, 5 * 0.29 / 22);  // five standard deviations of the mean
}

}  // namespace
}  // namespace sim::tune
