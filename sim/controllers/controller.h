// Walking controllers: readings of the robot's sensors in, commands of its servos out.
#pragma once

#include <string>

#include "walking/stabilizer.h"
#include "walking/steering.h"

namespace sim::controllers {

/// Readings of the robot's own sensors at a tick.
struct Readings : walking::SensorReadings {
  walking::JointVector dq, torque;  ///< rad/s, N·m
};

/// Gains and added torques for servos, instead of the robot's own.
struct Gains {
  walking::JointVector kp, kd, torque;  ///< N·m/rad, N·m·s/rad, N·m
};

/// The commands of all servos until the next ones: torque + kp (q - q̂) + kd (dq - dq̂).
struct JointCommands {
  walking::JointVector q, dq;
  std::optional<Gains> gains = {};  ///< absent: the robot's own servo gains, without added torques
  bool moves = true;                ///< q moves at dq, and is its mean over the tick
};

/// Properties of the robot for an external controller, beyond walking::Robot.
struct RobotDescription {
  struct Motor {
    double armature = 0, damping = 0, kp = 0, kd = 0;  ///< kg m², N·m·s/rad; kp, kd: the servo's
  };
  std::vector<Motor> motors;  ///< one per joint
  Eigen::Isometry3d X_BG = Eigen::Isometry3d::Identity();
  std::array<Eigen::Isometry3d, 2> X_BS;  ///< by walking::Side
  bool measures_wrenches = true;          ///< otherwise they are computed from torques
  std::string model;                      ///< MJCF
};

/// Velocity of the base in its own heading, m/s and rad/s.
struct Velocity {
  double ahead = 0, left = 0, turn = 0;
};

/// Two consecutive ticks of a plan or path.
struct Ticks {
  walking::Reference now, next;
};

/// A walking controller. At each tick of 5 ms command() is called, and then advance(), unless the robot is
/// still settling before its walk. If a program fails, programs::ProgramFailed is thrown.
class Controller {
 public:
  virtual ~Controller() = default;
  /// Joint angles at the start; the base is at reference().X_PB.
  virtual const walking::JointVector& start() const = 0;
  /// Before the walk, the base is held and lowered until the feet carry it, for at most this time, and is
  /// then free until twice this time. 0: the robot starts on the floor, and settles there if it stands.
  virtual double held_s() const { return 0; }
  virtual bool stands() const { return true; }
  virtual JointCommands command(const Readings& readings, bool settles) = 0;
  virtual void advance() = 0;
  /// Called at t = 0 if there is no plan: the walk begins at this pose of the base on the floor of W.
  virtual void start_at(const walking::FootPose&) {}
  /// Returns whether the walk continues after the ticks so far. progress(): how much of it is done, 0 to 1.
  virtual bool walks() const = 0;
  virtual double progress() const = 0;
  /// Returns whether reference() and following() are the controller's own plan. Otherwise they are the path
  /// that it is commanded to walk.
  virtual bool has_plan() const { return true; }
  /// Returns whether the floor is known to be the level floor of the plan.
  virtual bool is_level() const { return has_plan(); }
  /// The plan at this tick and at the next one.
  virtual const walking::Reference& reference() const = 0;
  virtual walking::Reference following() const = 0;

  /// The path to walk, without corrections, at this tick and at the next one; absent unless it differs
  /// from the plan.
  virtual std::optional<Ticks> path() const { return std::nullopt; }
  /// The commanded velocity of a controller that takes one.
  virtual std::optional<Velocity> velocity() const { return std::nullopt; }
  /// Returns whether steer() must get the newest estimate of the robot's place at this tick.
  virtual bool steers(std::size_t) const { return false; }
  virtual void steer(std::size_t, const std::optional<walking::PlaceEstimate>&) {}
  virtual std::optional<std::vector<walking::StepCorrection>> corrections() const { return std::nullopt; }
  /// Returns whether it receives the observations of the head's camera and the rig: messages of
  /// gaitslam_estimator.h with their headers.
  virtual bool wants_rig() const { return false; }
  virtual void add_rig(const std::string&) {}
  /// Returns why the walk stopped before the end of its commands, if it did.
  virtual std::optional<std::string> stopped() const { return std::nullopt; }
  /// Ends a program after the walk. Returns its log.
  virtual std::string finish() { return {}; }
  /// JSON text for the recording: number and hash of a program's answers; empty for a built-in controller.
  virtual std::string answers() const { return {}; }
  /// Wall time of each answer so far, ms.
  const std::vector<double>& took_ms() const { return took_ms_; }

 protected:
  using Clock = std::chrono::steady_clock;
  void took(Clock::duration time) {
    took_ms_.push_back(std::chrono::duration<double, std::milli>(time).count());
  }

 private:
  std::vector<double> took_ms_;
};

}  // namespace sim::controllers
