// The search on functions with a known minimum.
#include "sim/trials/search.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sim::trials {
namespace {

template <typename F>
std::vector<double> best_of(CmaEs search, int generations, const F& value) {
  std::vector<double> best;
  for (int g = 0; g < generations; ++g) {
    const auto asked = search.ask();
    std::vector<double> values;
    for (const auto& x : asked) {
      values.push_back(value(x));
      if (best.empty() || values.back() < value(best)) best = x;
    }
    search.tell(values);
  }
  return best;
}

// A valley a hundred times as long as wide, along a diagonal.
double valley(const std::vector<double>& x) {
  const double along = x[0] + x[1] - 1.3, across = x[0] - x[1] - 0.3;
  return along * along + 1e4 * across * across;
}

TEST(CmaEs, FindsTheEndOfAStretchedValley) {
  const auto best = best_of(CmaEs({0.1, 0.9}, 0.25, 8, 1), 100, valley);
  EXPECT_NEAR(best[0], 0.8, 1e-4);
  EXPECT_NEAR(best[1], 0.5, 1e-4);
}

TEST(CmaEs, FindsALeastValueOnTheEdgeAndNeverLeavesTheCube) {
  const auto best = best_of(CmaEs({0.5, 0.5, 0.5}, 0.3, 10, 2), 80, [](const std::vector<double>& x) {
    for (const double part : x) EXPECT_TRUE(part >= 0 && part <= 1);
    return x[0] + std::abs(x[1] - 0.25) - x[2];
  });
  EXPECT_NEAR(best[0], 0, 1e-3);
  EXPECT_NEAR(best[1], 0.25, 1e-3);
  EXPECT_NEAR(best[2], 1, 1e-3);
}

TEST(CmaEs, AsksTheSameForTheSameSeedAndOtherwiseForAnother) {
  EXPECT_EQ(CmaEs({0.5}, 0.2, 6, 3).ask(), CmaEs({0.5}, 0.2, 6, 3).ask());
  EXPECT_NE(CmaEs({0.5}, 0.2, 6, 3).ask(), CmaEs({0.5}, 0.2, 6, 4).ask());
}

// Only the order of values counts.
TEST(CmaEs, DoesNotCareHowMuchWorseAFailureIs) {
  const auto with_failures = [](double failure) {
    return best_of(CmaEs({0.4, 0.4}, 0.25, 8, 5), 20, [&](const std::vector<double>& x) {
      return x[0] > 0.6 ? failure : valley({x[0] + 0.3, x[1]});
    });
  };
  EXPECT_EQ(with_failures(1e6), with_failures(1e9));
}

}  // namespace
}  // namespace sim::trials
