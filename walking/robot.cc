#include "walking/robot.h"

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>

namespace walking {
namespace {

using Eigen::Isometry3d, Eigen::Matrix3d, Eigen::Vector3d;
using Jacobian = Eigen::Matrix<double, 6, 6>;

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr int kMostSteps = 40;
constexpr double kLargestStep_rad = 0.5;
constexpr double kDamping = 0.01;  // factor on the squared error (m and rad)
constexpr double kLeastDamping = 1e-12;
constexpr double kLastStep = 1e-8;      // error (m and rad) whose square is below double precision
constexpr double kLeastFreedom = 1e-3;  // singular value of the leg's Jacobian, m/rad

Matrix3d turn(const Vector3d& axis, double angle) {
  const double s = std::sin(angle), c = std::cos(angle);
  const Vector3d a = (1 - c) * axis;
  Matrix3d R;
  R << a.x() * axis.x() + c, a.x() * axis.y() - s * axis.z(), a.x() * axis.z() + s * axis.y(),
      a.x() * axis.y() + s * axis.z(), a.y() * axis.y() + c, a.y() * axis.z() - s * axis.x(),
      a.x() * axis.z() - s * axis.y(), a.y() * axis.z() + s * axis.x(), a.z() * axis.z() + c;
  return R;
}

int joints_of(const Leg& leg) { return static_cast<int>(leg.joints.size()); }

/// The sole in the base, and its Jacobian: for each joint, the velocity and then the angular velocity.
struct Chain {
  Isometry3d X_BS;
  Jacobian J;
};

Chain chain(const Robot& robot, const Leg& leg, const LegVector& q) {
  Chain result;
  Matrix3d R = Matrix3d::Identity();
  Vector3d p = Vector3d::Zero();
  Eigen::Matrix<double, 3, 6> points;
  result.J.setZero();
  for (int i = 0; i < joints_of(leg); ++i) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(leg.joints[static_cast<std::size_t>(i)])];
    p += R * joint.offset;
    points.col(i) = p;
    result.J.block<3, 1>(3, i) = R * joint.axis;
    R = (R * turn(joint.axis, q[i])).eval();
  }
  result.X_BS = Isometry3d::Identity();
  result.X_BS.translation() = p + R * leg.X_FS.translation();
  result.X_BS.linear() = R * leg.X_FS.linear();
  for (int i = 0; i < joints_of(leg); ++i)
    result.J.block<3, 1>(0, i) =
        Vector3d(result.J.block<3, 1>(3, i)).cross(result.X_BS.translation() - points.col(i));
  return result;
}

/// The translation and rotation from one pose to another, in the axes of the base.
LegVector way(const Isometry3d& from, const Isometry3d& to) {
  const Matrix3d R = to.linear() * from.linear().transpose();
  const Vector3d sine(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));  // times two
  const double square = sine.squaredNorm(), twice = std::sqrt(square);
  constexpr double kSmall = 1e-3;  // below this, the next term of the series is less than 1e-13
  const double half = twice < kSmall ? 0.5 + square / 48 : std::atan2(twice, R.trace() - 1) / twice;
  LegVector e;
  e << to.translation() - from.translation(), half * sine;
  return e;
}

LegSolution solved(const Robot& robot, const Leg& leg, const Isometry3d& X_BS, const LegVector& start) {
  LegSolution solution{start, false};
  for (int i = 0; i < kMostSteps && !solution.reached; ++i) {
    const auto [X, J] = chain(robot, leg, solution.q);
    const LegVector e = way(X, X_BS);
    const double square = e.squaredNorm();
    solution.reached = square < kLastStep * kLastStep;  // after this step
    Jacobian A = J.transpose() * J;
    A.diagonal().array() += kDamping * square + kLeastDamping;
    LegVector step = A.llt().solve(J.transpose() * e);
    if (const double most = step.cwiseAbs().maxCoeff(); most > kLargestStep_rad)
      step *= kLargestStep_rad / most;
    if (!step.allFinite()) return {start, false};
    solution.q += step;
  }
  return solution;
}

const Joint& joint_of(const Robot& robot, const Leg& leg, int i) {
  return robot.joints[static_cast<std::size_t>(leg.joints[static_cast<std::size_t>(i)])];
}

/// Index of the first joint of a leg that is beyond its range, if there is one.
std::optional<int> beyond_range(const Robot& robot, const Leg& leg, const LegVector& q) {
  for (int i = 0; i < joints_of(leg); ++i)
    if (const Joint& joint = joint_of(robot, leg, i); q[i] < joint.lowest || q[i] > joint.highest) return i;
  return std::nullopt;
}

std::string name_of(Side side) { return side == Side::left ? "left" : "right"; }

std::string degrees(double angle) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.5g", angle * kDegrees);
  return text.data();
}

