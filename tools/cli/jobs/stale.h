// Results of earlier commands, moved out of the way.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace cli {

/// The names of the results seed-<n> of other seeds in a folder.
std::vector<std::string> results_of_other_seeds(const std::filesystem::path& root,
                                                const std::vector<std::uint64_t>& seeds);

/// Moves these folders of `root` into its first folder earlier-<n> that does not exist yet, and reports it on
/// standard output. Throws a FileError that names those that cannot be moved, after the others were.
void set_aside(const std::filesystem::path& root, const std::vector<std::string>& names);

}  // namespace cli
