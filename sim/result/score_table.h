// The short table of a run on the terminal.
#pragma once

#include <filesystem>
#include <string>

#include "sim/result/limits.h"

namespace sim::result {

/// A table of the headline metrics and those with limits, or all, from a result folder's score.json,
/// timing.json and, if it exists, about.json. A reason that several metrics share is printed once, below
/// them. The table has the cause of an ending other than completed, unless `failed`: then the caller prints
/// it. Throws FileError.
std::string score_table(const std::filesystem::path& result_folder, const TableStyle& style = {},
                        bool failed = false);

}  // namespace sim::result
