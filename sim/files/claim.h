// Files that the program writes into folders which it did not make, under names that are its own.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/files/file_error.h"

namespace sim::files {

/// Lists these names in the folder's marker (owned_folder.h), which is made where it is missing, and the
/// folder too. Names of folders end in "/". Throws a FileError that names the first of them that is there and
/// was not listed before; then nothing is changed.
void claim(const std::filesystem::path& folder, const std::vector<std::string>& names);

/// Takes those of these names that nothing in the folder has out of its marker, which is removed when it
/// lists nothing.
void drop_unwritten(const std::filesystem::path& folder, const std::vector<std::string>& names);

/// Lists these names in the folder's marker, as claim() does, whatever is there now; does nothing in a folder
/// without a marker. For folders in a result that have a marker of their own.
void add_to_marker(const std::filesystem::path& folder, const std::vector<std::string>& names);

}  // namespace sim::files
