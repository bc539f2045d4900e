// The filter's models and algebra with truth and noise drawn from its own models: errors and innovations then
// match their covariances, and the covariance stays valid for ten minutes.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "slam/inertial.h"
#include "slam/motion_model.h"
#include "slam/plan.h"
#include "slam/vision/active_search.h"
#include "tests/slam/synthetic_room.h"
#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

using synthetic::Normal;

constexpr double kDt_s = 1.0 / 30;

Eigen::Vector3d vector(Normal& normal, double sigma) {
  const double x = normal(), y = normal(), z = normal();
  return sigma * Eigen::Vector3d(x, y, z);
}

Options options_of_the_test() {
  Options options;
  options.motion.sigma_acceleration_m_s2 = options.motion.sigma_angular_acceleration_rad_s2 = 1;
  options.accelerometer.sigma_bias_m_s2 = options.accelerometer.sigma_bias_walk_m_s3 = 0;
  options.plan_velocity.sigma_sway_m_s = options.plan_velocity.sigma_stride = 0;
  options.plan_velocity.pivots_on_foot = false;
  return options;
}

/// Position, orientation, velocity and rate: small errors of 12 from 13 parameters.
Eigen::MatrixXd small_errors(const Eigen::Vector4d& q) {
  Eigen::Vector4d back = q;
  back.tail<3>() *= -1;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(12, kCamera);  // of a dynamic size: fixed ones are unrolled
  J.block<3, 3>(0, kPosition).setIdentity();
  J.block<3, 4>(3, kOrientation) = 2 * left_matrix(back).bottomRows<3>();
  J.block<6, 6>(6, kVelocity).setIdentity();
  return J;
}

RobotMatrix start_covariance(const RobotVector& x) {
  Eigen::VectorXd variance(12);
  variance << Eigen::Vector3d::Constant(1e-4), Eigen::Vector3d::Constant(1e-4),
      Eigen::Vector3d::Constant(25e-4), Eigen::Vector3d::Constant(25e-4);
  RobotMatrix P = RobotMatrix::Zero();
  Eigen::MatrixXd back = Eigen::MatrixXd::Zero(kCamera, 12);  // small_errors⁺
  back.block<3, 3>(kPosition, 0).setIdentity();
  back.block<4, 3>(kOrientation, 3) = small_rotation_jacobian(x.segment<4>(kOrientation));
  back.block<6, 6>(kVelocity, 6).setIdentity();
  P.topLeftCorner<kCamera, kCamera>() = back * variance.asDiagonal() * back.transpose();
  return P;
}

/// A robot, the landmarks around it, and the filter that follows it.
struct World {
  explicit World(std::uint64_t seed, int landmarks) : normal(seed) {
    truth.segment<3>(kPosition) += vector(normal, 0.01);
    truth.segment<4>(kOrientation) =
        quaternion_product(truth.segment<4>(kOrientation), quaternion_exp(vector(normal, 0.01)));
    truth.segment<3>(kVelocity) = vector(normal, 0.05);
    truth.segment<3>(kRate) = vector(normal, 0.05);
    for (int i = 0; i < landmarks; ++i) {
      const double angle = 2 * 3.14159265358979 * i / landmarks, away = 3 + i % 3;
      const Eigen::Vector3d p(away * std::cos(angle), away * std::sin(angle), 0.6 + 0.35 * (i % 5));
      Landmark landmark;
      landmark.id = i;
      landmark.kind = Point{};
      landmark.at = kalman.append_point(p, 0.02);
      landmark.X_WC_first.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) *
                                     rotation_matrix(looking_ahead().segment<4>(kOrientation));
      landmark.X_WC_first.translation() << 0, 0, 1.4;
      map.push_back(landmark);
      places.push_back(p + vector(normal, 0.02));
    }
  }

  /// One frame: the truth moves by unknown accelerations, the filter predicts and measures.
  void step() {
    const Eigen::Vector3d V = vector(normal, options.motion.sigma_acceleration_m_s2 * kDt_s),
                          W = vector(normal, options.motion.sigma_angular_acceleration_rad_s2 * kDt_s);
    truth.segment<3>(kVelocity) += V;
    truth.segment<3>(kRate) += W;
    truth = predict_motion(truth, kDt_s, std::nullopt, options).x;
    follow();
  }

  void follow() {
    const RobotVector x = kalman.state().robot();
    const Prediction p = predict_motion(x, kDt_s, std::nullopt, options);
    kalman.predict(p.x, p.F, p.Q);
    const RobotVector now = kalman.state().robot();
    const Eigen::Matrix3d R = rotation_matrix(truth.segment<4>(kOrientation));
    const MeanRate rate{truth.segment<3>(kRate) + vector(normal, 0.01), 0.01};
    const Eigen::Vector3d v_C = R.transpose() * truth.segment<3>(kVelocity) + vector(normal, 0.05);
    update({measure_rate(now, rate)}, gyro_nis);
    update({measure_velocity(kalman.state().robot(), {v_C, {0, 0, 0}, {0, 0, 0}, v_C, 0.05},
                             options.plan_velocity)},
           velocity_nis);
    see();
  }

  /// Measures at most 12 of the landmarks in view, as pixels with the assumed noise of the camera.
  void see() {
    std::vector<Measurement> found;
    auto view = predict_view(kalman, map, camera, options.vision.sigma_px);
    keep_most_informative(view, 12);
    Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
    X_WC.linear() = rotation_matrix(truth.segment<4>(kOrientation));
    X_WC.translation() = truth.segment<3>(kPosition);
    for (Candidate& candidate : view) {
      const auto seen = camera.project(X_WC.inverse() * places[candidate.index]);
      if (!seen) continue;
      const double sigma = pixel_noise * camera.sigma(candidate.pixel, options.vision.sigma_px);
      const double u = normal(), v = normal();
      candidate.measurement.innovation = seen->pixel + sigma * Eigen::Vector2d(u, v) - candidate.pixel;
      found.push_back(candidate.measurement);
    }
    if (!found.empty()) update(found, vision_nis);
  }

  void update(const std::vector<Measurement>& measurements, std::vector<double>& nis) {
    StackedMeasurement stacked;
    stack(kalman.state(), measurements, stacked);
    nis.push_back(stacked.innovation().dot(Eigen::MatrixXd(stacked.S()).llt().solve(stacked.innovation())));
    rows = stacked.rows;
    ASSERT_TRUE(kalman.update(stacked));
  }

  double nees() const {
    const RobotVector x = kalman.state().robot();
    const Eigen::Vector4d q = x.segment<4>(kOrientation);
    Eigen::Vector4d back = q, dq;
    back.tail<3>() *= -1;
    dq = quaternion_product(back, truth.segment<4>(kOrientation));
    Eigen::VectorXd e(12);
    e << truth.segment<3>(kPosition) - x.segment<3>(kPosition), quaternion_log(dq),
        truth.segment<6>(kVelocity) - x.segment<6>(kVelocity);
    const Eigen::MatrixXd J = small_errors(q),
                          P = J * Eigen::MatrixXd(kalman.state().marginal<kCamera>(0)) * J.transpose();
    return e.dot(P.llt().solve(e));
  }

  Options options = options_of_the_test();
  Camera camera{CameraIntrinsics{}};
  Kalman kalman{{looking_ahead(), start_covariance(looking_ahead())}, false};
  RobotVector truth = looking_ahead();
  std::vector<Landmark> map;
  std::vector<Eigen::Vector3d> places;
  Normal normal;
  std::vector<double> gyro_nis, velocity_nis, vision_nis;
  int rows = 0;
  double pixel_noise = 1;  // relative to the assumed noise
};

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// 99.9 % of the means of n chi-square numbers are within dof ± 3.29 √(2 dof / n). linearization: additional
/// tolerance, relative to dof, because the measurement is linearized.
void expect_chi_square(const std::vector<double>& values, double dof, double linearization = 0) {
  const double spread = 3.29 * std::sqrt(2 * dof / static_cast<double>(values.size())) + linearization * dof;
  EXPECT_NEAR(mean(values), dof, spread);
}

