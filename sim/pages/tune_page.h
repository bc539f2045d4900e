// The page of a tuning: how the search went, what the recordings determine, and whether it helps on the
// hold-out recordings.
#pragma once

#include <filesystem>
#include <string>

namespace sim::pages {

/// The page of a folder with tune.json and history.csv, as one HTML file that needs no other file. Throws
/// files::FileError where they are broken.
std::string tune_page(const std::filesystem::path& folder);

}  // namespace sim::pages
