// Types of the plan: footsteps and commands in, one Reference every 5 ms out.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <chrono>
#include <numbers>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "walking/robot.h"

namespace walking {

/// Source of the pose that corrects the footsteps: none (plan), the true pose (the best case), the estimate,
/// or leg odometry, whose heading is by the gyro.
enum class SteeredBy { plan, truth, estimate, legs };
inline constexpr std::array<std::string_view, 4> kSteeredBy{"plan", "truth", "estimate", "legs"};

enum class OnLost { go_on, stop };
inline constexpr std::array<std::string_view, 2> kOnLost{"go_on", "stop"};

struct SteeringOptions {
  SteeredBy by = SteeredBy::plan;
  double latency_s = 0.1;
  double gain = 0.8;
  double dead_band_sigma = 0.5;
  double largest_ahead_m = 0.03;
  double largest_aside_m = 0.02;
  double largest_turn_rad = 3 * std::numbers::pi / 180;
  OnLost on_lost = OnLost::stop;
  double lost_s = 3.0;
  double tolerance_m = 0, tolerance_rad = 0;
  int final_steps = 8;

  /// Returns these options with a tolerance that the walk can reach, if none was set; the default is for a
  /// plan.
  SteeringOptions with_tolerance(double m = 0.006, double rad = 0.5 * std::numbers::pi / 180) const {
    SteeringOptions set = *this;
    if (set.tolerance_m == 0) set.tolerance_m = m;
    if (set.tolerance_rad == 0) set.tolerance_rad = rad;
    return set;
  }

  static void keys(auto&& key) {
    choice<&SteeringOptions::by>(key, kSteeredBy,
                                 "what corrects the footsteps: plan (nothing), truth (the true pose), "
                                 "estimate or legs (leg odometry)");
    number<&SteeringOptions::latency_s>(
        key, 0, 10,
        "age of the newest estimate that may correct a footstep; with estimator.time, this is added to its "
        "latency, and the default is 0");
    number<&SteeringOptions::gain>(key, 0, 1, "fraction of an error that one footstep corrects");
    number<&SteeringOptions::dead_band_sigma>(
        key, 0, 100, "error that is left uncorrected, in standard deviations of the estimate");
    number<&SteeringOptions::largest_ahead_m>(key, 0, 0.1, "largest correction of a footstep along the foot");
    number<&SteeringOptions::largest_aside_m>(key, 0, 0.1,
                                              "largest correction of a footstep across the foot");
    degrees<&SteeringOptions::largest_turn_rad>(key, 0, 10, "largest correction of a footstep's heading");
    choice<&SteeringOptions::on_lost>(
        key, kOnLost, "action when the estimate stays lost: go_on (with the plan) or stop (on both feet)");
    number<&SteeringOptions::lost_s>(key, 0, 1e6, "time without an estimate after which it counts as lost");
    number<&SteeringOptions::tolerance_m>(key, 0, 10,
                                          "distance from the end of the path within which no steps are "
                                          "added; 0: 0.006, or half a step at the largest "
                                          "speed of a walking controller");
    degrees<&SteeringOptions::tolerance_rad>(
        key, 0, 180,
        "heading error at the end of the path within which no steps are added; 0: 0.5, or half a step at the "
        "largest turn rate of a walking controller");
    number<&SteeringOptions::final_steps>(
        key, 0, 1000, "maximum number of steps added at the end of the path to reach the tolerance");
  }
};

inline constexpr std::chrono::milliseconds kTick{5};                             ///< control period
inline constexpr double kPeriod = std::chrono::duration<double>(kTick).count();  ///< the same, s
inline constexpr double kGravity = 9.81;  ///< m/s², the value used for the published gains

// Options have a function `keys` that passes name, range and meaning of each value to a visitor (keys.h). It
// is the only source for reading, checking, printing and help. kName: the name of a command in a scenario
// file.

/// The longest walk, s: two one-hour commands.
inline constexpr int kLongestWalk_s = 7200;

/// Stand still on both feet.
struct Stand {
  static constexpr const char* kName = "stand";
  double duration_s = 1.0;

  static void keys(auto&& key) { number<&Stand::duration_s>(key, 0, 3600, "time to stand on both feet"); }
};
/// Walk straight to a point given in the robot's own frame at the start of the command, without turning.
struct Straight {
  static constexpr const char* kName = "straight";
  double forward_m = 1.0;
  double left_m = 0.0;

