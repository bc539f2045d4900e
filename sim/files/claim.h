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

}  // namespace sim::files
