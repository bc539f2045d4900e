// The pages: each is one HTML file that needs no other file and no network.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/pages/run_data.h"

namespace sim::pages {

/// The page about these runs (at least one). Throws FileError if a file of a run is broken.
std::string runs_page(const std::vector<RunData>& runs);

/// True if the folder contains the scores of a sweep.
bool is_sweep(const std::filesystem::path& folder);
/// The page of a sweep: medians over one swept key as a line with all trials as dots, over two keys as a heat
/// map, with further keys pooled by their median; and the worst seed of each setting. Scenarios are never
/// pooled. Throws FileError.
std::string sweep_page(const std::filesystem::path& folder);

/// True if the folder contains a tuning.
bool is_tuning(const std::filesystem::path& folder);
/// The page of a tuning: the search, what the recordings determine, and the result on hold-out runs. Throws
/// FileError.
std::string tune_page(const std::filesystem::path& folder);

}  // namespace sim::pages
