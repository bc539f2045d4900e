// What a recording knows of each frame.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "sim/view/frame.h"
#include "sim/view/model.h"

namespace sim::view {

/// The robot of a scenario, posed by hand. poses: of its model's bodies, by the angles of the encoders and
/// the waist's pose in W.
struct RobotModel {
  Model model;
  std::function<std::vector<float>(const Eigen::VectorXd& q, const Eigen::Isometry3d& X_WB)> poses;
};

/// Adds feet, zero-moment point and, where there is a robot, its bodies. frames: in order of time.
void add_recorded(std::vector<Frame>& frames, const std::filesystem::path& recording,
                  const RobotModel* robot);

/// What a recording alone knows of its frames: truth, and what add_recorded() adds, for the view of a replay.
/// Images are left out.
std::vector<Frame> read_recorded_frames(const std::filesystem::path& recording, const RobotModel* robot);

/// The image of each frame; empty where there is none.
std::vector<std::filesystem::path> image_files(const std::vector<Frame>& frames,
                                               const std::filesystem::path& recording);

}  // namespace sim::view
