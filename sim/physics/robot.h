// The models of a run, and its robot: read once from the compiled model and its file.
#pragma once

#include "sim/controllers/controller.h"
#include "sim/physics/model.h"

namespace sim::physics {

/// Throws std::invalid_argument with one line, "file:line:column: key: what is wrong, expected ..." for what
/// robot.yaml names, or with the element of the model.
walking::Robot read_robot(const mjModel_& model, const RobotFile& file);

/// The models of a run: each file is opened once; users copy these.
struct Models {
  /// Throws std::runtime_error if a model does not load, and as read_robot().
  Models(const RobotFile& robot, const std::string& room, const std::filesystem::path& folder);
  /// Moves head camera and chest IMU in both models, not in `robot`. Throws std::invalid_argument as
  /// place_of().
  void mount(const rig::Mount& camera, const rig::Mount& imu);

  Model on_floor;  ///< the robot on kPhysicalRoom, with shapes that collide only: what is stepped
  Model in_room;   ///< robot and furnished room, all shapes
  walking::Robot robot;
  bool imu_is_moved = false;
  bool has_force_sensors = true;  ///< at both ankles
};

/// Returns what an external controller receives of the robot. file: that of the models.
controllers::RobotDescription describe(const Models& models, const RobotFile& file);

}  // namespace sim::physics
