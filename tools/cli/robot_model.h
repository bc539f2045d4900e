// The robot in its room as the view draws them.
#pragma once

#include <filesystem>

#include "sim/view/playback.h"

namespace cli {

/// Loads a scenario's models; empty in a build without the simulator.
sim::view::MakeRobot robot_maker(const std::filesystem::path& models);

}  // namespace cli
