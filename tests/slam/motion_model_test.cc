#include "slam/motion_model.h"

#include <Eigen/Cholesky>

#include "slam/vision/visual_tracking.h"
#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

constexpr double kFrame = 1.0 / 30;

RobotVector reference_state() {
  RobotVector x = RobotVector::Zero();
  x.head<13>() << .1, -.2, 1.3, .9233805169, .1025978352, -.2051956704, .3077935056, .2, -.1, .05, .3, -.4,
      .5;
  return x;
}

Options paper() {
  Options options;
  options.motion = {4, 6};
  options.plan_velocity.sigma_sway_m_s = options.plan_velocity.sigma_stride = 0;
  options.accelerometer.sigma_bias_walk_m_s3 = options.height.sigma_lasting_m = 0;
  options.leg_odometry.sigma_position_m = 0;
  return options;
}

TEST(MotionModel, MovesTheReferenceStateAsPublished) {
  const Prediction p = predict_motion(reference_state(), kFrame, std::nullopt, paper());
  Eigen::Matrix<double, 7, 1> expected;
  expected << .1066666667, -.2033333333, 1.3016666667, .9188705907, .107549491, -.2106531788, .3158087757;
  EXPECT_NEAR((p.x.head<7>() - expected).norm(), 0, 2e-10);  // digits of the reference
  EXPECT_EQ((p.x.segment<6>(kVelocity)), (reference_state().segment<6>(kVelocity)));
}

TEST(MotionModel, FinalVelocityAndRateAreTheMeansOverTheInterval) {
  const RobotVector x = reference_state();
  const RobotVector y =
      predict_motion(x, kFrame, VelocityIncrement{{0.1, 0.2, 0.3}, kFrame, 0.01}, paper()).x;
  const Eigen::Vector3d moved = y.segment<3>(kPosition) - x.segment<3>(kPosition);
  EXPECT_NEAR((moved / kFrame - y.segment<3>(kVelocity)).norm(), 0, 1e-13);
  Eigen::Vector4d back = x.segment<4>(kOrientation);
  back.tail<3>() *= -1;
  const Eigen::Vector4d dq = quaternion_product(back, y.segment<4>(kOrientation)).normalized();
  EXPECT_LT((quaternion_log(dq) / kFrame - y.segment<3>(kRate)).norm(), 1e-9);  // q has 10 digits
}

TEST(MotionModel, IsDrivenByTheGyroWithoutItsBias) {
  const RobotVector x = generic_state();
  const MeanRate rate{{0.3, -0.1, 0.2}, 0.004};
  const Prediction p = predict_motion(x, kFrame, std::nullopt, paper(), rate);
  EXPECT_LT((p.x.segment<3>(kRate) - (rate.w_C - x.segment<3>(kGyroBias))).norm(), 1e-15);
  EXPECT_NEAR(std::sqrt(p.Q(kRate, kRate)), 0.005, 1e-12);
}

TEST(MotionModel, NoiseIsThatOfTheImpulsesPropagatedByTheirDerivatives) {
  for (const double turning : {1.0, 0.0}) {
    RobotVector x = generic_state();
    x.segment<3>(kRate) *= turning;
    const auto f = [&](const Eigen::VectorXd& n) -> Eigen::VectorXd {  // an impulse acts before the motion
      RobotVector pushed = x;
      pushed.segment<3>(kVelocity) += n.head<3>();
      pushed.segment<3>(kRate) += n.tail<3>();
      return predict_motion(pushed, kFrame, std::nullopt, paper()).x;
    };
    const Eigen::MatrixXd G = numerical_jacobian(f, Eigen::VectorXd::Zero(6));
    Eigen::VectorXd sigma(6);
    sigma << 4, 4, 4, 6, 6, 6;
    const Eigen::MatrixXd root = G * (kFrame * sigma).asDiagonal();
    const RobotMatrix Q = predict_motion(x, kFrame, std::nullopt, paper()).Q;
    EXPECT_LT((Q - root * root.transpose()).norm(), 1e-8);  // central differences of 1e-6
  }
}

TEST(MotionModel, AccelerometerAtRestCancelsGravity) {
  RobotVector x = RobotVector::Zero();
  x.segment<4>(kOrientation) = Eigen::Vector4d(0.9, 0.1, -0.2, 0.3).normalized();
  const Eigen::Matrix3d R_WC = rotation_matrix(x.segment<4>(kOrientation));
  const VelocityIncrement at_rest{R_WC.transpose() * Eigen::Vector3d(0, 0, 9.81) * kFrame, kFrame, 0.01};
  EXPECT_LT((predict_motion(x, kFrame, at_rest, paper()).x - x).norm(), 1e-15);
}

