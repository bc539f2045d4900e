// A first robot.yaml for a model that has none, guessed from its tree.
#pragma once

#include <filesystem>
#include <string>

namespace sim::physics {

/// Returns the text, each guess marked by a comment. Feet are the two lowest ends of chains, the left one
/// where y > 0; the sole's point is below the last joint. Throws std::runtime_error if the model does not
/// load or has no two feet.
std::string first_robot_file(const std::filesystem::path& model, const std::string& written);

}  // namespace sim::physics
