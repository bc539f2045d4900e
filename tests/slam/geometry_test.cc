#include "slam/motion_model.h"
#include "slam/vision/landmark.h"
#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

/// The camera of the published MonoSLAM code.
CameraIntrinsics reference() { return {320, 240, 195, 195, 162, 125, OneParameterRadial{9e-6}}; }

TEST(Camera, ProjectsTheReferencePointWithTheReferenceJacobian) {
  const auto p = Camera(reference()).project({0.4, -0.3, 2.0});
  ASSERT_TRUE(p);
  Matrix23d J;
  J << 92.9723824473, 1.8800947213, -18.3124622813, 1.8800947213, 94.0691043680, 13.7343467110;
  EXPECT_LT((p->pixel - Eigen::Vector2d(200.1916701636, 96.3562473773)).norm(), 1e-9);  // its digits
  EXPECT_NEAR((p->J - J).norm(), 0, 1e-9);
}

// Values from the formulas in OpenCV's manual, computed independently.
TEST(Camera, BrownsLensAndTheEquidistantOneProjectAsOpenCvDefinesThem) {
  const Eigen::Vector2d brown(576.385155769302, 123.276240971480),
      fisheye(402.426039072004, 163.183429681452);
  EXPECT_LT((Camera(kBrown).project({1, -0.6, 2})->pixel - brown).norm(), 1e-9);
  EXPECT_LT((Camera(kFisheye).project({2.2, -1.4, 2})->pixel - fisheye).norm(), 1e-9);
}

TEST(Camera, UnprojectIsTheExactInverseOfProject) {
  for (const CameraIntrinsics& intrinsics : {CameraIntrinsics{}, kBrown, kFisheye}) {
    const Camera camera(intrinsics);
    for (const double x : {-1.0, -0.2, 0.0, 0.7})
      for (const double y : {-0.7, 0.0, 0.6}) {
        const double length = x < 0 ? 3e-9 : 3e9;  // any
        const auto p = camera.project(length * Eigen::Vector3d(x, y, 1));
        ASSERT_TRUE(p);
        EXPECT_NEAR((camera.unproject(p->pixel)->h - Eigen::Vector3d(x, y, 1)).norm(), 0, 1e-13);
      }
  }
}

TEST(Camera, DoesNotSeeAPointBeyondTheFoldOfItsLens) {
  CameraIntrinsics folding = kBrown;
  folding.lens = RadialTangential{-0.3, 0, 0, 0};  // r (1 - 0.3 r²) is largest at r = 1.054
  const Camera camera(folding);
  EXPECT_TRUE(camera.project({1.05, 0, 1}));
  EXPECT_FALSE(camera.project({1.06, 0, 1}));
  EXPECT_FALSE(camera.project({1.8, 0, 1}));  // would land in the middle of the image
  EXPECT_FALSE(camera.unproject({367.215 + 458.654 * 0.71, 248.375}));  // the largest image is at 0.7027
}

TEST(Camera, ReturnsNothingForNanAndForPointsBehindOrInItsPlaneOrOutsideTheImageCircle) {
  const Camera camera(CameraIntrinsics{});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Eigen::Vector3d& h :
       {Eigen::Vector3d(1, 1, nan), {nan, 1, 1}, {0.1, 0.2, -1}, {1, 0, 0}, {0, 0, 0}})
    EXPECT_FALSE(camera.project(h)) << h.transpose();
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(nan, 1), {1000, 1000}})
    EXPECT_FALSE(camera.unproject(pixel)) << pixel.transpose();
}

TEST(Camera, NoiseGrowsLinearlyToTwiceItsSizeFromTheCenterToTheCorner) {
  const Camera camera(reference());
  EXPECT_DOUBLE_EQ(camera.sigma({162, 125}, 0.7), 0.7);
  EXPECT_DOUBLE_EQ(camera.sigma({81, 62.5}, 0.7), 1.05);
  EXPECT_DOUBLE_EQ(camera.sigma({0, 0}, 0.7), 1.4);
}

TEST(Camera, RejectsInvalidLenses) {
  CameraIntrinsics bad;
  bad.fu_px = 0;
  EXPECT_THROW(Camera{bad}, std::invalid_argument);
  for (const Lens& lens : {Lens(OneParameterRadial{-1e-6}), Lens(RadialTangential{-1000, 0, 0, 0}),
                           Lens(Equidistant{std::numeric_limits<double>::quiet_NaN(), 0, 0, 0})})
    EXPECT_THROW(Camera({320, 240, 197, 195, 157, 127, lens}), std::invalid_argument) << lens.index();
}

TEST(Camera, InsideCountsTheMarginOnEverySide) {
  const Camera camera(CameraIntrinsics{});
  EXPECT_TRUE(camera.inside({7, 7}, 7));
  EXPECT_TRUE(camera.inside({312, 232}, 7));
  for (const Eigen::Vector2d& out : {Eigen::Vector2d(6.9, 100), {312.1, 100}, {100, 6.9}, {100, 232.1}})
    EXPECT_FALSE(camera.inside(out, 7)) << out.transpose();
}