TEST(MotionModel, DoesNotDependOnTheSignOfTheQuaternion) {
  RobotVector flipped = generic_state();
  flipped.segment<4>(kOrientation) *= -1;
  const VelocityIncrement increment{{0.02, -0.33, 0.05}, kFrame, 0.001};
  RobotVector x = predict_motion(flipped, kFrame, increment, Options()).x;
  x.segment<4>(kOrientation) *= -1;
  EXPECT_EQ(x, predict_motion(generic_state(), kFrame, increment, Options()).x);
}

TEST(MotionModel, SwayingIsStationaryWithTheStandardDeviationOfTheOptions) {
  Options options = paper();
  options.plan_velocity.sigma_sway_m_s = 0.03;
  const double omega = 6.2831853 / options.plan_velocity.sway_period_s;
  const Prediction p = predict_motion(generic_state(), kFrame, std::nullopt, options);
  const std::array at{kSwayVelocity, kSwayPosition};
  const Eigen::Matrix2d F = p.F(at, at), Q = p.Q(at, at);
  Eigen::Matrix2d P = Eigen::Matrix2d::Zero();
  for (int k = 0; k < 30 * 60; ++k) P = F * P * F.transpose() + Q;
  // The discrete oscillation differs from the continuous one by ω dt/2 = 7 % and 1/(2 ω τ) = 13 %.
  EXPECT_NEAR(std::sqrt(P(0, 0)), 0.03, 0.1 * 0.03);
  EXPECT_NEAR(std::sqrt(P(1, 1)), 0.03 / omega, 0.15 * 0.03 / omega);
  const Eigen::Matrix2d later = F * P * F.transpose() + Q;
  EXPECT_LT((later - P).norm(), 1e-9 * P.norm());  // no part of P grows with time
  EXPECT_LT((sway_sigma(options.plan_velocity) - Eigen::Vector3d(0.03, 0.0045, 0.018)).norm(), 1e-17);
}

TEST(MotionModel, BiasesWalkAndLastingErrorsReachTheVarianceOfTheOptionsWhateverTheStep) {
  Options options;
  options.plan_velocity.sigma_stride = options.plan_velocity.sigma_sway_scale = 0.05;
  options.height = {true, 1, 0.05, 30};
  options.gyro.sigma_bias_walk_rad_s2 = 0.003;
  options.accelerometer.sigma_bias_walk_m_s3 = 0.02;
  for (const double dt : {0.01, 0.5}) {
    const Prediction p = predict_motion(generic_state(), dt, std::nullopt, options);
    EXPECT_NEAR(p.Q(kGyroBias + 1, kGyroBias + 1) / dt, 0.003 * 0.003, 1e-17);
    EXPECT_NEAR(p.Q(kAccelerometerBias, kAccelerometerBias) / dt, 0.02 * 0.02, 1e-17);
    for (const int at : {kStrideError, kStrideError + 1, kSwayScale, kSwayScale + 1, kHeightError}) {
      EXPECT_NEAR(p.x(at), generic_state()(at) * std::exp(-dt / 30), 1e-15);
      const double variance = 0.05 * 0.05;  // a fixed point of variance <- decay² variance + noise
      EXPECT_NEAR(p.F(at, at) * p.F(at, at) * variance + p.Q(at, at), variance, 1e-17);
    }
  }
}

const Eigen::Isometry3d kStart = pose(0.7, {1, -2, 2}, {1, 2, 3});

