// Results of earlier commands that must not be taken for those of this one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace cli {

/// The names of the results seed-<n> in a folder whose seeds are not among these.
std::vector<std::string> results_of_other_seeds(const std::filesystem::path& root,
                                                const std::vector<std::uint64_t>& seeds);

/// Moves these folders of `root` into its first folder earlier-<n> that does not exist yet, and says so on
/// standard output. Does nothing without names. Throws a FileError that names those that cannot be moved,
/// after the others were.
void set_aside(const std::filesystem::path& root, const std::vector<std::string>& names);

}  // namespace cli
