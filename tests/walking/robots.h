// Robots for tests: one with HRP-2's dimensions, and an invented one.
#pragma once

#include "walking/robot.h"

namespace walking {

/// Adds a joint and returns its index.
inline int add_joint(Robot& robot, const std::string& name, int parent, const Eigen::Vector3d& offset,
                     const Eigen::Vector3d& axis, double lowest_deg, double highest_deg) {
  constexpr double kRad = std::numbers::pi / 180;
  robot.joints.push_back({.name = name,
                          .parent = parent,
                          .offset = offset,
                          .axis = axis,
                          .lowest = lowest_deg * kRad,
                          .highest = highest_deg * kRad});
  return static_cast<int>(robot.joints.size()) - 1;
}

inline Robot hrp2_robot() {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(),
                        z = Eigen::Vector3d::UnitZ(), o = Eigen::Vector3d::Zero();
  Robot robot{.name = "hrp2", .mass = 56.867992, .com = {0.013695, 0, 0.159589}};
  for (const Side side : {Side::right, Side::left}) {
    const double out = side == Side::left ? 1 : -1;
    const std::string leg = side == Side::left ? "LLEG_JOINT" : "RLEG_JOINT";
    const auto add = [&](const Eigen::Vector3d& offset, const Eigen::Vector3d& axis, double inwards,
                         double outwards) {
      auto& joints = robot.leg(side).joints;  // about y, both sides are alike
      const bool mirrored = side == Side::left && axis != y;
      joints.push_back(add_joint(robot, leg + std::to_string(joints.size()),
                                 joints.empty() ? -1 : joints.back(), offset, axis,
                                 mirrored ? -outwards : inwards, mirrored ? -inwards : outwards));
    };
    add({0, 0.060 * out, 0}, z, -45, 30);
    add(o, x, -35, 20);
    add(o, y, -125, 42);
    add({0, 0.035 * out, -0.3}, y, -2, 150);
    add({0, 0, -0.3}, y, -75, 42);
    add(o, x, -20, 35);
    Leg& made = robot.leg(side);
    made.X_FS.translation().z() = -0.105;
    made.sole_min << -0.100, -0.069, made.sole_max << 0.130, 0.069;
    made.pad_stiffness << 1e9, 1e9;
    made.bush = {{false, z, 239018, 500. / 239018},
                 {true, z, 936, 5. / 936},
                 {true, y, 502, 5. / 502},
                 {true, x, 707, 5. / 707}};
  }
  const int chest = add_joint(robot, "CHEST_JOINT0", -1, {0.032, 0, 0.3507}, z, -45, 45);
  robot.chest = add_joint(robot, "CHEST_JOINT1", chest, o, y, -5, 60);
  int head = add_joint(robot, "HEAD_JOINT0", robot.chest, {-0.007, 0, 0.2973}, z, -45, 45);
  head = add_joint(robot, "HEAD_JOINT1", head, o, y, -30, 45);
  for (const Side side : {Side::right, Side::left}) {
    const double out = side == Side::left ? 1 : -1;
    const std::array<std::pair<Eigen::Vector3d, Eigen::Vector3d>, 7> arm{{{{0.008, 0.25 * out, 0.181}, y},
                                                                          {o, x},
                                                                          {o, z},
                                                                          {{0, 0, -0.25}, y},
                                                                          {o, z},
                                                                          {{0, 0, -0.25}, y},
                                                                          {o, x}}};
    int parent = robot.chest;
    for (std::size_t i = 0; i < arm.size(); ++i)
      parent = add_joint(robot, (side == Side::left ? "LARM_JOINT" : "RARM_JOINT") + std::to_string(i),
                         parent, arm[i].first, arm[i].second, -180, 180);
    robot.arms[static_cast<std::size_t>(side)] = Arm{parent - 6, parent - 3};
  }
  Eigen::VectorXd posture(30);
  posture << 0, 0, -26, 50, -24, 0, 0, 0, -26, 50, -24, 0, 0, 0, 0, 0, 15, -10, 0, -30, 0, 0, 10, 15, 10, 0,
      -30, 0, 0, 10;
  robot.posture = posture * (std::numbers::pi / 180);
  measure(robot);
  return robot;
}

/// A robot with oblique hip axes that do not meet, in the order pitch, roll, yaw and with different signs on
/// the left and right, ankle axes that do not meet, and a waist joint among the joints of the legs.
inline Robot made_up_robot() {
  constexpr double kRad = std::numbers::pi / 180;
  Robot robot{.name = "made_up", .mass = 61.87, .com = {0.004, 0, 0.11}};
  const auto oblique = [](double tilt_deg, const Eigen::Vector3d& axis) {
    return Eigen::Vector3d(Eigen::AngleAxisd(tilt_deg * kRad, Eigen::Vector3d(1, 0.3, 0.1).normalized()) *
                           axis);
  };
  for (const Side side : {Side::left, Side::right}) {
    const double out = side == Side::left ? 1 : -1;
    const std::string leg = side == Side::left ? "port_" : "starboard_";
    const auto add = [&](const char* name, const Eigen::Vector3d& offset, const Eigen::Vector3d& axis,
                         double lowest, double highest) {
      auto& joints = robot.leg(side).joints;
      const bool turned = side == Side::right && axis.y() == 0;
      joints.push_back(add_joint(robot, leg + name, joints.empty() ? -1 : joints.back(), offset,
                                 turned ? Eigen::Vector3d(-axis) : axis, lowest, highest));
    };
    add("swing", {0.01, 0.065 * out, -0.10}, oblique(12 * out, Eigen::Vector3d::UnitY()), -140, 160);
    add("spread", {0.02, 0.05 * out, -0.03}, oblique(0, Eigen::Vector3d(0.98, 0, 0.199).normalized()), -60,
        60);
    add("twist", {0.025, 0, -0.12}, Eigen::Vector3d(-0.17, 0, 0.985).normalized(), -90, 90);
    add("bend", {-0.05, 0.002 * out, -0.20}, -Eigen::Vector3d::UnitY(), -165, 5);
    if (side == Side::left)
      robot.chest = add_joint(robot, "middle", -1, {0, 0, 0.05}, Eigen::Vector3d::UnitZ(), -90, 90);
    add("heel", {0, 0, -0.34}, Eigen::Vector3d::UnitY(), -60, 50);
    add("tilt", {0.005, 0, -0.018}, Eigen::Vector3d::UnitX(), -30, 30);
    Leg& made = robot.leg(side);
    made.X_FS.translation() << 0.003, 0, -0.04;
    made.sole_min << -0.06, -0.04, made.sole_max << 0.13, 0.04;
  }
  robot.posture = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(robot.joints.size()));
  for (const Side side : {Side::left, Side::right}) {
    Eigen::Isometry3d X_BS = Eigen::Isometry3d::Identity();
    X_BS.translation() << 0.02, side == Side::left ? 0.12 : -0.12, -0.80;
    const LegVector bent = (LegVector() << -0.35, 0, 0, -0.7, -0.35, 0).finished();
    set_leg_angles(robot.leg(side), bent, robot.posture);
    set_leg_angles(robot.leg(side), leg_inverse_kinematics(robot, side, X_BS, bent).q, robot.posture);
  }
  measure(robot);
  return robot;
}

}  // namespace walking
