// The short table of a run on the terminal.
#pragma once

#include <filesystem>
#include <string>

#include "sim/result/table_style.h"

namespace sim::result {

/// The headline metrics and those with limits, or all, from a result folder's score.json, timing.json and,
/// where it is there, about.json. A reason that several metrics share stands once, below them. failed: the
/// run ended in a way that its scenario does not allow, and whoever shows the table says why; the table says
/// it of another ending than completed. Throws FileError.
std::string score_table(const std::filesystem::path& result_folder, const TableStyle& style = {},
                        bool failed = false);

}  // namespace sim::result
