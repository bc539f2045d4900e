// Walking controllers: readings of the robot's sensors in, commands of its servos out.
#pragma once

#include <string>

#include "walking/plan.h"
#include "walking/stabilizer.h"

namespace sim::controllers {

/// Readings of the robot's own sensors at a tick.
struct Readings : walking::SensorReadings {
  walking::JointVector dq, torque;  ///< rad/s, N·m
};

/// Gains and added torques of servos that are not the robot's own.
struct Gains {
  walking::JointVector kp, kd, torque;  ///< N·m/rad, N·m·s/rad, N·m
};

/// The commands of all servos until the next ones: torque + kp (q - q̂) + kd (dq - dq̂).
struct JointCommands {
  walking::JointVector q, dq;
  std::optional<Gains> gains = {};  ///< absent: those of the robot's own servos, without added torques
};

/// Properties of the robot for an external controller, beyond walking::Robot.
struct RobotDescription {
  struct Motor {
    double armature = 0, damping = 0, kp = 0, kd = 0;  ///< kg m², N·m·s/rad; kp, kd: of the robot's servo
  };
  std::vector<Motor> motors;  ///< of the joints
  Eigen::Isometry3d X_BG = Eigen::Isometry3d::Identity();
  std::array<Eigen::Isometry3d, 2> X_BS;  ///< by walking::Side
  bool measures_wrenches = true;          ///< otherwise they are computed from torques
  std::string model;                      ///< MJCF
};

/// A walking controller. Per tick of 5 ms: command(), then, unless the robot settles before its walk,
/// advance(). Failures of a program are programs::ProgramFailed.
class Controller {
 public:
  virtual ~Controller() = default;
  /// Joint angles at the start; the base is at reference().X_PB.
  virtual const walking::JointVector& start() const = 0;
  /// Duration of lowering the base, and again of settling without support, before the walk; 0: the robot
  /// stands.
  virtual double held_s() const { return 0; }
  virtual JointCommands command(const Readings& readings, bool settles) = 0;
  virtual void advance() = 0;
  /// Returns whether the walk continues after the ticks so far, and how much of it has been carried out, 0 to
  /// 1.
  virtual bool walks() const = 0;
  virtual double progress() const = 0;
  /// Returns whether reference() and following() are the controller's own plan. Otherwise they are the path
  /// that it is commanded to walk.
  virtual bool has_plan() const { return true; }
  /// The plan at this tick and at the next one.
  virtual const walking::Reference& reference() const = 0;
  virtual walking::Reference following() const = 0;
  /// Ends a program after the walk. Returns its log.
  virtual std::string finish() { return {}; }
};

}  // namespace sim::controllers
