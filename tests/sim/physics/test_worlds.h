// Worlds and models of tests: a robot that stands, a robot that walks, a model of a few lines.
#pragma once

#include <mujoco/mujoco.h>

#include <fstream>

#include "sim/physics/walking_robot.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::physics {

using walking::hrp2::half_sitting;

inline std::filesystem::path models() { return std::filesystem::path(GAITSLAM_SOURCE_DIR) / "models"; }

inline World standing(const PlantVariation& draw = {},
                      const Eigen::Isometry3d& X_WB = Eigen::Isometry3d::Identity(),
                      WorldOptions options = {}, const char* room = "floor") {
  options.room = room;
  return World(options, draw, half_sitting(), X_WB, {"hrp2", room, models()});
}

inline void run(World& world, int milliseconds) {
  for (int k = 0; k < milliseconds; ++k) world.step();
}

/// Waist at the end, true and planned, in the plan's world P.
struct Walked {
  Status status;
  Eigen::Isometry3d X_PB, planned;
};

/// Walks with P at X_WP, until the plan or the robot is at its end.
inline Walked walk(const walking::WalkOptions& options, const walking::StabilizerOptions& stabilizer,
                   const WorldOptions& world = {}, const PlantVariation& draw = {},
                   const Eigen::Isometry3d& X_WP = Eigen::Isometry3d::Identity()) {
  WalkingRobot robot(walking::PatternGenerator(options), stabilizer, world, draw,
                     {"hrp2", world.room, models()}, X_WP);
  while (robot.walks()) robot.tick();
  return {robot.world().status(), X_WP.inverse() * robot.world().X_WB(), robot.reference().X_PB};
}

/// A model of a robot (without any part) in a room of the given MJCF elements.
inline Model small_model(const std::string& room, const std::string& robot = "<worldbody/>") {
  const files::TemporaryFolder folder;
  std::ofstream(folder / "robot.xml") << "<mujoco>" << robot << "</mujoco>";
  std::ofstream(folder / "room.xml") << "<mujoco>" << room << "</mujoco>";
  return load_model("robot", "room", folder.path());
}

}  // namespace sim::physics
