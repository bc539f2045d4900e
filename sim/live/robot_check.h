// Checks a robot's folder and whether the robot stands and walks: `gaitslam robot check`.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace sim::live {

/// Prints line by line what was read, the share of a leg's workspace that inverse kinematics reaches, and how
/// 5 s of standing and steps in place end. Returns whether all is well. Throws std::runtime_error or
/// std::invalid_argument with one line for a robot that cannot be read.
bool check_robot(const std::filesystem::path& folder, const std::function<void(const std::string&)>& print);

}  // namespace sim::live