TEST(Rotation, ExponentialLogarithmAndMatrixAgreeWithEigen) {
  for (const double scale : {1.0, 1e-3, 1e-9, 0.0}) {
    const Eigen::Vector3d theta = scale * Eigen::Vector3d(0.3, -0.7, 1.1);
    const Eigen::Vector4d q = quaternion_exp(theta);
    const Eigen::Quaterniond expected(Eigen::AngleAxisd(theta.norm(), theta.stableNormalized()));
    EXPECT_NEAR((q - Eigen::Vector4d(expected.w(), expected.x(), expected.y(), expected.z())).norm(), 0,
                1e-15);
    EXPECT_NEAR((rotation_matrix(q) - expected.toRotationMatrix()).norm(), 0, 1e-15);
    EXPECT_NEAR((quaternion_log(q) - theta).norm(), 0, 1e-15);
    EXPECT_NEAR((quaternion_log(-q) - theta).norm(), 0, 1e-15);
  }
}

using Eigen::MatrixXd, Eigen::VectorXd;

constexpr double kFrame_s = 1.0 / 30;
const Eigen::Vector4d kQ(0.9, 0.1, -0.2, 0.3);  // not quite unit: the derivatives are valid off the sphere
const Eigen::Vector3d kA(0.4, -1.2, 2.5);
const RobotVector kState = generic_state();
const Eigen::Vector2d kNone(0, 0);

/// Expects that J is the derivative of f at x. tolerance: rounding of 1e-16 over a step of 1e-6, for values
/// up to 10.
template <typename Function>
void expect_derivative(const char* name, const VectorXd& x, const MatrixXd& J, const Function& f,
                       double tolerance = 1e-7) {
  const MatrixXd numeric = numerical_jacobian(f, x);
  ASSERT_EQ(J.size(), numeric.size()) << name;
  EXPECT_LT((J - numeric).norm(), tolerance) << name << " at " << x.transpose();
}

TEST(Jacobians, OfRotationsMatchNumericalDerivatives) {
  for (const double scale : {1.0, 1e-2, 1e-7, 0.0}) {
    const Eigen::Vector3d theta = scale * Eigen::Vector3d(0.3, -0.7, 1.1);
    expect_derivative("exponential", theta, quaternion_exp_jacobian(theta), quaternion_exp);
  }
  const Eigen::Vector4d b(0.2, 0.7, -0.1, 0.6);
  expect_derivative("R(q) a", kQ, rotated_jacobian(kQ, kA),
                    [](const auto& q) -> VectorXd { return rotation_matrix(q) * kA; });
  expect_derivative("transposed R(q) a", kQ, rotated_back_jacobian(kQ, kA),
                    [](const auto& q) -> VectorXd { return rotation_matrix(q).transpose() * kA; });
  expect_derivative("a x b by b", b, left_matrix(kQ),
                    [](const auto& x) { return quaternion_product(kQ, x); });
  expect_derivative("a x b by a", kQ, right_matrix(b),
                    [b](const auto& x) { return quaternion_product(x, b); });
  expect_derivative("q / |q|", kQ, normalized_jacobian(kQ), [](const auto& q) { return q.normalized(); });
  expect_derivative("small rotation", Eigen::Vector3d::Zero(), small_rotation_jacobian(kQ),
                    [](const auto& t) { return quaternion_product(kQ, quaternion_exp(t)); });
}

TEST(Jacobians, OfTheMotionModelMatchNumericalDerivatives) {
  const VelocityIncrement measured{{0.02, -0.33, 0.05}, kFrame_s, 0.001};
  for (const auto& increment : {std::optional<VelocityIncrement>{}, std::optional{measured}})
    for (const auto& rate : {std::optional<MeanRate>{}, std::optional{MeanRate{{0.3, -0.1, 0.2}, 0.004}}})
      for (const double turning : {1.0, 1e-6, 0.0}) {
        RobotVector x = kState;
        x.segment<3>(kRate) *= turning;
        const auto predict = [&](const auto& at) {
          return predict_motion(at, kFrame_s, increment, {}, rate);
        };
        expect_derivative("motion", x, predict(x).F, [&](const auto& at) { return predict(at).x; });
      }
}

template <typename Measure>
void expect_measurement(const char* name, const Measure& measure) {
  expect_derivative(name, kState, measure(kState).H_robot,
                    [&](const auto& x) -> VectorXd { return -measure(x).innovation; });
}

TEST(Jacobians, OfInternalMeasurementsMatchNumericalDerivatives) {
  expect_measurement("rate", [](const auto& x) { return measure_rate(x, {kA, 0.02}); });
  expect_measurement("rest", [](const auto& x) { return measure_rate(x, {kA, 0.02}, false); });
  expect_measurement("command", [](const auto& x) { return measure_command(x, {0.3, -0.1}, {}); });
  expect_measurement("height", [](const auto& x) { return measure_height(x, 1.5, {}); });
  PlannedVelocity planned{{0.2, -0.1, 0.05}, {0.1, 0.3, -0.2}, {0.1, 1.3, -0.2}, {0.15, 0.05, 0.2}};
  planned.between_positions_s = kFrame_s;
  for (const auto axes : {VelocityAxes::robot, VelocityAxes::plan})
    for (const bool pivots : {true, false}) {
      Options::PlanVelocity options;
      options.axes = axes, options.pivots_on_foot = pivots;
      expect_measurement("velocity", [&](const auto& x) { return measure_velocity(x, planned, options); });
    }
}

