// Every analytic derivative of the filter against central differences, at generic states.
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "slam/inertial.h"
#include "slam/motion_model.h"
#include "slam/plan.h"
#include "slam/vision/landmark.h"
#include "tests/numerical_jacobian.h"

namespace slam {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// An analytic Jacobian J at x of a function.
struct Derivative {
  std::string name;
  VectorXd x;
  std::function<VectorXd(const VectorXd&)> function;
  MatrixXd J;
  double tolerance = 1e-7;  // rounding 1e-16 / step 1e-6 of values up to 10, with room
};

constexpr double kFrame_s = 1.0 / 30;
const Eigen::Vector4d kQ(0.9, 0.1, -0.2, 0.3);  // not quite unit: the derivatives are valid off the sphere
const Eigen::Vector3d kA(0.4, -1.2, 2.5);

RobotVector generic_state() {
  RobotVector x = RobotVector::LinSpaced(-0.4, 0.9);
  x.segment<4>(kOrientation) = kQ.normalized();
  return x;
}

void add_rotations(std::vector<Derivative>& all) {
  for (const double scale : {1.0, 1e-2, 1e-7, 0.0}) {
    const Eigen::Vector3d theta = scale * Eigen::Vector3d(0.3, -0.7, 1.1);
    all.push_back({"exponential at " + std::to_string(scale), theta,
                   [](const VectorXd& t) -> VectorXd { return quaternion_exp(t); },
                   quaternion_exp_jacobian(theta)});
  }
  all.push_back({"R(q) a", kQ, [](const VectorXd& q) -> VectorXd { return rotation_matrix(q) * kA; },
                 rotated_jacobian(kQ, kA)});
  all.push_back({"transposed R(q) a", kQ,
                 [](const VectorXd& q) -> VectorXd { return rotation_matrix(q).transpose() * kA; },
                 rotated_back_jacobian(kQ, kA)});
  const Eigen::Vector4d b(0.2, 0.7, -0.1, 0.6);
  all.push_back({"a x b by b", b, [](const VectorXd& x) -> VectorXd { return quaternion_product(kQ, x); },
                 left_matrix(kQ)});
  all.push_back({"a x b by a", kQ, [b](const VectorXd& x) -> VectorXd { return quaternion_product(x, b); },
                 right_matrix(b)});
  all.push_back(
      {"q / |q|", kQ, [](const VectorXd& q) -> VectorXd { return q.normalized(); }, normalized_jacobian(kQ)});
  all.push_back({"small rotation", Eigen::Vector3d::Zero(),
                 [](const VectorXd& t) -> VectorXd { return quaternion_product(kQ, quaternion_exp(t)); },
                 small_rotation_jacobian(kQ)});
}

void add_motion_model(std::vector<Derivative>& all) {
  const VelocityIncrement measured{{0.02, -0.33, 0.05}, kFrame_s, 0.001};
  for (const auto& increment : {std::optional<VelocityIncrement>{}, std::optional{measured}})
    for (const double turning : {1.0, 1e-6, 0.0}) {
      RobotVector x = generic_state();
      x.segment<3>(kRate) *= turning;
      all.push_back(
          {"motion model", x,
           [=](const VectorXd& at) -> VectorXd { return predict_motion(at, kFrame_s, increment, {}).x; },
           predict_motion(x, kFrame_s, increment, {}).F});
    }
}

void add_measurement(std::vector<Derivative>& all, const std::string& name,
                     const std::function<Measurement(const RobotVector&)>& measure) {
  all.push_back({name, generic_state(),
                 [=](const VectorXd& at) -> VectorXd { return -measure(at).innovation; },
                 measure(generic_state()).H_robot});
}

void add_internal_measurements(std::vector<Derivative>& all) {
  add_measurement(all, "rate", [](const RobotVector& x) { return measure_rate(x, {kA, 0.02}); });
  add_measurement(all, "rest", [](const RobotVector& x) { return measure_rest(x, 0.02); });
  add_measurement(all, "height", [](const RobotVector& x) { return measure_height(x, 1.5, {}); });
  const PlannedVelocity planned{{0.2, -0.1, 0.05}, {0.1, 0.3, -0.2}, {0.1, 1.3, -0.2}, {0.15, 0.05, 0.2}};
  for (const auto axes : {VelocityAxes::robot, VelocityAxes::plan})
    for (const bool pivots : {true, false}) {
      Options::PlanVelocity options;
      options.axes = axes, options.pivots_on_foot = pivots;
      add_measurement(all, "velocity",
                      [=](const RobotVector& x) { return measure_velocity(x, planned, options); });
    }
}

/// The camera of the EuRoC flying robot, and the middle of a fisheye image: its corners are behind the image
/// plane.
const CameraIntrinsics kBrown{752,
                              480,
                              458.654,
                              457.296,
                              367.215,
                              248.375,
                              RadialTangential{-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}};
const CameraIntrinsics kFisheye{400, 400, 191, 191, 199, 199, Equidistant{-0.0027, 0.0019, -0.0016, 0.0002}};

void add_cameras(std::vector<Derivative>& all) {
  for (const CameraIntrinsics& intrinsics : {CameraIntrinsics{}, kBrown, kFisheye})
    for (const double right : {0.003, 0.25, 0.49, 0.75, 0.99})
      for (const double down : {0.004, 0.53, 0.99}) {
        const Camera camera(intrinsics);
        const Eigen::Vector2d pixel(right * intrinsics.width_px, down * intrinsics.height_px);
        const auto ray = camera.unproject(pixel).value();
        const Eigen::Vector3d h = 2.5 * ray.h;
        const Matrix23d J = camera.project(h)->J;
        all.push_back({"pixel", h, [=](const VectorXd& at) -> VectorXd { return camera.project(at)->pixel; },
                       J, 1e-6 * J.norm()});
        all.push_back({"ray", pixel, [=](const VectorXd& at) -> VectorXd { return camera.unproject(at)->h; },
                       ray.J, 1e-6});  // px: rounding of pixels, 1e-13/1e-6, with room
      }
}

Parameters parameters_of(const LandmarkKind& kind) {
  Parameters y(std::holds_alternative<Point>(kind) ? 3 : 6);
  if (std::holds_alternative<Point>(kind))
    y << 4, 0.7, 1.9;
  else
    y << 0.4, -0.3, 1.4, 0.2, 0.1, 0.25;
  return y;
}

void add_landmarks(std::vector<Derivative>& all) {
  const Eigen::Vector3d from(0.5, -0.2, 1.3);
  for (const LandmarkKind& kind :
       std::vector<LandmarkKind>{Point{}, InverseDepth{}, SemiInfiniteLine{{{2, 0.5}, {4, 0.5}}}}) {
    const Parameters y = parameters_of(kind);
    const Direction d = direction(kind, y, from, kQ);
    const auto h = [=](const Parameters& at, const Eigen::Vector3d& r, const Eigen::Vector4d& q) -> VectorXd {
      return direction(kind, at, r, q).h_C;
    };
    all.push_back({"direction by r", from, [=](const VectorXd& r) { return h(y, r, kQ); }, d.J_r});
    all.push_back({"direction by q", kQ, [=](const VectorXd& q) { return h(y, from, q); }, d.J_q});
    all.push_back({"direction by y", y, [=](const VectorXd& at) { return h(at, from, kQ); }, d.J_y});
    all.push_back({"position", y, [=](const VectorXd& at) -> VectorXd { return position(kind, at); },
                   position_jacobian(kind, y)});
  }
  for (const Eigen::Vector2d& angles : {Eigen::Vector2d(0.7, -0.2), {-2.9, 1.1}, {0, 0}})
    all.push_back({"bearing", angles, [](const VectorXd& a) -> VectorXd { return bearing(a(0), a(1)); },
                   bearing_jacobian(angles(0), angles(1))});
  const Ray ray = Camera(CameraIntrinsics{}).unproject({50, 200}).value();
  const Eigen::Vector2d none = Eigen::Vector2d::Zero();
  all.push_back(
      {"initialization by inverse depth", generic_state(),
       [=](const VectorXd& x) -> VectorXd { return initialize_inverse_depth(x, ray, 1, none, {}).y; },
       initialize_inverse_depth(generic_state(), ray, 1, none, {}).J_robot});
  all.push_back({"initialization of a line", generic_state(),
                 [=](const VectorXd& x) -> VectorXd { return initialize_line(x, ray, 1).y; },
                 initialize_line(generic_state(), ray, 1).J_robot});
}

TEST(Jacobians, AreTheDerivatives) {
  std::vector<Derivative> all;
  for (const auto add :
       {add_rotations, add_motion_model, add_internal_measurements, add_cameras, add_landmarks})
    add(all);
  for (const Derivative& d : all) {
    const MatrixXd numeric = tests::numerical_jacobian(d.function, d.x);
    ASSERT_EQ(d.J.size(), numeric.size()) << d.name;
    EXPECT_LT((d.J - numeric).norm(), d.tolerance) << d.name << " at " << d.x.transpose();
  }
}

/// The covariance of a landmark's parameters by the noise of its pixel is J Jᵀ.
TEST(Jacobians, OfANewLandmarkByItsPixelMakeItsNoise) {
  const Camera camera{CameraIntrinsics{}};
  const Eigen::Vector2d pixel(50, 200), none = Eigen::Vector2d::Zero();
  Options::Depth options;
  options.sigma_inverse_1_m = 0.4;
  const auto inverse_depth = [&](const VectorXd& p) {
    return initialize_inverse_depth(generic_state(), *camera.unproject(p), 1.5, none, options);
  };
  const auto line = [&](const VectorXd& p) {
    return initialize_line(generic_state(), *camera.unproject(p), 1.5);
  };
  for (const auto& initialized :
       {std::function<LandmarkInitialization(const VectorXd&)>(inverse_depth), {line}}) {
    const MatrixXd J = tests::numerical_jacobian(
        [&](const VectorXd& p) -> VectorXd { return initialized(p).y; }, pixel, 1e-4);
    MatrixXd expected = 1.5 * 1.5 * J * J.transpose();
    if (J.row(5).norm() == 0) expected(5, 5) += 0.16;  // the inverse depth, which is independent of the pixel
    EXPECT_LT((initialized(pixel).noise - expected).norm(), 1e-10);  // slopes 5e-3 per px
  }
}

TEST(Jacobians, OfTheDistortionAreThoseOfALensWithAWrongParameter) {
  const Eigen::Vector2d pixel(50, 200);
  const auto initialized = [&](const VectorXd& delta) -> VectorXd {
    CameraIntrinsics wrong;
    wrong.lens = OneParameterRadial{std::get<OneParameterRadial>(wrong.lens).k1_px2 * (1 + delta(0))};
    return initialize_inverse_depth(generic_state(), *Camera(wrong).unproject(pixel), 1,
                                    Eigen::Vector2d::Zero(), {})
        .y;
  };
  const Camera camera{CameraIntrinsics{}};
  const auto ray = camera.unproject(pixel);
  const LandmarkInitialization b =
      initialize_inverse_depth(generic_state(), *ray, 1, camera.displacement(ray->h, pixel), {});
  const VectorXd numeric = tests::numerical_jacobian(initialized, VectorXd::Zero(1), 1e-4);
  // The displacement is not linear in the lens's parameter: 30 % at this pixel. Sign and axis are what
  // matters.
  EXPECT_GT(b.distortion.dot(numeric) / (b.distortion.norm() * numeric.norm()), 0.999);
  EXPECT_NEAR(b.distortion.norm() / numeric.norm(), 1, 0.35);
}

}  // namespace
}  // namespace slam
