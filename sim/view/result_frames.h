// What a result folder itself knows of each frame: truth, plan, and what the estimator made of it.
#pragma once

#include <filesystem>
#include <vector>

#include "sim/pages/run_data.h"
#include "sim/view/frame.h"

namespace sim::view {

/// In order of time. Throws files::FileError where a file is broken or there is no frame.
std::vector<Frame> read_result_frames(const std::filesystem::path& result, const pages::RunData& data);

}  // namespace sim::view
