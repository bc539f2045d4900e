// Every analytic derivative of the filter against central differences, at generic states.
#include <gtest/gtest.h>

#include "slam/motion_model.h"
#include "slam/vision/landmark.h"
#include "tests/numerical_jacobian.h"
#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kFrame_s = 1.0 / 30;
const Eigen::Vector4d kQ(0.9, 0.1, -0.2, 0.3);  // not quite unit: the derivatives are valid off the sphere
const Eigen::Vector3d kA(0.4, -1.2, 2.5);
const RobotVector kState = generic_state();
const Eigen::Vector2d kNone(0, 0);

/// Expects that J is the derivative of f at x. tolerance: rounding 1e-16 / step 1e-6 of values up to 10.
template <typename Function>
void expect_derivative(const char* name, const VectorXd& x, const Function& f, const MatrixXd& J,
                       double tolerance = 1e-7) {
  const MatrixXd numeric = tests::numerical_jacobian(f, x);
  ASSERT_EQ(J.size(), numeric.size()) << name;
  EXPECT_LT((J - numeric).norm(), tolerance) << name << " at " << x.transpose();
}

TEST(Jacobians, OfRotationsAreTheDerivatives) {
  for (const double scale : {1.0, 1e-2, 1e-7, 0.0}) {
    const Eigen::Vector3d theta = scale * Eigen::Vector3d(0.3, -0.7, 1.1);
    expect_derivative("exponential", theta, quaternion_exp, quaternion_exp_jacobian(theta));
  }
  const auto back = [](const VectorXd& q) -> VectorXd { return rotation_matrix(q).transpose() * kA; };
  const Eigen::Vector4d b(0.2, 0.7, -0.1, 0.6);
  const auto small = [](const VectorXd& t) { return quaternion_product(kQ, quaternion_exp(t)); };
  expect_derivative(
      "R(q) a", kQ, [](const VectorXd& q) -> VectorXd { return rotation_matrix(q) * kA; },
      rotated_jacobian(kQ, kA));
  expect_derivative("transposed R(q) a", kQ, back, rotated_back_jacobian(kQ, kA));
  expect_derivative(
      "a x b by b", b, [](const VectorXd& x) { return quaternion_product(kQ, x); }, left_matrix(kQ));
  expect_derivative(
      "a x b by a", kQ, [b](const VectorXd& x) { return quaternion_product(x, b); }, right_matrix(b));
  expect_derivative(
      "q / |q|", kQ, [](const VectorXd& q) { return q.normalized(); }, normalized_jacobian(kQ));
  expect_derivative("small rotation", Eigen::Vector3d::Zero(), small, small_rotation_jacobian(kQ));
}

TEST(Jacobians, OfTheMotionModelAreTheDerivatives) {
  const VelocityIncrement measured{{0.02, -0.33, 0.05}, kFrame_s, 0.001};
  for (const auto& increment : {std::optional<VelocityIncrement>{}, std::optional{measured}})
    for (const double turning : {1.0, 1e-6, 0.0}) {
      RobotVector x = kState;
      x.segment<3>(kRate) *= turning;
      const auto predict = [&](const VectorXd& at) { return predict_motion(at, kFrame_s, increment, {}); };
      expect_derivative(
          "motion", x, [&](const VectorXd& at) { return predict(at).x; }, predict(x).F);
    }
}

template <typename Measure>
void expect_measurement(const char* name, const Measure& measure) {
  const auto h = [&](const VectorXd& x) -> VectorXd { return -measure(x).innovation; };
  expect_derivative(name, kState, h, measure(kState).H_robot);
}

TEST(Jacobians, OfInternalMeasurementsAreTheDerivatives) {
  expect_measurement("rate", [](const RobotVector& x) { return measure_rate(x, {kA, 0.02}); });
  expect_measurement("rest", [](const RobotVector& x) { return measure_rate(x, {kA, 0.02}, false); });
  expect_measurement("height", [](const RobotVector& x) { return measure_height(x, 1.5, {}); });
  const PlannedVelocity planned{{0.2, -0.1, 0.05}, {0.1, 0.3, -0.2}, {0.1, 1.3, -0.2}, {0.15, 0.05, 0.2}};
  for (const auto axes : {VelocityAxes::robot, VelocityAxes::plan})
    for (const bool pivots : {true, false}) {
      Options::PlanVelocity options;
      options.axes = axes, options.pivots_on_foot = pivots;
      expect_measurement("velocity",
                         [&](const RobotVector& x) { return measure_velocity(x, planned, options); });
    }
}

