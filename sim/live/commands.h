// The commands `gaitslam robot check` and `gaitslam walker`.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace sim::live {

/// Prints line by line what was read, the share of a leg's workspace that inverse kinematics reaches, and how
/// 5 s of standing and steps in place end. Returns whether all is well. Throws std::runtime_error or
/// std::invalid_argument with one line for a robot that cannot be read.
bool check_robot(const std::filesystem::path& folder, const std::function<void(const std::string&)>& print);

/// Answers the messages of gaitslam_walker.h on standard input and output by pattern generator and
/// stabilizer. Returns the exit code.
int run_plan_program();

}  // namespace sim::live
