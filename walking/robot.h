// A robot as known to plan and stabilizer: read once from its model and its file, then never changed. Also
// the kinematics of its legs.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace walking {

enum class Side { right, left };

/// A value for each joint, in the order of Robot::joints.
using JointVector = Eigen::VectorXd;
/// Values for a leg's joints from hip to ankle; 0 for entries past its last joint.
using LegVector = Eigen::Matrix<double, 6, 1>;

/// A joint that turns. With all joints at zero, the axes of every link equal the base's axes.
struct Joint {
  std::string name;
  int parent = -1;                                   ///< the joint whose link carries this one; -1: the base
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< from the parent joint, m, axes of its link
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();   ///< unit vector in the axes of the link
  double lowest = -std::numeric_limits<double>::infinity(), highest = -lowest;  ///< range, rad
  /// Smallest and largest torque, N·m.
  double lowest_effort = -std::numeric_limits<double>::infinity(), effort = -lowest_effort;
};

/// A spring with damping between ankle and sole.
struct Spring {
  bool turns = false;                               ///< true: about the axis, N·m/rad; false: along it, N/m
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< in the axes of the sole
  double stiffness = 0;
  double lag_s = 0;  ///< its damping divided by its stiffness
};

struct Leg {
  std::vector<int> joints;  ///< hip to ankle, at most 6, each on the link of the previous one
  /// Sole in the link of the last joint: its point on the ground below the ankle, x ahead and z up.
  Eigen::Isometry3d X_FS = Eigen::Isometry3d::Identity();
  Eigen::Vector2d sole_min = Eigen::Vector2d::Zero(), sole_max = Eigen::Vector2d::Zero();  ///< outline, m
  /// Springs of the ankle's bushing, from the ankle down; empty: the sole is rigid.
  std::vector<Spring> bush;
  /// Stiffness of the sole's pads against tilt about its axes x and y, N·m/rad, and its lag; 0: unknown.
  Eigen::Vector2d pad_stiffness = Eigen::Vector2d::Zero();
  double pad_lag_s = 0;

  bool has_pads() const { return pad_stiffness.minCoeff() > 0; }
  /// The position of the last joint in the axes of the sole, m.
  Eigen::Vector3d ankle() const { return X_FS.inverse().translation(); }
};

/// The joints of the arm that swing. Both turn about the base's y axis, in either direction, and at zero the
/// arm hangs down.
struct Arm {
  int shoulder = 0, elbow = 0;
};

/// Limits of steps that are known to work. The reach is the corner of the area that Herdt et al. 2010 give
/// for one foot as seen from the other.
struct StepLimits {
  double aside_m = 0.14;
  double reach_ahead_m = 0.28, reach_aside_m = 0.4;

  static void keys(auto&& key) {
    number<&StepLimits::aside_m>(key, 0.01, 1, "maximum distance that one foot moves to the side in a step");
    number<&StepLimits::reach_ahead_m>(key, 0.01, 1,
                                       "maximum distance that a foot lands ahead of the other one");
    number<&StepLimits::reach_aside_m>(key, 0.01, 1,
                                       "maximum distance that a foot lands to the side of the other one");
  }
};

struct Robot {
  std::string name;
  std::vector<Joint> joints = {};  ///< parents first
  std::array<Leg, 2> legs = {};    ///< by Side
  JointVector posture = {};        ///< at the start, both soles flat; joints that no plan moves keep it, rad
  double mass = 0;                 ///< kg
  /// Center of mass in the base in that posture, m. Its y is set to zero, so that the plan is symmetric and
  /// left and right walks mirror each other. The stabilizer handles the real offset.
  Eigen::Vector3d com = Eigen::Vector3d::Zero();
  int chest = -1;  ///< joint whose link carries the stabilizer's IMU; -1: the base
  /// Pose of that IMU, whose axes are forward, left and up, in its link.
  Eigen::Isometry3d X_link_imu = Eigen::Isometry3d::Identity();
  std::array<std::optional<Arm>, 2> arms = {};  ///< by Side
  StepLimits step = {};

  /// Set by measure() from the start posture, m: the height of the base above the ground, the distance of the
  /// sole points ahead of it and from each other, and the length of the upper arm from shoulder to elbow.
  double base_height = 0, sole_ahead = 0, foot_spacing = 0, upper_arm = 0;

  const Leg& leg(Side side) const { return legs[static_cast<std::size_t>(side)]; }
  Leg& leg(Side side) { return legs[static_cast<std::size_t>(side)]; }
  double com_height() const { return base_height + com.z(); }
};

/// Sets the quantities that follow from the start posture. If the legs cannot stand side by side, throws
/// std::invalid_argument with one line that names the leg or the joint. A plan needs six joints per leg.
void measure(Robot& robot);

/// Returns the angles of a leg's joints, from hip to ankle, rad; zeros after its last joint.
LegVector leg_angles(const Leg& leg, const JointVector& q);
/// Sets the angles of a leg's joints in q, given from hip to ankle, rad.
void set_leg_angles(const Leg& leg, const LegVector& angles, JointVector& q);

/// X_BS: the pose of the sole in the base.
Eigen::Isometry3d sole_in_base(const Robot& robot, Side side, const LegVector& q);
/// X_BG: the pose of the stabilizer's IMU in the base.
Eigen::Isometry3d imu_in_base(const Robot& robot, const JointVector& q);

struct LegSolution {
  LegVector q = LegVector::Zero();  ///< finite even if not reached
  bool reached = false;             ///< the sole is in place; joints may be beyond their range
};

/// Inverse kinematics by damped Gauss-Newton steps (Levenberg-Marquardt; damped by the squared error, so that
/// the final convergence is quadratic). It starts from `start`, the last tick's angles. If that does not
/// reach the pose or exceeds a range, it tries once more from the start posture. The number of steps is
/// bounded, and the same input gives the same bits.
LegSolution leg_inverse_kinematics(const Robot& robot, Side side, const Eigen::Isometry3d& X_BS,
                                   const LegVector& start);

/// Returns why a leg cannot take a solution, or nothing if it can.
std::optional<std::string> leg_obstacle(const Robot& robot, Side side, const LegSolution& solution);

}  // namespace walking