  static void keys(auto&& key) {
    number<&Straight::forward_m>(key, -1000, 1000, "distance ahead, in the robot's frame at the start");
    number<&Straight::left_m>(key, -1000, 1000, "distance to the left; negative: to the right");
  }
};
/// Walk along a circle, facing in the direction of travel; angle > 0 turns left (center on the left).
struct TangentArc {
  static constexpr const char* kName = "tangent_arc";
  double radius_m = 0.75;
  double angle_rad = std::numbers::pi / 2;

  /// The inner foot walks a circle, too, so the radius is larger than the spacing of the feet.
  static void keys(auto&& key) {
    number<&TangentArc::radius_m>(key, 0.2, 1000, "radius of the circle");
    degrees<&TangentArc::angle_rad>(key, -36000, 36000,
                                    "angle to walk along the circle; positive: the robot turns left");
  }
};
/// Walk along a circle, facing its center (radius_m ahead); angle > 0 turns left, moving to the right.
struct PerpendicularArc {
  static constexpr const char* kName = "perpendicular_arc";
  double radius_m = 0.75;
  double angle_rad = 2 * std::numbers::pi;
  double step_m = 0.12;

  static void keys(auto&& key) {
    number<&PerpendicularArc::radius_m>(key, 0.2, 1000, "radius of the circle");
    degrees<&PerpendicularArc::angle_rad>(key, -36000, 36000,
                                          "angle to walk along the circle; positive: the robot turns left");
    number<&PerpendicularArc::step_m>(
        key, 0.01, 0.4,
        "longest advance in one step if walk.step_length_m is longer; at 0.15 the robot may fall");
  }
};
/// A landing relative to the standing foot: the standing foot's frame is turned first, and the other foot
/// is set down in it.
struct Step {
  double forward_m = 0.0;
  double left_m = 0.0;  ///< never zero
  double turn_rad = 0.0;

  static void keys(auto&& key) {
    number<&Step::forward_m>(key, -1, 1, "distance of the landing ahead of the standing foot");
    number<&Step::left_m>(
        key, -1, 1,
        "distance of the landing to the left of the standing foot; positive: the left foot moves");
    degrees<&Step::turn_rad>(key, -36000, 36000,
                             "turn of the standing foot's frame before the landing is placed in it");
  }
};
/// Walk step by step. If the last step leaves the feet apart, they are brought together.
struct Steps {
  static constexpr const char* kName = "steps";
  std::vector<Step> list;
};
/// Turn on the spot; angle > 0 turns left.
struct Turn {
  static constexpr const char* kName = "turn";
  double angle_rad = std::numbers::pi / 2;
  double step_rad = std::numbers::pi / 18;

  static void keys(auto&& key) {
    degrees<&Turn::angle_rad>(key, -36000, 36000, "angle to turn on the spot; positive: left");
    degrees<&Turn::step_rad>(key, 1, 15, "largest turn in one step");
  }
};
/// Go to a place in W (origin under the waist at the start): turn to it, walk straight, turn to the heading.
struct GoTo {
  static constexpr const char* kName = "go_to";
  double x_m = 1.0;
  double y_m = 0.0;
  double heading_rad = 0.0;

  static void keys(auto&& key) {
    number<&GoTo::x_m>(key, -1000, 1000, "place of the waist, ahead of the start of the walk");
    number<&GoTo::y_m>(key, -1000, 1000, "place of the waist, to the left of the start of the walk");
    degrees<&GoTo::heading_rad>(key, -36000, 36000,
                                "heading at the end, relative to the initial heading; positive: to the left");
  }
};
/// Carry out the last commands again. Each time is a lap, and so is the time before the repetition.
struct Repeat {
  static constexpr const char* kName = "repeat";
  int last = 1;
  int times = 1;