TEST(InitialState, IsAtRestAtTheGivenPoseWithTheStandardDeviationsOfTheOptions) {
  Options options;
  options.start = {0.1, 0.2, 0.3, 0.4};
  options.gyro.sigma_bias_rad_s = 0.5;
  options.accelerometer.sigma_bias_m_s2 = 0.6;
  options.plan_velocity.sigma_stride = 0.8;
  const RobotState initial = initial_state(kStart, options);
  EXPECT_EQ(initial.x.head<3>(), Eigen::Vector3d(1, 2, 3));
  EXPECT_LT((camera_pose(initial.x).linear() - kStart.linear()).norm(), 1e-15);
  EXPECT_EQ(initial.x.tail<kRobot - kVelocity>().norm(), 0);
  const RobotVector sigma = initial.P.diagonal().cwiseSqrt();
  const std::map<int, double> expected{{kPosition, 0.1}, {kVelocity, 0.3},          {kRate, 0.4},
                                       {kGyroBias, 0.5}, {kAccelerometerBias, 0.6}, {kStrideError, 0.8}};
  for (const auto& [at, value] : expected) EXPECT_NEAR(sigma(at), value, 1e-15) << at;
  EXPECT_NEAR(sigma(kLegError), options.leg_odometry.sigma_position_m, 1e-15);
  EXPECT_NEAR(sigma(kSwayVelocity), options.plan_velocity.sigma_sway_m_s, 1e-15);
  const double omega = 2 * 3.14159265358979 / options.plan_velocity.sway_period_s;
  EXPECT_NEAR(sigma(kSwayPosition), options.plan_velocity.sigma_sway_m_s / omega, 1e-15);
  const Eigen::Vector4d q = initial.x.segment<4>(kOrientation);
  const Eigen::Matrix4d P = initial.P.block<4, 4>(kOrientation, kOrientation);
  EXPECT_LT((P * q).norm(), 1e-16);                  // varies by rotations only
  EXPECT_NEAR(P.trace(), 3 * 0.2 * 0.2 / 4, 1e-15);  // |∂q/∂θ| = 1/2 about each axis
}

/// Truth and noise are drawn from the filter's own models, so errors and innovations must match their
/// covariances.
Options options_of_the_test() {
  Options options;
  options.start.sigma_position_m = options.start.sigma_orientation_rad = 0.01;
  options.motion.sigma_acceleration_m_s2 = options.motion.sigma_angular_acceleration_rad_s2 = 1;
  options.gyro.sigma_bias_rad_s = 0;
  options.plan_velocity.sigma_sway_m_s = options.plan_velocity.sigma_stride = 0;
  options.plan_velocity.pivots_on_foot = false;
  options.leg_odometry.sigma_position_m = 0.003;  // 0.13 m/s in a frame
  return options;
}

/// A robot, the landmarks around it, and the filter that follows it.
struct World {
  explicit World(std::uint64_t seed) : normal(seed) {
    truth.segment<3>(kPosition) += vector(0.01);
    truth.segment<4>(kOrientation) =
        quaternion_product(truth.segment<4>(kOrientation), quaternion_exp(vector(0.01)));
    truth.segment<3>(kVelocity) = vector(options.start.sigma_velocity_m_s);
    truth.segment<3>(kLegError) = vector(options.leg_odometry.sigma_position_m);
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
    truth.segment<3>(kVelocity) += vector(options.motion.sigma_acceleration_m_s2 * kFrame);
    truth.segment<3>(kRate) += vector(options.motion.sigma_angular_acceleration_rad_s2 * kFrame);
    truth = predict_motion(truth, kFrame, std::nullopt, options).x;
    const Prediction p = predict_motion(kalman.state().robot(), kFrame, std::nullopt, options);
    kalman.predict(p.x, p.F, p.Q);
    const MeanRate rate{truth.segment<3>(kRate) + vector(0.01), 0.01};
    update({measure_rate(kalman.state().robot(), rate)}, gyro);
    truth.segment<3>(kLegError) = vector(options.leg_odometry.sigma_position_m);
    const Eigen::Vector3d by_positions =
        (truth.segment<3>(kLegError) - truth.segment<3>(kPreviousLegError)) / kFrame;
    const Eigen::Vector3d v_C =
        camera_pose(truth).linear().transpose() * truth.segment<3>(kVelocity) + vector(0.05) + by_positions;
    const PlannedVelocity planned{v_C, {0, 0, 0}, {0, 0, 0}, v_C, 0.05, 0, kFrame};
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
  int rows = 0;                               // rows of its matches
};

/// 99.9 % of the means of n chi-square numbers are within dof ± 3.29 √(2 dof / n). linearization: additional
/// tolerance, relative to dof, because the measurement is linearized.
void expect_chi_square(const std::vector<double>& values, double dof, double linearization = 0) {
  const auto n = static_cast<double>(values.size());
  EXPECT_NEAR(std::accumulate(values.begin(), values.end(), 0.0) / n, dof,
              3.29 * std::sqrt(2 * dof / n) + linearization * dof);
}

TEST(Consistency, ErrorsAndInnovationsMatchTheirCovariancesOverTwoHundredRuns) {
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
  expect_chi_square(vision, rows, 0.05);  // the mean of 1000 runs is 4 % too large
}

}  // namespace
}  // namespace slam
