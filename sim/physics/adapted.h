// A robot's model file as loaded by the bench: with the servos, sites, camera and sensors from robot.yaml.
#pragma once

#include <memory>

#include "sim/model_file/model_file.h"
#include "sim/physics/robot_file.h"

namespace sim::physics {

/// A robot's MJCF in radians, without defaults: `asset`, `worldbody` with only the robot, `tendon`,
/// `equality`, and the bench's parts. Names of assets start with "robot/".
struct AdaptedRobot {
  model_file::Element root;
  std::vector<model_file::Note> notes;
};

/// Reads the robot's numbers as compiled by MuJoCo from the model's file, and adds the bench's parts as
/// specified in robot.yaml, with the names listed at RobotFile. The soles' contacts touch the floor and the
/// other foot, the rest of a foot touches the other foot, and everything else touches nothing. Shapes are
/// drawn in group 1, or group 2 on the head camera's link and everything fixed to it; shapes that only
/// collide are not drawn (group 3). Joints without servo and stiffness are rigid. Throws std::runtime_error
/// "file:line: ..." for errors in the model and std::invalid_argument "file:line:column: key: ..." for names
/// in robot.yaml.
AdaptedRobot adapt(const RobotFile& robot);

/// What a walk in the first robot.yaml depends on, apart from the model.
struct Gait {
  double single_support_s = 0.6, double_support_s = 0.15, step_height_m = 0.03, step_length_m = 0.12,
         zmp_inwards_m = 0;
  double ankle_kp = 1, ankle_kd = 1;  ///< factors of the guessed gains of the ankles' servos
};

class Guess;

/// The first robot.yaml for a model that has none, with each guess marked by a comment. Feet are the two
/// lowest ends of chains, the left one where y > 0; the sole's point is below the last joint.
class FirstRobotFile {
 public:
  /// Throws std::runtime_error if the model does not load or does not have two feet.
  explicit FirstRobotFile(const fs::path& model);
  ~FirstRobotFile();
  FirstRobotFile(FirstRobotFile&&) noexcept;
  /// Returns the gait that the masses, heights and torque limits of the model suggest.
  Gait guessed_gait() const;
  /// Returns a scenario's key rig with the lidar and the further IMUs of the model, or "".
  std::string rig() const;
  /// model: the path to write. comment: what is known about the gait. noises: the key slam; "": a guess.
  std::string yaml(const std::string& model, const Gait& gait, const std::string& comment,
                   const std::string& noises = "") const;
  /// Returns the text for a trial, in which arms, hands and neck are rigid: the physics takes half the time.
  std::string trial(const std::string& model, const Gait& gait) const;

 private:
  std::unique_ptr<Guess> guess_;
};

/// Returns the first robot.yaml with the guessed gait.
std::string first_robot_file(const fs::path& model, const std::string& written);

}  // namespace sim::physics
