// The short table of a run on the terminal.
#pragma once

#include <filesystem>
#include <string>

namespace sim::result {

/// The headline metrics and those with limits, from a result folder's score.json and timing.json. Throws
/// FileError.
std::string score_table(const std::filesystem::path& result_folder);

}  // namespace sim::result
