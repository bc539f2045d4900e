// The robot in its room as the view draws them.
#pragma once

#include <filesystem>
#include <memory>

#include "sim/export/export.h"
#include "sim/view/playback.h"

namespace cli {

/// Loads a scenario's models; empty in a build without the simulator.
sim::view::MakeRobot robot_maker(const std::filesystem::path& models);

/// For exports; null in a build without the simulator. Throws std::runtime_error where the models do not load.
std::shared_ptr<const sim::exports::RobotDescription> robot_description(
    const sim::scenario::Scenario& scenario, const std::filesystem::path& models);

}  // namespace cli
