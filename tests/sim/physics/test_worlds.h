// Worlds and models of tests: a robot that stands, a robot that walks, a model of a few lines.
#pragma once

#include <mujoco/mujoco.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "sim/physics/walking_robot.h"

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

/// 50 m ahead, 30 m to the right, turned by 115°.
inline Eigen::Isometry3d far_away() {
  Eigen::Isometry3d X_WP = Eigen::Isometry3d::Identity();
  X_WP.translate(Eigen::Vector3d(50, -30, 0)).rotate(Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitZ()));
  return X_WP;
}

/// Model files of a robot without any part and a room of the given MJCF elements.
class SmallModel {
 public:
  explicit SmallModel(const std::string& room, const std::string& robot = "<worldbody/>") {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "robot.xml") << "<mujoco>" << robot << "</mujoco>";
    std::ofstream(folder_ / "room.xml") << "<mujoco>" << room << "</mujoco>";
  }
  ~SmallModel() { std::filesystem::remove_all(folder_); }
  SmallModel(const SmallModel&) = delete;
  SmallModel& operator=(const SmallModel&) = delete;

  Model load() const { return load_model("robot", "room", folder_); }

 private:
  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("gaitslam_small_model_" + std::to_string(getpid()));
};

/// Puts the robot on the tangent circle (0.75 m about (1, 0.25)) after a turn by `yaw`.
inline void stand_on_circle(mjData& data, double yaw) {
  data.qpos[0] = 1 + 0.75 * std::sin(yaw), data.qpos[1] = 0.25 - 0.75 * std::cos(yaw),
  data.qpos[2] = walking::hrp2::kWaistHeight;
  data.qpos[3] = std::cos(yaw / 2), data.qpos[4] = data.qpos[5] = 0, data.qpos[6] = std::sin(yaw / 2);
}

}  // namespace sim::physics
