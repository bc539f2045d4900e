// A MuJoCo model of a few lines, for a test alone.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "sim/physics/model.h"

namespace sim::physics {

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

}  // namespace sim::physics
