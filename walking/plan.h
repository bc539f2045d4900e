// What the plan is made of: footsteps and commands in, one Reference every 5 ms out.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <chrono>
#include <numbers>
#include <string_view>
#include <variant>
#include <vector>

#include "walking/hrp2.h"
#include "walking/steering_options.h"

namespace walking {

inline constexpr std::chrono::milliseconds kTick{
    5};  ///< control period of HRP-2 and of its pattern generator
inline constexpr double kPeriod = std::chrono::duration<double>(kTick).count();  ///< the same, s
inline constexpr double kGravity = 9.81;  ///< m/s², the value the published gains were computed with

enum class Side { right, left };

// What a user can set has, beside it, `keys`: it tells a visitor the name, the range and the meaning of each
// value, once for all who read, check, print or explain it. A visitor has number, degrees, choice, value and
// part, as RangeCheck (keys.h) has. kName: what a command is called in a scenario file.

/// The longest walk, s: two commands of an hour each.
inline constexpr int kLongestWalk_s = 7200;

/// Stand still on both feet.
struct Stand {
  static constexpr const char* kName = "stand";
  double duration_s = 1.0;

  static void keys(auto&& key) {
    key.number("duration_s", &Stand::duration_s, 0, 3600, "time to stand on both feet");
  }
};
/// Walk straight to a point given in the robot's own frame at the start of the command, without turning.
struct Straight {
  static constexpr const char* kName = "straight";
  double forward_m = 1.0;
  double left_m = 0.0;

  static void keys(auto&& key) {
    key.number("forward_m", &Straight::forward_m, -1000, 1000,
               "distance ahead, in the robot's frame at the start");
    key.number("left_m", &Straight::left_m, -1000, 1000, "distance to the left; negative: to the right");
  }
};
/// Walk along a circle, facing along it; angle > 0 turns left (centre on the left).
struct TangentArc {
  static constexpr const char* kName = "tangent_arc";
  double radius_m = 0.75;
  double angle_rad = std::numbers::pi / 2;

  /// The inner foot needs a circle of its own: the radius is more than the spacing of the feet.
  static void keys(auto&& key) {
    key.number("radius_m", &TangentArc::radius_m, 0.2, 1000, "radius of the circle");
    key.degrees("angle_deg", &TangentArc::angle_rad, -36000, 36000,
                "angle to walk along the circle; positive: the robot turns left");
  }
};
/// Walk along a circle, facing its centre (radius_m ahead); angle > 0 turns left, the robot moving to its
/// right.
struct PerpendicularArc {
  static constexpr const char* kName = "perpendicular_arc";
  double radius_m = 0.75;
  double angle_rad = 2 * std::numbers::pi;

  static void keys(auto&& key) {
    key.number("radius_m", &PerpendicularArc::radius_m, 0.2, 1000, "radius of the circle");
    key.degrees("angle_deg", &PerpendicularArc::angle_rad, -36000, 36000,
                "angle to walk along the circle; positive: the robot turns left");
  }
};
/// A landing seen from the foot that stands: that frame is first turned, then the foot set down in it.
struct Step {
  double forward_m = 0.0;
  double left_m = 0.0;  ///< never zero
  double turn_rad = 0.0;

  static void keys(auto&& key) {
    key.number("forward_m", &Step::forward_m, -1, 1, "distance of the landing ahead of the standing foot");
    key.number("left_m", &Step::left_m, -1, 1,
               "distance of the landing to the left of the standing foot; positive: the left foot moves");
    key.degrees(
        "turn_deg", &Step::turn_rad, -36000, 36000,
        "angle by which the frame of the standing foot is turned before the landing is set down in it");
  }
};
/// Walk step by step; feet that the last step leaves apart are brought together.
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
    key.degrees("angle_deg", &Turn::angle_rad, -36000, 36000, "angle to turn on the spot; positive: left");
    key.degrees("step_deg", &Turn::step_rad, 1, 15, "largest turn in one step");
  }
};
/// Go to a place of the world W, whose origin is under the waist at the start: turn towards it, walk
/// straight, turn to the heading.
struct GoTo {
  static constexpr const char* kName = "go_to";
  double x_m = 1.0;
  double y_m = 0.0;
  double heading_rad = 0.0;

