// Worlds and models for tests: a standing robot, a walking robot, a model of a few lines.
#pragma once

#include <mujoco/mujoco.h>

#include "sim/model_file/element.h"
#include "sim/physics/walking_robot.h"
#include "sim/scenario/robot.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::physics {

inline fs::path models() { return fs::path(GAITSLAM_SOURCE_DIR) / "models"; }

inline RobotFile robot_file(const std::string& name = "hrp2") {
  return scenario::read_robot(models() / "robots" / name);
}
/// HRP-2 on the bare floor.
inline const Models& on_floor() {
  static const Models models_on_floor(robot_file(), "floor", models());
  return models_on_floor;
}
inline walking::JointVector half_sitting() { return on_floor().robot.posture; }

/// A robot in its posture on the bare floor.
inline World standing(const Models& on_floor, const PlantVariation& draw = {},
                      const Eigen::Isometry3d& X_WB = Eigen::Isometry3d::Identity()) {
  WorldOptions options;
  options.room = "floor";
  return World(options, draw, on_floor.robot.posture, X_WB, on_floor);
}
inline World standing(const PlantVariation& draw = {},
                      const Eigen::Isometry3d& X_WB = Eigen::Isometry3d::Identity(),
                      WorldOptions options = {}, const char* room = "floor") {
  options.room = room;
  return World(options, draw, half_sitting(), X_WB, {robot_file(), room, models()});
}

inline void run(World& world, int milliseconds) {
  for (int k = 0; k < milliseconds; ++k) world.step();
}

/// Waist at the end, true and planned.
struct Walked {
  Status status;
  Eigen::Isometry3d X_PB, planned;
};

/// Walks until the plan or the robot is finished.
inline Walked walk(WalkingRobot&& robot) {
  while (robot.walks()) robot.tick();
  return {robot.world().status(), robot.world().X_WB(), robot.reference().X_PB};
}

/// A model of a robot (without any part) in a room with the given MJCF elements.
inline Model small_model(const std::string& room, const std::string& robot = "<worldbody/>") {
  const files::TemporaryFolder folder;
  files::write_text(folder / "model.xml", "<mujoco>" + robot + room + "</mujoco>");
  return load_mjcf(model_file::read_xml(folder / "model.xml"), "the small model");
}

}  // namespace sim::physics
