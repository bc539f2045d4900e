// Names of files that a list in a folder gives: what leads out of the folder is refused.
#pragma once

#include <filesystem>
#include <string_view>

namespace sim::files {

/// folder/name. Throws FileError where the name is empty, absolute or has "..", or where a link on the way
/// leads out of the folder: lists in files from others must not open anything else.
std::filesystem::path inner_file(const std::filesystem::path& folder, std::string_view name);

}  // namespace sim::files
