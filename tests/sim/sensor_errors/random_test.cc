#include "sim/sensor_errors/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace sim::sensor_errors {
namespace {

TEST(Random, NumbersAreTheSameOnEveryMachine) {
  // Computed by a second program (Python's integers, and its own AS 241); a change here changes every run of
  // every seed.
  Random random(1, "gyro noise");
  EXPECT_EQ(random.bits(), 0xc0085b38e9e26c8full);
  EXPECT_EQ(random.uniform(), 0x1.fc926265345dcp-3);
  EXPECT_EQ(random.normal(), -0x1.d49c87681a44dp-1);
}

TEST(Random, AnotherSeedNameOrItemGivesOtherNumbers) {
  std::set<std::uint64_t> first;
  for (const std::uint64_t seed : {0ull, 1ull, 2ull, ~0ull})
    for (const char* name : {"", "gyro noise", "image noise"}) {
      first.insert(Random(seed, name).bits());
      for (const std::uint64_t item : {0ull, 1ull, ~0ull}) first.insert(Random(seed, name, item).bits());
    }
  EXPECT_EQ(first.size(), 4u * 3u * 4u);
}

TEST(Random, UniformNumbersFillTheUnitInterval) {
  Random random(3, "test");
  double sum = 0, square = 0, least = 1, most = 0;
  constexpr int n = 100000;
  for (int i = 0; i < n; ++i) {
    const double x = random.uniform();
    sum += x, square += x * x;
    least = std::min(least, x), most = std::max(most, x);
  }
  EXPECT_NEAR(sum / n, 0.5, 5 * std::sqrt(1.0 / 12 / n));  // five standard errors of the mean
  EXPECT_NEAR(square / n, 1.0 / 3, 5 * std::sqrt(4.0 / 45 / n));
  EXPECT_GE(least, 0);
  EXPECT_LT(most, 1);
}

TEST(Random, NormalNumbersHaveTheMomentsOfTheNormalDistribution) {
  Random random(4, "test");
  constexpr int n = 200000;
  double m1 = 0, m2 = 0, m3 = 0, m4 = 0;
  for (int i = 0; i < n; ++i) {
    const double z = random.normal();
    m1 += z, m2 += z * z, m3 += z * z * z, m4 += z * z * z * z;
  }
  // Five standard errors: the variances of z, z², z³, z⁴ are 1, 2, 15, 96.
  EXPECT_NEAR(m1 / n, 0, 5 * std::sqrt(1.0 / n));
  EXPECT_NEAR(m2 / n, 1, 5 * std::sqrt(2.0 / n));
  EXPECT_NEAR(m3 / n, 0, 5 * std::sqrt(15.0 / n));
  EXPECT_NEAR(m4 / n, 3, 5 * std::sqrt(96.0 / n));
}

TEST(Random, ConsecutiveNumbersAndNeighbouringItemsAreUncorrelated) {
  Random random(5, "test");
  constexpr int n = 100000;
  double serial = 0, items = 0, last = random.normal();
  for (int i = 0; i < n; ++i) {
    const double z = random.normal();
    serial += z * last;
    last = z;
    items += Random(5, "test", static_cast<std::uint64_t>(i)).normal() *
             Random(5, "test", static_cast<std::uint64_t>(i) + 1).normal();
  }
  EXPECT_NEAR(serial / n, 0, 5 / std::sqrt(n));
  EXPECT_NEAR(items / n, 0, 5 / std::sqrt(n));
}

TEST(Random, QuantileInvertsTheDistributionFunction) {
  // The C library's erfc is the independent side: Phi(z) = erfc(−z/√2) / 2.
  for (const double p : {1e-300, 1e-100, 1e-20, 1e-11, 1e-5, 0.01, 0.0749, 0.0751, 0.3, 0.4999, 0.5}) {
    const double z = normal_quantile(p);
    // 1e-13 relative: the condition of Phi, about z², times a few roundings at |z| = 37 loses three digits.
    EXPECT_NEAR(std::erfc(-z / std::sqrt(2.0)) / 2 / p, 1, p < 1e-50 ? 1e-11 : 1e-13) << p;
  }
  EXPECT_EQ(normal_quantile(0.5), 0);
  EXPECT_EQ(normal_quantile(0.25), -normal_quantile(0.75));
  EXPECT_NEAR(normal_quantile(0.975), 1.959963984540054, 1e-15);
}

}  // namespace
}  // namespace sim::sensor_errors
