// What the plan is made of: footsteps and commands in, one Reference every 5 ms out.
#pragma once

#include <Eigen/Geometry>
#include <numbers>
#include <variant>
#include <vector>

namespace walking {

inline constexpr double kPeriod = 0.005;  ///< s, control period of HRP-2 and of its pattern generator
inline constexpr double kGravity = 9.81;  ///< m/s², the value the published gains were computed with
inline constexpr int kJoints = 30;        ///< RLEG 0-5, LLEG 0-5, CHEST 0-1, HEAD 0-1, RARM 0-6, LARM 0-6
using JointVector = Eigen::Matrix<double, kJoints, 1>;

enum class Side { right, left };

/// Stand still on both feet.
struct Stand {
  double duration_s = 1.0;
};
/// Walk straight to a point given in the robot's own frame at the start of the command, without turning.
struct Straight {
  double forward_m = 1.0;
  double left_m = 0.0;
};
/// Walk along a circle, facing along it; angle > 0 turns left (centre on the left).
struct TangentArc {
  double radius_m = 0.75;
  double angle_rad = std::numbers::pi / 2;
};
/// Walk along a circle, facing its centre (radius_m ahead); angle > 0 turns left, the robot moving to its
/// right.
struct PerpendicularArc {
  double radius_m = 0.75;
  double angle_rad = 2 * std::numbers::pi;
};
/// A landing seen from the foot that stands: that frame is first turned, then the foot set down in it.
struct Step {
  double forward_m = 0.0;
  double left_m = 0.0;  ///< positive: the left foot moves; never zero
  double turn_rad = 0.0;
};
/// Walk step by step; feet that the last step leaves apart are brought together.
struct Steps {
  std::vector<Step> list;
};
using Command = std::variant<Stand, Straight, TangentArc, PerpendicularArc, Steps>;

enum class SwingPolynomial { quintic, cubic };

/// What the arms do: keep half-sitting, swing against the legs by a heuristic, or take up the yaw momentum of
/// the rest of the body (resolved momentum control).
enum class ArmMotion { still, swing, momentum };

/// Sagittal angles of an arm, rad; half-sitting unless said otherwise.
struct ArmAngles {
  double shoulder_pitch = 15 * std::numbers::pi / 180, elbow = -30 * std::numbers::pi / 180;
};
struct Arms {
  ArmAngles right, left;
};

/// The scenario's keys walk.*, name for name.
struct WalkOptions {
  double single_support_s = 0.78;
  double double_support_s = 0.02;
  double step_height_m = 0.07;
  double step_length_m = 0.15;
  double preview_s = 1.6;
  double com_height_m = 0.814;
  SwingPolynomial swing = SwingPolynomial::quintic;
  ArmMotion arm_motion = ArmMotion::still;
  bool second_preview = false;
  std::vector<Command> commands;
};

enum class Support { both, left, right };

/// The plan at one instant (a multiple of 5 ms). World P: under the robot's waist at the start, x ahead, z
/// up. In half-sitting the ankles are 9.5 mm ahead of the waist and the centre of mass 13.7 mm ahead and
/// 0.808 m above ground (the cart-table's com_height_m sets the dynamics alone).
struct Reference {
  double t_s = 0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero(), com_velocity = Eigen::Vector3d::Zero(),
                  com_acceleration = Eigen::Vector3d::Zero();  ///< m, m/s, m/s² in P
  Eigen::Vector2d zmp = Eigen::Vector2d::Zero();               ///< the cart-table's ZMP, m in P
  Eigen::Vector2d zmp_reference = Eigen::Vector2d::Zero();     ///< the smoothed reference it follows
  Eigen::Isometry3d X_PB = Eigen::Isometry3d::Identity();      ///< waist
  Eigen::Vector3d waist_velocity = Eigen::Vector3d::Zero();    ///< of the waist's origin, m/s in P
  double waist_yaw_rate = 0;                                   ///< rad/s
  Eigen::Isometry3d X_PL = Eigen::Isometry3d::Identity();  ///< left sole: point of the sole below the ankle
  Eigen::Isometry3d X_PR = Eigen::Isometry3d::Identity();  ///< right sole
  Arms arms;
  Support support = Support::both;
  int command = 0;  ///< index into WalkOptions::commands of what is being carried out
};

}  // namespace walking