TEST(Consistency, OverTwoHundredRunsErrorsAndInnovationsMatchTheirCovariances) {
  std::vector<double> nees, gyro, velocity, vision;
  double rows = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    World world(seed, 48);
    for (int k = 0; k < 30; ++k) world.step();
    ASSERT_GE(world.rows, 16);
    rows += world.rows / 200.0;
    nees.push_back(world.nees());
    gyro.push_back(world.gyro_nis.back());
    velocity.push_back(world.velocity_nis.back());
    vision.push_back(world.vision_nis.back());
  }
  expect_chi_square(nees, 12);
  expect_chi_square(gyro, 3);
  expect_chi_square(velocity, 3);
  expect_chi_square(vision, rows, 0.05);  // over a thousand runs they are 4 % too large
}

TEST(Consistency, TheInnovationsOfAFilterThatAssumesHalfTheNoiseAreTooLarge) {
  std::vector<double> vision;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    World world(seed, 48);
    world.pixel_noise = 2;
    for (int k = 0; k < 30; ++k) world.step();
    vision.push_back(world.vision_nis.back());
  }
  EXPECT_GT(mean(vision), 24 + 3.29 * std::sqrt(2 * 24 / 50.0));
}

TEST(Consistency, NoUpdateAddsUncertaintyAndTheCovarianceStaysValidForTenMinutes) {
  World world(3, 48);
  world.options.plan_velocity.sigma_sway_m_s = 0.04;
  world.options.plan_velocity.sigma_stride = 0.01;
  constexpr int kFrames = 10 * 60 * 30;
  for (int k = 0; k < kFrames; ++k) {  // once around in 28 s on a circle of 0.75 m
    const double angle = 2 * 3.14159265358979 / 28 * kDt_s * k, speed = 2 * 3.14159265358979 / 28;
    const Eigen::Vector4d turn = quaternion_exp({0, 0, angle});
    world.truth.segment<3>(kPosition) << 0.75 * std::sin(angle), 0.75 - 0.75 * std::cos(angle), 1.4;
    world.truth.segment<4>(kOrientation) = quaternion_product(turn, looking_ahead().segment<4>(kOrientation));
    world.truth.segment<3>(kVelocity) << 0.75 * speed * std::cos(angle), 0.75 * speed * std::sin(angle), 0;
    world.truth.segment<3>(kRate) << 0, -speed, 0;
    const int size = world.kalman.state().size;
    world.follow();
    if (k % 300 != 0) continue;
    ASSERT_TRUE(world.kalman.is_valid(size)) << k;
    const Eigen::VectorXd before = world.kalman.state().storage_P.diagonal().head(size);
    world.see();
    const Eigen::VectorXd after = world.kalman.state().storage_P.diagonal().head(size);
    EXPECT_LE((after - before).maxCoeff(), 1e-14) << k;  // the quaternion's normalization rounds
  }
  EXPECT_TRUE(world.kalman.is_valid(world.kalman.state().size));
  EXPECT_LT((world.kalman.state().position() - world.truth.segment<3>(kPosition)).norm(), 0.05);
}

}  // namespace
}  // namespace slam