  static void keys(auto&& key) {
    number<&Repeat::last>(key, 1, 1000, "number of preceding commands to repeat");
    number<&Repeat::times>(key, 1, 1000, "number of additional repetitions");
  }
};
using Command = std::variant<Stand, Straight, TangentArc, PerpendicularArc, Steps, Turn, GoTo, Repeat>;

enum class SwingPolynomial { quintic, cubic };
inline constexpr std::array<std::string_view, 2> kSwingPolynomials{"quintic", "cubic"};

/// Motion of the arms: keep the start posture, or swing opposite to the legs (a heuristic).
enum class ArmMotion { still, swing };
inline constexpr std::array<std::string_view, 2> kArmMotions{"still", "swing"};

/// Sagittal angles of an arm about the y axis, rad.
struct ArmAngles {
  double shoulder_pitch = 0, elbow = 0;
};
struct Arms {
  ArmAngles right, left;
};

/// Which of a robot's gaits gives the defaults of a walk: that for all directions, or one for sideways steps.
enum class Gait { usual, sideways };
inline constexpr std::array<std::string_view, 2> kGaits{"usual", "sideways"};

/// The scenario's keys walk.*.
struct WalkOptions {
  Gait gait = Gait::usual;
  double single_support_s = 0.78;
  double double_support_s = 0.02;
  double step_height_m = 0.07;
  double step_length_m = 0.15;
  double preview_s = 1.6;
  double com_height_m = 0;  ///< 0: the robot's own
  double zmp_inwards_m = 0;
  SwingPolynomial swing = SwingPolynomial::quintic;
  ArmMotion arm_motion = ArmMotion::still;
  bool second_preview = false;
  SteeringOptions steering;
  std::vector<Command> commands;

  static void keys(auto&& key) {
    choice<&WalkOptions::gait>(key, kGaits,
                               "defaults of the other keys of walk: usual (walk in robot.yaml) or sideways "
                               "(walk_sideways there, if the robot has it)");
    number<&WalkOptions::single_support_s>(key, 0.1, 5, "time on one foot in each step");
    number<&WalkOptions::double_support_s>(key, kPeriod, 5, "time on both feet between steps");
    number<&WalkOptions::step_height_m>(key, 0.005, 0.2, "height of the swing foot's path");
    number<&WalkOptions::step_length_m>(key, 0.01, 0.4, "longest advance of the body in one step");
    number<&WalkOptions::preview_s>(key, 0.1, 10, "horizon of the preview control of the ZMP");
    number<&WalkOptions::com_height_m>(
        key, 0, 1.5, "height of the center of mass in the cart-table model; 0: the robot's own");
    number<&WalkOptions::zmp_inwards_m>(key, -0.1, 0.1,
                                        "shift of the ZMP under the stance foot toward the other foot");
    choice<&WalkOptions::swing>(key, kSwingPolynomials, "polynomial of the swing foot's trajectory");
    choice<&WalkOptions::arm_motion>(
        key, kArmMotions, "motion of the arms: still (as at the start) or swing (opposite to the legs)");
    value<&WalkOptions::second_preview>(
        key, "whether a second preview stage makes the ZMP of the whole body follow the reference");
    value<&WalkOptions::commands>(key,
                                  "walk commands, carried out in this order, in at most 7200 s in total");
    part<&WalkOptions::steering>(key);
  }
};

enum class Support { both, left, right };

/// Waist, soles (their points below the ankles) and arms in P, which inverse kinematics turns into joint
/// angles.
struct Posture {
  Eigen::Isometry3d X_PB = Eigen::Isometry3d::Identity(), X_PL = Eigen::Isometry3d::Identity(),
                    X_PR = Eigen::Isometry3d::Identity();
  std::optional<Arms> arms;  ///< absent: as in the start posture
};

/// The plan at one instant (a multiple of 5 ms), in the world P: under the robot's waist at the start, x
/// ahead, z up. com_height_m only sets the dynamics of the cart-table.
struct Reference : Posture {
  double t_s = 0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero(), com_velocity = Eigen::Vector3d::Zero(),
                  com_acceleration = Eigen::Vector3d::Zero();  ///< m, m/s, m/s² in P
  Eigen::Vector2d zmp = Eigen::Vector2d::Zero();               ///< the cart-table's ZMP, m in P
  Eigen::Vector2d zmp_reference = Eigen::Vector2d::Zero();     ///< the smoothed reference it follows
  Eigen::Vector3d waist_velocity = Eigen::Vector3d::Zero();    ///< velocity of the waist's origin, m/s in P
  double waist_yaw_rate = 0;                                   ///< rad/s
  Support support = Support::both;
  int command = 0;  ///< index in WalkOptions::commands of the current command

  /// The foot in the air; the default while both feet stand.
  struct Swing {
    Side side = Side::left;
    Eigen::Isometry3d X_PS = Eigen::Isometry3d::Identity();  ///< the sole after landing
    double elapsed = 0;                                      ///< from 0 to 1
    double left_s = 0;                                       ///< time until touch-down
  };
  Swing swing;
  /// Sum of all landing adjustments since the start, m. All positions include it.
  Eigen::Vector2d frame_shift = Eigen::Vector2d::Zero();
};

}  // namespace walking
