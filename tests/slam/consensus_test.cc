#include "slam/vision/vision.h"

#include <gtest/gtest.h>

#include <random>

namespace slam {
namespace {

/// `good` matches that a common shift of the robot explains, then `bad` ones elsewhere.
StackedMeasurement matches(int good, int bad) {
  std::mt19937_64 random(7);
  const auto number = [&] { return 2 * static_cast<double>(random() >> 11) * 0x1p-53 - 1; };
  const auto noise = [&] {
    const double y = number(), x = number();  // one after the other: compilers differ in the order of arguments
    return Eigen::Vector2d(x, y);
  };
  const int count = good + bad;
  StackedMeasurement stacked;
  stacked.resize(kRobot, 2 * count);
  stacked.PHt().setZero();
  for (int i = 0; i <= count; ++i) stacked.first_row.push_back(2 * i);
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) stacked.S().block<2, 2>(2 * i, 2 * j) = 25 * Eigen::Matrix2d::Identity();
    stacked.S().block<2, 2>(2 * i, 2 * i) += 0.04 * Eigen::Matrix2d::Identity();
    stacked.innovation().segment<2>(2 * i) = Eigen::Vector2d(6, -4) + 0.1 * noise();
    if (i >= good) stacked.innovation().segment<2>(2 * i) = 8 * noise();
  }
  return stacked;
}

TEST(Consensus, KeepsTheMatchesThatOneMotionExplainsAndDropsTheRest) {
  Consensus consensus;
  const auto kept = consensus.largest(matches(8, 5), 9.21);
  EXPECT_EQ(kept, (std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 6, 7}));
}

TEST(Consensus, OfNoMatchesIsEmpty) { EXPECT_TRUE(Consensus().largest(matches(0, 0), 9.21).empty()); }

}  // namespace
}  // namespace slam