TEST(Jacobians, OfCamerasMatchNumericalDerivatives) {
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
        const auto project = [&](const auto& at) { return camera.project(at)->pixel; };
        const auto unproject = [&](const auto& at) { return camera.unproject(at)->h; };
        expect_derivative("pixel", h, J, project, 1e-6 * J.norm());
        expect_derivative("ray", pixel, ray.J, unproject, 1e-6);  // px: rounding, 1e-13/1e-6, with a margin
      }
}

TEST(Jacobians, OfLandmarksMatchNumericalDerivatives) {
  const Eigen::Vector3d from(0.5, -0.2, 1.3);
  Parameters point(3), other(6);
  point << 4, 0.7, 1.9;
  other << 0.4, -0.3, 1.4, 0.2, 0.1, 0.25;
  for (const LandmarkKind& kind :
       std::vector<LandmarkKind>{Point{}, InverseDepth{}, SemiInfiniteLine{{{2, 0.5}, {4, 0.5}}}}) {
    const Parameters y = std::holds_alternative<Point>(kind) ? point : other;
    const Direction d = direction(kind, y, from, kQ);
    expect_derivative("h by r", from, d.J_r, [&](const auto& r) { return direction(kind, y, r, kQ).h_C; });
    expect_derivative("h by q", kQ, d.J_q, [&](const auto& q) { return direction(kind, y, from, q).h_C; });
    expect_derivative("h by y", y, d.J_y, [&](const auto& at) { return direction(kind, at, from, kQ).h_C; });
    expect_derivative("p by y", y, position_jacobian(kind, y),
                      [&](const auto& at) { return position(kind, at); });
  }
  const Ray ray = Camera(CameraIntrinsics{}).unproject({50, 200}).value();
  const auto by_depth = [&](const auto& x) { return initialize_inverse_depth(x, ray, 1, kNone, {}); };
  const auto line = [&](const auto& x) { return initialize_line(x, ray, 1); };
  expect_derivative("new", kState, by_depth(kState).J_robot, [&](const auto& x) { return by_depth(x).y; });
  expect_derivative("new line", kState, line(kState).J_robot, [&](const auto& x) { return line(x).y; });
}

/// The covariance of a landmark's parameters due to the noise of its pixel is J Jᵀ.
TEST(Jacobians, OfANewLandmarkGiveItsNoiseFromThatOfItsPixel) {
  const Camera camera{CameraIntrinsics{}};
  const Eigen::Vector2d pixel(50, 200);
  Options::Depth options;
  options.sigma_inverse_1_m = 0.4;
  const auto check = [&](const auto& initialized) {
    const MatrixXd J = numerical_jacobian([&](const auto& p) { return initialized(p).y; }, pixel, 1e-4);
    MatrixXd expected = 1.5 * 1.5 * J * J.transpose();
    if (J.row(5).norm() == 0) expected(5, 5) += 0.16;  // the inverse depth, which is independent of the pixel
    EXPECT_LT((initialized(pixel).noise - expected).norm(), 1e-10);  // slopes 5e-3 per px
  };
  check([&](const auto& p) {
    return initialize_inverse_depth(kState, *camera.unproject(p), 1.5, kNone, options);
  });
  check([&](const auto& p) {
    return initialize_inverse_depth(kState, *camera.unproject(p), 1.5, kNone, options, MeasuredDepth{0.5, 0});
  });
  check([&](const auto& p) { return initialize_line(kState, *camera.unproject(p), 1.5); });
}

TEST(Jacobians, OfTheDistortionMatchALensWithAWrongParameter) {
  const Eigen::Vector2d pixel(50, 200);
  const auto initialized = [&](const auto& delta) -> VectorXd {
    CameraIntrinsics wrong;
    wrong.lens = OneParameterRadial{std::get<OneParameterRadial>(wrong.lens).k1_px2 * (1 + delta(0))};
    return initialize_inverse_depth(kState, *Camera(wrong).unproject(pixel), 1, kNone, {}).y;
  };
  const Camera camera{CameraIntrinsics{}};
  const auto ray = camera.unproject(pixel);
  const LandmarkInitialization b =
      initialize_inverse_depth(kState, *ray, 1, camera.displacement(ray->h, pixel), {});
  const VectorXd numeric = numerical_jacobian(initialized, VectorXd::Zero(1), 1e-4);
  // The displacement is not linear in the lens's parameter: 30 % here. Only sign and axis matter.
  EXPECT_GT(b.distortion.dot(numeric) / (b.distortion.norm() * numeric.norm()), 0.999);
  EXPECT_NEAR(b.distortion.norm() / numeric.norm(), 1, 0.35);
}

}  // namespace
}  // namespace slam
