// The models of a run and its robot, which is read once from the compiled model and robot.yaml.
#pragma once

#include "sim/controllers/controller.h"
#include "sim/physics/robot_in_room.h"

namespace sim::physics {

/// Throws std::invalid_argument with one line: "file:line:column: key: what is wrong, expected ..." for names
/// in robot.yaml, otherwise with the element of the model.
walking::Robot read_robot(const mjModel_& model, const RobotFile& file);

/// The models of a run. Each file is opened once; users copy these models.
struct Models {
  /// Throws std::runtime_error if a model does not load, and whatever read_robot() throws.
  Models(const RobotFile& robot, const std::string& room, const std::filesystem::path& folder);
  Models(const model_file::Element& adapted, const RobotFile& robot, const std::string& room,
         const std::filesystem::path& folder);
  /// Moves head camera and chest IMU in both models, not in `robot`. Throws std::invalid_argument as
  /// place_of().
  void mount(const rig::Mount& camera, const rig::Mount& imu);

  Model on_floor;  ///< the model to step: the robot on kPhysicalRoom, only colliding shapes
  Model in_room;   ///< the robot in its furnished room, all shapes
  walking::Robot robot;
  bool imu_is_moved = false;
  bool has_force_sensors = true;  ///< at both ankles
};

/// Returns the data about the robot that an external controller receives. file: the file that the models were
/// read from.
controllers::RobotDescription describe(const Models& models, const RobotFile& file);

}  // namespace sim::physics
