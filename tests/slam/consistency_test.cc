// With truth and noise drawn from the filter's models, errors and innovations match their covariances.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <numeric>

#include "slam/motion_model.h"
#include "slam/vision/visual_tracking.h"
#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

constexpr double kDt_s = 1.0 / 30;

Options options_of_the_test() {
  Options options;
  options.start.sigma_position_m = options.start.sigma_orientation_rad = 0.01;
  options.motion.sigma_acceleration_m_s2 = options.motion.sigma_angular_acceleration_rad_s2 = 1;
  options.gyro.sigma_bias_rad_s = 0;
  options.plan_velocity.sigma_sway_m_s = options.plan_velocity.sigma_stride = 0;
  options.plan_velocity.pivots_on_foot = false;
  return options;
}

/// A robot, the landmarks around it, and the filter that follows it.
struct World {
  explicit World(std::uint64_t seed) : normal(seed) {
    truth.segment<3>(kPosition) += vector(0.01);
    truth.segment<4>(kOrientation) =
        quaternion_product(truth.segment<4>(kOrientation), quaternion_exp(vector(0.01)));
    truth.segment<3>(kVelocity) = vector(options.start.sigma_velocity_m_s);
    truth.segment<3>(kRate) = vector(options.start.sigma_rate_rad_s);
    for (int i = 0; i < 48; ++i) {
      const double angle = 2 * 3.14159265358979 * i / 48, away = 3 + i % 3;
      const Eigen::Vector3d p(away * std::cos(angle), away * std::sin(angle), 0.6 + 0.35 * (i % 5));
      Landmark landmark;
      landmark.id = i;
      landmark.kind = Point{};
      landmark.at = kalman.append_point(p, 0.02);
      landmark.X_WC_first = pose(angle, {0, 0, 1}, {0, 0, 0}) * camera_pose(looking_ahead());
      map.push_back(landmark);
      places.push_back(p + vector(0.02));
    }
  }

  Eigen::Vector3d vector(double sigma) { return sigma * random_matrix(3, 1, normal); }

  /// One frame: the truth moves by unknown accelerations, the filter predicts and measures.
  void step() {
    truth.segment<3>(kVelocity) += vector(options.motion.sigma_acceleration_m_s2 * kDt_s);
    truth.segment<3>(kRate) += vector(options.motion.sigma_angular_acceleration_rad_s2 * kDt_s);
    truth = predict_motion(truth, kDt_s, std::nullopt, options).x;
    const Prediction p = predict_motion(kalman.state().robot(), kDt_s, std::nullopt, options);
    kalman.predict(p.x, p.F, p.Q);
    const MeanRate rate{truth.segment<3>(kRate) + vector(0.01), 0.01};
    update({measure_rate(kalman.state().robot(), rate)}, gyro);
    const Eigen::Vector3d v_C =
        camera_pose(truth).linear().transpose() * truth.segment<3>(kVelocity) + vector(0.05);
    const PlannedVelocity planned{v_C, {0, 0, 0}, {0, 0, 0}, v_C, 0.05};
    update({measure_velocity(kalman.state().robot(), planned, options.plan_velocity)}, velocity);
    see();
  }

  /// Measures at most 12 of the landmarks in view, as pixels with the assumed noise of the camera.
  void see() {
    std::vector<Measurement> found;
    auto view = predict_view(kalman, map, camera, options.vision.sigma_px);
    keep_most_informative(view, 12);
    for (Candidate& candidate : view) {
      const auto seen = camera.project(camera_pose(truth).inverse() * places[candidate.index]);
      if (!seen) continue;
      const double sigma = camera.sigma(candidate.pixel, options.vision.sigma_px);
      candidate.measurement.innovation = seen->pixel + vector(sigma).head<2>() - candidate.pixel;
      found.push_back(candidate.measurement);
    }
    update(found, vision);
  }

  void update(const std::vector<Measurement>& measurements, double& nis) {
    StackedMeasurement stacked;
    stack(kalman.state(), measurements, stacked);
    nis = stacked.innovation().dot(Eigen::MatrixXd(stacked.S()).llt().solve(stacked.innovation()));
    rows = stacked.rows;
    ASSERT_TRUE(kalman.update(stacked));
  }

  double pose_nees() const {
    const Estimate estimate = pose_estimate(kalman.state(), Stamp(0));
    const Eigen::Isometry3d X_WC = camera_pose(truth);
    const Eigen::AngleAxisd turn(estimate.X_WC.linear().transpose() * X_WC.linear());
    Vector6d error;
    error << turn.angle() * turn.axis(), X_WC.translation() - estimate.X_WC.translation();
    return error.dot(estimate.covariance.llt().solve(error));
  }

  Options options = options_of_the_test();
  Camera camera{CameraIntrinsics{}};
  RobotVector truth = looking_ahead();
  Kalman kalman{initial_state(camera_pose(truth), options), false};
  std::vector<Landmark> map;
  std::vector<Eigen::Vector3d> places;
  Normal normal;
  double gyro = 0, velocity = 0, vision = 0;  // NIS of the last frame
  int rows = 0;                               // of its matches
};

/// 99.9 % of the means of n chi-square numbers are within dof ± 3.29 √(2 dof / n). linearization: additional
/// tolerance, relative to dof, because the measurement is linearized.
void expect_chi_square(const std::vector<double>& values, double dof, double linearization = 0) {
  const auto n = static_cast<double>(values.size());
  EXPECT_NEAR(std::accumulate(values.begin(), values.end(), 0.0) / n, dof,
              3.29 * std::sqrt(2 * dof / n) + linearization * dof);
}

TEST(Consistency, OverTwoHundredRunsErrorsAndInnovationsMatchTheirCovariances) {
  std::vector<double> nees, gyro, velocity, vision;
  double rows = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    World world(seed);
    for (int k = 0; k < 30; ++k) world.step();
    ASSERT_GE(world.rows, 16);
    rows += world.rows / 200.0;
    nees.push_back(world.pose_nees());
    gyro.push_back(world.gyro);
    velocity.push_back(world.velocity);
    vision.push_back(world.vision);
  }
  expect_chi_square(nees, 6);
  expect_chi_square(gyro, 3);
  expect_chi_square(velocity, 3);
  expect_chi_square(vision, rows, 0.05);  // over a thousand runs they are 4 % too large
}

}  // namespace
}  // namespace slam