  static void keys(auto&& key) {
    key.number("x_m", &GoTo::x_m, -1000, 1000, "place of the waist, ahead of where the walk began");
    key.number("y_m", &GoTo::y_m, -1000, 1000, "place of the waist, to the left of where the walk began");
    key.degrees("heading_deg", &GoTo::heading_rad, -36000, 36000,
                "heading at the end, against that at the walk's begin; positive: to the left");
  }
};
/// Carry out the last commands again; each time is a lap, the time before the repetition the first one.
struct Repeat {
  static constexpr const char* kName = "repeat";
  int last = 1;
  int times = 1;

  static void keys(auto&& key) {
    key.number("last", &Repeat::last, 1, 1000, "how many of the commands before this one are repeated");
    key.number("times", &Repeat::times, 1, 1000, "how often they are carried out again");
  }
};
using Command = std::variant<Stand, Straight, TangentArc, PerpendicularArc, Steps, Turn, GoTo, Repeat>;

enum class SwingPolynomial { quintic, cubic };
inline constexpr std::array<std::string_view, 2> kSwingPolynomials{"quintic", "cubic"};

/// What the arms do: keep half-sitting, swing against the legs by a heuristic, or take up the yaw momentum of
/// the rest of the body (resolved momentum control).
enum class ArmMotion { still, swing, momentum };
inline constexpr std::array<std::string_view, 3> kArmMotions{"still", "swing", "momentum"};

/// Sagittal angles of an arm, rad; half-sitting unless said otherwise.
struct ArmAngles {
  double shoulder_pitch = hrp2::kShoulderPitch_deg * std::numbers::pi / 180,
         elbow = hrp2::kElbow_deg * std::numbers::pi / 180;
};
struct Arms {
  ArmAngles right, left;
};

/// The scenario's keys walk.*.
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
  SteeringOptions steering;
  std::vector<Command> commands;

  static void keys(auto&& key) {
    key.number("single_support_s", &WalkOptions::single_support_s, 0.1, 5, "time on one foot in each step");
    key.number("double_support_s", &WalkOptions::double_support_s, kPeriod, 5,
               "time on both feet between steps");
    key.number("step_height_m", &WalkOptions::step_height_m, 0.005, 0.2,
               "height to which the swing foot is lifted");
    key.number("step_length_m", &WalkOptions::step_length_m, 0.01, 0.4,
               "longest advance of the body in one step");
    key.number("preview_s", &WalkOptions::preview_s, 0.1, 10, "horizon of the preview control of the ZMP");
    key.number("com_height_m", &WalkOptions::com_height_m, 0.3, 1.5,
               "height of the centre of mass in the cart-table model");
    key.choice("swing", &WalkOptions::swing, kSwingPolynomials, "polynomial of the swing foot's trajectory");
    key.choice(
        "arm_motion", &WalkOptions::arm_motion, kArmMotions,
        "motion of the arms: still (half-sitting), swing (against the legs) or momentum (they compensate the "
        "body's yaw momentum)");
    key.value("second_preview", &WalkOptions::second_preview,
              "whether a second preview stage makes the ZMP of the whole body, not only the cart-table's, "
              "follow the "
              "reference");
    key.value("commands", &WalkOptions::commands,
              "walk commands, carried out in this order, in at most 7200 s altogether");
    key.part("steering", &WalkOptions::steering);
  }
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

/// Waist, soles and arms in P: what inverse kinematics turns into joint angles.
struct Posture {
  Eigen::Isometry3d X_PB = Eigen::Isometry3d::Identity(), X_PL = Eigen::Isometry3d::Identity(),
                    X_PR = Eigen::Isometry3d::Identity();
  Arms arms;
};

/// The planned posture.
inline Posture posture_of(const Reference& reference) {
  return {reference.X_PB, reference.X_PL, reference.X_PR, reference.arms};
}

}  // namespace walking
