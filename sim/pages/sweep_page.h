// The page of a sweep: its metrics over the swept keys, and the worst seed of each setting.
#pragma once

#include <filesystem>
#include <string>

namespace sim::pages {

/// Whether the folder holds the scores of a sweep.
bool is_sweep(const std::filesystem::path& folder);

/// The page about the folder of a sweep, with all its figures as SVG. Of one key that was swept alone: a line
/// of medians over its values, with all trials as dots. Of two keys: a heat map of the medians over seeds. Of
/// more keys: both for each key and for each pair, the other keys pooled by their median. Scenarios are never
/// pooled. Throws files::FileError.
std::string sweep_page(const std::filesystem::path& folder);

}  // namespace sim::pages