TEST(Jacobians, OfCamerasAreTheDerivatives) {
  CameraIntrinsics fisheye = kFisheye;
  fisheye.width_px = fisheye.height_px = 400,
  fisheye.u0_px = fisheye.v0_px = 199;  // the corners are in front of the image plane
  for (const CameraIntrinsics& intrinsics : {CameraIntrinsics{}, kBrown, fisheye})
    for (const double right : {0.003, 0.25, 0.49, 0.75, 0.99})
      for (const double down : {0.004, 0.53, 0.99}) {
        const Camera camera(intrinsics);
        const Eigen::Vector2d pixel(right * intrinsics.width_px, down * intrinsics.height_px);
        const Ray ray = camera.unproject(pixel).value();
        const Eigen::Vector3d h = 2.5 * ray.h;
        const Matrix23d J = camera.project(h)->J;
        expect_derivative(
            "pixel", h, [&](const VectorXd& at) { return camera.project(at)->pixel; }, J, 1e-6 * J.norm());
        // px: rounding of pixels, 1e-13/1e-6, with room
        expect_derivative(
            "ray", pixel, [&](const VectorXd& at) { return camera.unproject(at)->h; }, ray.J, 1e-6);
      }
}

TEST(Jacobians, OfLandmarksAreTheDerivatives) {
  const Eigen::Vector3d from(0.5, -0.2, 1.3);
  Parameters point(3), other(6);
  point << 4, 0.7, 1.9;
  other << 0.4, -0.3, 1.4, 0.2, 0.1, 0.25;
  for (const LandmarkKind& kind :
       std::vector<LandmarkKind>{Point{}, InverseDepth{}, SemiInfiniteLine{{{2, 0.5}, {4, 0.5}}}}) {
    const Parameters y = std::holds_alternative<Point>(kind) ? point : other;
    const Direction d = direction(kind, y, from, kQ);
    expect_derivative(
        "h by r", from, [&](const VectorXd& r) { return direction(kind, y, r, kQ).h_C; }, d.J_r);
    expect_derivative(
        "h by q", kQ, [&](const VectorXd& q) { return direction(kind, y, from, q).h_C; }, d.J_q);
    expect_derivative(
        "h by y", y, [&](const VectorXd& at) { return direction(kind, at, from, kQ).h_C; }, d.J_y);
    expect_derivative(
        "p by y", y, [&](const VectorXd& at) { return position(kind, at); }, position_jacobian(kind, y));
  }
  const Ray ray = Camera(CameraIntrinsics{}).unproject({50, 200}).value();
  const auto by_depth = [&](const VectorXd& x) { return initialize_inverse_depth(x, ray, 1, kNone, {}); };
  const auto line = [&](const VectorXd& x) { return initialize_line(x, ray, 1); };
  expect_derivative(
      "new", kState, [&](const VectorXd& x) { return by_depth(x).y; }, by_depth(kState).J_robot);
  expect_derivative(
      "new line", kState, [&](const VectorXd& x) { return line(x).y; }, line(kState).J_robot);
}

/// The covariance of a landmark's parameters by the noise of its pixel is J Jᵀ.
TEST(Jacobians, OfANewLandmarkByItsPixelMakeItsNoise) {
  const Camera camera{CameraIntrinsics{}};
  const Eigen::Vector2d pixel(50, 200);
  Options::Depth options;
  options.sigma_inverse_1_m = 0.4;
  const auto check = [&](const auto& initialized) {
    const MatrixXd J =
        tests::numerical_jacobian([&](const VectorXd& p) { return initialized(p).y; }, pixel, 1e-4);
    MatrixXd expected = 1.5 * 1.5 * J * J.transpose();
    if (J.row(5).norm() == 0) expected(5, 5) += 0.16;  // the inverse depth, which is independent of the pixel
    EXPECT_LT((initialized(pixel).noise - expected).norm(), 1e-10);  // slopes 5e-3 per px
  };
  check([&](const VectorXd& p) {
    return initialize_inverse_depth(kState, *camera.unproject(p), 1.5, kNone, options);
  });
  check([&](const VectorXd& p) { return initialize_line(kState, *camera.unproject(p), 1.5); });
}

TEST(Jacobians, OfTheDistortionAreThoseOfALensWithAWrongParameter) {
  const Eigen::Vector2d pixel(50, 200);
  const auto initialized = [&](const VectorXd& delta) -> VectorXd {
    CameraIntrinsics wrong;
    wrong.lens = OneParameterRadial{std::get<OneParameterRadial>(wrong.lens).k1_px2 * (1 + delta(0))};
    return initialize_inverse_depth(kState, *Camera(wrong).unproject(pixel), 1, kNone, {}).y;
  };
  const Camera camera{CameraIntrinsics{}};
  const auto ray = camera.unproject(pixel);
  const LandmarkInitialization b =
      initialize_inverse_depth(kState, *ray, 1, camera.displacement(ray->h, pixel), {});
  const VectorXd numeric = tests::numerical_jacobian(initialized, VectorXd::Zero(1), 1e-4);
  // The displacement is not linear in the lens's parameter: 30 % here. Sign and axis are what matters.
  EXPECT_GT(b.distortion.dot(numeric) / (b.distortion.norm() * numeric.norm()), 0.999);
  EXPECT_NEAR(b.distortion.norm() / numeric.norm(), 1, 0.35);
}

}  // namespace
}  // namespace slam
