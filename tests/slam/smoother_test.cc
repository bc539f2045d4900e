#include "slam/smoother.h"

#include <sys/resource.h>

#include <csignal>

#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

constexpr int kSteps = 7;

/// A step with all kinds of changes. It is the same for all filters that took the same previous steps.
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
  if (k == 3) {
    const int at = kalman.append(random_landmark(normal));
    stack(kalman.state(), {random_measurement(2, at, 0.1, normal)}, all);
    EXPECT_TRUE(kalman.update(all));
  }
  if (k == 4) kalman.append_point(random_matrix(3, 1, normal), 0.5);
  if (k == 5) kalman.reset_robot({random_mean(normal), random_covariance(normal)});
}

constexpr std::array kCopied{0, 1, 3, 4, 5, 6};  // indices of the pose: x, y, orientation

/// The pose after a step (z is 0), taken at the end from a copy in the state, which all later measurements
/// update.
Eigen::Isometry3d pose_of_copy(int after, Kalman kalman) {
  for (int k = 0; k <= after; ++k) step(k, kalman);
  LandmarkInitialization copy{kalman.state().x()(kCopied), {}, Matrix6d::Zero()};
  copy.J_robot.setZero();
  for (int i = 0; i < 6; ++i) copy.J_robot(i, kCopied[static_cast<std::size_t>(i)]) = 1;
  const int at = kalman.append(copy) - (after < 1 ? 3 : 0) - (after < 2 ? 6 : 0);  // at the end
  for (int k = after + 1; k < kSteps; ++k) step(k, kalman);
  State state;
  state.storage_x(kCopied) = kalman.state().x().segment<6>(at);
  state.storage_x.segment<4>(kOrientation).normalize();
  return state.X_WC();
}

TEST(Smoother, APoseEqualsACopyInTheStateThatAllLaterMeasurementsUpdate) {
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
  auto poses = smoother.smoothed();
  ASSERT_TRUE(poses && poses->size() == online.size());
  for (std::size_t k = 0; k < online.size(); ++k) {
    auto& [t, X_WC] = (*poses)[k];
    X_WC.translation().z() = online[k].translation().z() = 0;
    EXPECT_EQ(t, Stamp(k));
    EXPECT_TRUE(X_WC.isApprox(pose_of_copy(static_cast<int>(k), start), 1e-5)) << k;  // single precision
    EXPECT_EQ(X_WC.isApprox(online[k], 1e-3), k + 1 == online.size()) << k;
  }
}

TEST(Smoother, ReturnsNothingIfItsFileCannotBeWritten) {
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
