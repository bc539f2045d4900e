#include "sim/score/alignment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/sim/score/score_fixtures.h"

namespace sim::score {
namespace {

using testing::HasSubstr;

Similarity aligned(const std::vector<PosePair>& pairs, Alignment alignment) {
  return std::get<Similarity>(align(pairs, alignment));
}

std::string reason(const std::vector<PosePair>& pairs, Alignment alignment) {
  return std::get<Absent>(align(pairs, alignment)).reason;
}

double error(const Similarity& S, const std::vector<PosePair>& pairs) {
  return root_mean_square(position_errors(transformed(S, pairs)));
}
double ate(const std::vector<PosePair>& pairs, Alignment alignment) {
  return error(aligned(pairs, alignment), pairs);
}

TEST(Alignment, UndoesTheMotionItAllowsExactly) {
  const std::vector<PosePair> pairs = noisy_pairs(40, 0);
  const Eigen::Vector3d shift(1, 2, 3);
  const Eigen::Matrix3d R = scattered_pose(7, 2, 2).linear();
  for (const auto& [alignment, S] :
       std::vector<std::pair<Alignment, Similarity>>{{Alignment::yaw_position, {1, about_z(2), shift}},
                                                     {Alignment::origin, {1, R, shift}},
                                                     {Alignment::se3, {1, R, shift}},
                                                     {Alignment::sim3, {0.37, R, shift}},
                                                     {Alignment::scale, {0.37}}}) {
    const std::vector<PosePair> moved = transformed(S, pairs);
    for (const PosePair& pair : transformed(aligned(moved, alignment), moved)) {
      EXPECT_LT((pair.X_true.translation() - pair.X_estimate.translation()).norm(), 1e-12);
      EXPECT_LT((pair.X_true.linear() - pair.X_estimate.linear()).norm(), 1e-12);
    }
  }
}

TEST(Alignment, NoNearbyMotionIsBetter) {
  const std::vector<PosePair> pairs = noisy_pairs(40, 0.2);
  for (const Alignment alignment : {Alignment::yaw_position, Alignment::se3, Alignment::sim3}) {
    const Similarity best = aligned(pairs, alignment);
    for (int i = 0; i < 20; ++i) {
      Similarity other = best;
      Eigen::Vector3d turn = 1e-3 * scattered(i, 1);
      if (alignment == Alignment::yaw_position) turn.head<2>().setZero();
      if (alignment == Alignment::sim3) other.scale *= 1 + 1e-3 * scatter(i, 9);
      other.R = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * best.R;
      other.translation += 1e-3 * scattered(i, 4);
      EXPECT_GT(error(other, pairs), error(best, pairs));
    }
  }
}

TEST(Alignment, AMirrorImageIsNotATurn) {
  std::vector<PosePair> pairs = noisy_pairs(40, 0);
  for (PosePair& pair : pairs) pair.X_estimate.translation().x() *= -1;
  EXPECT_NEAR(aligned(pairs, Alignment::se3).R.determinant(), 1, 1e-12);
  EXPECT_GT(ate(pairs, Alignment::se3), 0.1);
}

TEST(Alignment, DegenerateCasesHaveAReason) {
  std::vector<PosePair> point(10), line = point, vertical = point;
  for (int i = 0; i < 10; ++i) {
    const auto place = [i](std::vector<PosePair>& pairs, const Eigen::Vector3d& p) {
      PosePair& pair = pairs[static_cast<std::size_t>(i)];
      pair.X_true.translation() = pair.X_estimate.translation() = p;
    };
    place(point, {1, 2, 3});
    place(line, {1.0 * i, 2.0 * i, 0.5 * i});
    place(vertical, {1, 2, 1.0 * i});
  }
  using enum Alignment;
  for (const Alignment a : {none, origin, yaw_position, se3, sim3})
    EXPECT_THAT(reason({}, a), HasSubstr("no pose"));
  for (const Alignment a : {se3, sim3}) {
    EXPECT_THAT(reason(point, a), HasSubstr("coincide"));
    EXPECT_THAT(reason(line, a), HasSubstr("one line"));
  }
  EXPECT_THAT(reason({line[3]}, se3), HasSubstr("coincide"));
  for (const auto& pairs : {point, vertical})
    EXPECT_THAT(reason(pairs, yaw_position), HasSubstr("do not spread"));
  EXPECT_NEAR(ate(line, yaw_position), 0, 1e-12);  // a line is enough for a turn about z
  EXPECT_NEAR(ate({line[3]}, origin), 0, 1e-12);
}

TEST(Alignment, HandComputedSquare) {
  // The estimate is the square twice as large, turned by 90°, shifted by (5, 0, 0).
  std::vector<PosePair> pairs;
  const double corners[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
  for (const auto& c : corners)
    pairs.push_back({Stamp(0), upright(c[0], c[1], 0), upright(5 - 2 * c[1], 2 * c[0], 0)});
  const Similarity S = aligned(pairs, Alignment::sim3);
  EXPECT_NEAR(S.scale, 0.5, 1e-15);
  EXPECT_TRUE(S.R.isApprox(about_z(-M_PI / 2), 1e-15));
  EXPECT_TRUE(S.translation.isApprox(Eigen::Vector3d(0, 2.5, 0), 1e-15));
  EXPECT_NEAR(ate(pairs, Alignment::se3), std::sqrt(2.0), 1e-14);  // corners at 2√2 against √2
  EXPECT_NEAR(ate(pairs, Alignment::yaw_position), std::sqrt(2.0), 1e-14);
}

}  // namespace
}  // namespace sim::score