void check_leg(const Robot& robot, Side side) {
  const Leg& leg = robot.leg(side);
  const auto require = [&](bool fulfilled, const std::string& complaint) {
    if (!fulfilled) throw std::invalid_argument("the " + name_of(side) + " leg " + complaint);
  };
  const int joints = joints_of(leg);
  require(joints >= 1 && joints <= 6, "has " + std::to_string(joints) + " joints, expected 1 to 6");
  int parent = -1;
  for (int i = 0; i < joints; ++i) {
    const Joint& joint = joint_of(robot, leg, i);
    require(joint.parent == parent, "is not a chain from base to foot: " + joint.name +
                                        " is not on the link of " +
                                        (parent < 0 ? "the base, expected no servo between them"
                                                    : robot.joints[static_cast<std::size_t>(parent)].name));
    require(std::isfinite(joint.lowest) && std::isfinite(joint.highest),
            "has no range at " + joint.name + ", expected limits in the model");
    parent = leg.joints[static_cast<std::size_t>(i)];
  }
  const LegVector q = leg_angles(leg, robot.posture);
  if (const auto i = beyond_range(robot, leg, q))
    require(false, "is beyond the range of " + joint_of(robot, leg, *i).name + " in the start posture");
  const Eigen::JacobiSVD<Jacobian> svd(chain(robot, leg, q).J);
  require(joints < 6 || svd.singularValues()[5] > kLeastFreedom,
          "cannot move its sole in every direction in the start posture, expected a bent knee and joint axes "
          "in every direction");
}

}  // namespace

LegVector leg_angles(const Leg& leg, const JointVector& q) {
  LegVector angles = LegVector::Zero();
  for (int i = 0; i < joints_of(leg); ++i) angles[i] = q[leg.joints[static_cast<std::size_t>(i)]];
  return angles;
}

void set_leg_angles(const Leg& leg, const LegVector& angles, JointVector& q) {
  for (int i = 0; i < joints_of(leg); ++i) q[leg.joints[static_cast<std::size_t>(i)]] = angles[i];
}

Isometry3d sole_in_base(const Robot& robot, Side side, const LegVector& q) {
  return chain(robot, robot.leg(side), q).X_BS;
}

Isometry3d imu_in_base(const Robot& robot, const JointVector& q) {
  Isometry3d X = robot.X_link_imu;
  for (int i = robot.chest; i >= 0; i = robot.joints[static_cast<std::size_t>(i)].parent) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
    X.prerotate(turn(joint.axis, q[i]));
    X.pretranslate(joint.offset);
  }
  return X;
}

LegSolution leg_inverse_kinematics(const Robot& robot, Side side, const Isometry3d& X_BS,
                                   const LegVector& start) {
  const Leg& leg = robot.leg(side);
  const LegSolution first = solved(robot, leg, X_BS, start);
  if (first.reached && !beyond_range(robot, leg, first.q)) return first;
  const LegSolution second = solved(robot, leg, X_BS, leg_angles(leg, robot.posture));
  return second.reached && (!first.reached || !beyond_range(robot, leg, second.q)) ? second : first;
}

std::optional<std::string> leg_obstacle(const Robot& robot, Side side, const LegSolution& solution) {
  if (!solution.reached) return "the " + name_of(side) + " foot is out of the leg's reach";
  const auto i = beyond_range(robot, robot.leg(side), solution.q);
  if (!i) return std::nullopt;
  const Joint& joint = joint_of(robot, robot.leg(side), *i);
  return "the " + name_of(side) + " leg's joint " + joint.name + " would have to turn to " +
         degrees(solution.q[*i]) + " degrees, its range is " + degrees(joint.lowest) + " to " +
         degrees(joint.highest);
}

void measure(Robot& robot) {
  for (const Side side : {Side::right, Side::left}) check_leg(robot, side);
  std::array<Isometry3d, 2> soles;                     // by Side
  constexpr double kLevel = 0.002, kFlat_rad = 0.005;  // tolerances for files with three digits
  for (const Side side : {Side::right, Side::left}) {
    Isometry3d& X = soles[static_cast<std::size_t>(side)];
    X = sole_in_base(robot, side, leg_angles(robot.leg(side), robot.posture));
    if (const double angle = Eigen::AngleAxisd(X.linear()).angle(); angle > kFlat_rad)
      throw std::invalid_argument("the " + name_of(side) + " sole is turned by " + degrees(angle) +
                                  " degrees in the start posture, expected it flat and pointing ahead");
  }
  const auto& [right, left] = soles;
  const Vector3d apart = left.translation() - right.translation();
  if (std::abs(apart.x()) > kLevel || std::abs(apart.z()) > kLevel || apart.y() <= 0)
    throw std::invalid_argument(
        "the soles are not side by side in the start posture, expected the left one directly to the left");
  robot.base_height = -(left.translation().z() + right.translation().z()) / 2;
  robot.sole_ahead = (left.translation().x() + right.translation().x()) / 2;
  robot.foot_spacing = apart.y();
  robot.upper_arm = 0;
  if (const std::optional<Arm>& arm = robot.arms.front())
    for (int joint = arm->elbow; joint >= 0 && joint != arm->shoulder;
         joint = robot.joints[static_cast<std::size_t>(joint)].parent)
      robot.upper_arm += robot.joints[static_cast<std::size_t>(joint)].offset.norm();
}

}  // namespace walking
