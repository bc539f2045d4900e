#include "slam/smoother.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <array>
#include <csignal>

#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

constexpr int kSteps = 7;

/// A step with changes of all kinds, the same for every filter that has had the same ones before.
void step(int k, Kalman& kalman) {
  Normal normal(100 + static_cast<std::uint64_t>(k));
  const RobotMatrix F = RobotMatrix::Identity() + 0.1 * random_matrix(kRobot, kRobot, normal);
  kalman.predict(F * kalman.state().robot(), F, random_covariance(normal));
  kalman.predict_match_bias(kRobot, 0.8, 0.1);
  StackedMeasurement all, selected;
  stack(kalman.state(), DenseStack(kalman.state(), normal).measurements, all);
  select(all, {1, 2}, selected);
  EXPECT_TRUE(kalman.update(k % 2 == 0 ? all : selected));
  if (k == 1) kalman.replace(kRobot + 12, 6, random_matrix(3, 1, normal), random_matrix(3, 6, normal));
  if (k == 2) kalman.erase(kRobot + 15, 6);
  if (k == 3) kalman.append(random_landmark(normal));
  if (k == 4) kalman.append_point(random_matrix(3, 1, normal), 0.5);
  if (k == 5) kalman.reset_robot({random_mean(normal), random_covariance(normal)});
}

/// The pose after a step, as a copy of it in the state has it at the end, which later measurements update.
Eigen::Isometry3d pose_of_copy(int after, Kalman kalman) {
  for (int k = 0; k <= after; ++k) step(k, kalman);
  std::array<int, 2> at{};
  for (const int first : {0, 4}) {  // parameters of the pose: 0 to 5, then 4 to 9
    LandmarkInitialization copy{kalman.state().x().segment<6>(first), {}, Matrix6d::Zero()};
    copy.J_robot.setZero(), copy.J_robot.middleCols<6>(first).setIdentity();
    at[first == 0 ? 0 : 1] = kalman.append(copy);
  }
  const int before = kalman.state().size;
  for (int k = after + 1; k < kSteps; ++k) step(k, kalman);
  const int moved = (after < 1 ? 3 : 0) + (after < 2 ? 6 : 0);
  EXPECT_LE(at[1] + 6, before);
  State state;
  state.storage_x.head<6>() = kalman.state().x().segment<6>(at[0] - moved);
  state.storage_x(6) = kalman.state().x()(at[1] - moved + 2);
  state.storage_x.segment<4>(kOrientation).normalize();
  return state.X_WC();
}

TEST(Smoother, APoseIsThatOfACopyInTheStateThatAllLaterMeasurementsUpdate) {
  Normal normal(3);
  const Kalman start = random_filter(4, false, normal);
  Kalman kalman = start;
  Smoother smoother;
  kalman.record(smoother);
  std::vector<Eigen::Isometry3d> online;
  for (int k = 0; k < kSteps; ++k) {
    step(k, kalman);
    smoother.end_step(Stamp(k), kalman.state());
    online.push_back(kalman.state().X_WC());
  }
  const auto poses = smoother.smoothed();
  ASSERT_TRUE(poses);
  ASSERT_EQ(poses->size(), online.size());
  for (int k = 0; k < kSteps; ++k) {
    const auto& [t, X_WC] = (*poses)[static_cast<std::size_t>(k)];
    const Eigen::Isometry3d& unsmoothed = online[static_cast<std::size_t>(k)];
    EXPECT_EQ(t, Stamp(k));
    EXPECT_LT((X_WC.matrix() - pose_of_copy(k, start).matrix()).norm(), 1e-5) << k;  // single precision
    if (k + 1 < kSteps) EXPECT_GT((X_WC.matrix() - unsmoothed.matrix()).norm(), 0.01) << k;
  }
}

TEST(Smoother, GivesNothingIfItsFileCannotBeWritten) {
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit none{0, before.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &none), 0);
  Normal normal(4);
  Smoother smoother;
  smoother.end_step(Stamp(0), random_filter(4, false, normal).state());
  EXPECT_FALSE(smoother.smoothed());
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
}

}  // namespace
}  // namespace slam
