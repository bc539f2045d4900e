#include "sim/score/alignment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/score/statistics.h"
#include "tests/sim/score/random_trajectory.h"

namespace sim::score {
namespace {

using testing::HasSubstr;

Similarity aligned(const std::vector<PosePair>& pairs, Alignment alignment) {
  const auto S = align(pairs, alignment);
  EXPECT_TRUE(std::holds_alternative<Similarity>(S));
  return std::get<Similarity>(S);
}

std::string reason(const std::vector<PosePair>& pairs, Alignment alignment) {
  const auto S = align(pairs, alignment);
  return std::holds_alternative<Absent>(S) ? std::get<Absent>(S).reason : "";
}

double ate(const std::vector<PosePair>& pairs, Alignment alignment) {
  return root_mean_square(position_errors(transformed(aligned(pairs, alignment), pairs)));
}

// The estimates moved by a similarity that the alignment is to undo.
std::vector<PosePair> moved(const Similarity& S, std::vector<PosePair> pairs) {
  return transformed(S, std::move(pairs));
}

Similarity turn_about_z(double angle) {
  return {1, Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {1, 2, 3}};
}
Similarity turn_about_any() { return {1, scattered_pose(7, 2, 2).linear(), {1, 2, 3}}; }
Similarity with_scale(Similarity S, double scale) {
  S.scale = scale;
  return S;
}

TEST(Alignment, UndoesTheMotionItAllowsExactly) {
  const std::vector<PosePair> pairs = noisy_pairs(40, 0);
  const auto check = [&](Alignment alignment, const Similarity& S) {
    const std::vector<PosePair> undone = transformed(aligned(moved(S, pairs), alignment), moved(S, pairs));
    for (const PosePair& pair : undone) {
      EXPECT_LT((pair.X_true.translation() - pair.X_estimate.translation()).norm(), 1e-12);
      EXPECT_LT((pair.X_true.linear() - pair.X_estimate.linear()).norm(), 1e-12);
    }
  };
  check(Alignment::yaw_position, turn_about_z(2));
  check(Alignment::origin, turn_about_any());
  check(Alignment::se3, turn_about_any());
  check(Alignment::sim3, with_scale(turn_about_any(), 0.37));
  check(Alignment::scale, with_scale({}, 0.37));
}

TEST(Alignment, NoNearbyMotionIsBetter) {
  const std::vector<PosePair> pairs = noisy_pairs(40, 0.2);
  const auto squares = [&](const Similarity& S) {
    const double rms = root_mean_square(position_errors(transformed(S, pairs)));
    return rms * rms;
  };
  for (const Alignment alignment : {Alignment::yaw_position, Alignment::se3, Alignment::sim3}) {
    const Similarity best = aligned(pairs, alignment);
    for (int i = 0; i < 20; ++i) {
      Similarity other = best;
      Eigen::Vector3d turn = 1e-3 * scattered(i, 1);
      if (alignment == Alignment::yaw_position) turn.head<2>().setZero();
      other.R = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * best.R;
      other.translation += 1e-3 * scattered(i, 4);
      EXPECT_GT(squares(other), squares(best));
      if (alignment != Alignment::sim3) continue;
      other = best;
      other.scale *= 1 + 1e-3 * scatter(i, 9);
      // The least-squares scale of Umeyama with its own shift is the minimum over the scale too.
      Eigen::Vector3d mean_true = Eigen::Vector3d::Zero(), mean_estimate = Eigen::Vector3d::Zero();
      for (const PosePair& pair : pairs)
        mean_true += pair.X_true.translation() / 40, mean_estimate += pair.X_estimate.translation() / 40;
      other.translation = mean_true - other.scale * other.R * mean_estimate;
      EXPECT_GE(squares(other), squares(best));
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
  const std::vector<PosePair> none;
  for (const Alignment a :
       {Alignment::none, Alignment::origin, Alignment::yaw_position, Alignment::se3, Alignment::sim3})
    EXPECT_THAT(reason(none, a), HasSubstr("no pose"));

  std::vector<PosePair> point = noisy_pairs(10, 0), line = point, upright = point;
  for (std::size_t i = 0; i < point.size(); ++i) {
    const double s = static_cast<double>(i);
    point[i].X_true.translation() = point[i].X_estimate.translation() = Eigen::Vector3d(1, 2, 3);
    line[i].X_true.translation() = line[i].X_estimate.translation() = Eigen::Vector3d(s, 2 * s, 0.5 * s);
    upright[i].X_true.translation() = upright[i].X_estimate.translation() = Eigen::Vector3d(1, 2, s);
  }
  EXPECT_THAT(reason(point, Alignment::yaw_position), HasSubstr("do not spread"));
  EXPECT_THAT(reason(point, Alignment::se3), HasSubstr("coincide"));
  EXPECT_THAT(reason(point, Alignment::sim3), HasSubstr("coincide"));
  EXPECT_THAT(reason(line, Alignment::se3), HasSubstr("one line"));
  EXPECT_THAT(reason(line, Alignment::sim3), HasSubstr("one line"));
  EXPECT_THAT(reason({line[3]}, Alignment::se3), HasSubstr("coincide"));
  EXPECT_THAT(reason(upright, Alignment::yaw_position), HasSubstr("do not spread"));
  EXPECT_NEAR(ate(line, Alignment::yaw_position), 0, 1e-12);  // a line is enough for a turn about z
  EXPECT_NEAR(ate({line[3]}, Alignment::origin), 0, 1e-12);
}

TEST(Alignment, HandComputedSquare) {
  // The estimate is the square twice as large, turned by 90°, shifted by (5, 0, 0).
  std::vector<PosePair> pairs;
  const double corners[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
  for (const auto& c : corners) {
    PosePair pair;
    pair.X_true.translation() = Eigen::Vector3d(c[0], c[1], 0);
    pair.X_estimate.translation() = Eigen::Vector3d(5 - 2 * c[1], 2 * c[0], 0);
    pairs.push_back(pair);
  }
  const Similarity S = aligned(pairs, Alignment::sim3);
  EXPECT_NEAR(S.scale, 0.5, 1e-15);
  EXPECT_TRUE(S.R.isApprox(Eigen::AngleAxisd(-M_PI / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix(), 1e-15));
  EXPECT_TRUE(S.translation.isApprox(Eigen::Vector3d(0, 2.5, 0), 1e-15));
  EXPECT_NEAR(ate(pairs, Alignment::se3), std::sqrt(2.0), 1e-14);  // corners at 2√2 against √2
  EXPECT_NEAR(ate(pairs, Alignment::yaw_position), std::sqrt(2.0), 1e-14);
}

}  // namespace
}  // namespace sim::score
