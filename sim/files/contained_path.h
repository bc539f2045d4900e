// Paths that a list in a folder names; rejects paths outside the folder.
#pragma once

#include <filesystem>
#include <string_view>

namespace sim::files {

/// Returns folder/name. Throws FileError if the name is empty, absolute or has "..", or if a link on the way
/// leaves the folder: lists in external files must not open anything else.
std::filesystem::path contained_path(const std::filesystem::path& folder, std::string_view name);

}  // namespace sim::files
