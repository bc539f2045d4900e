// A folder's marker lists what the program made there, so that it replaces and removes nothing else.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "sim/files/text.h"

namespace sim::files {

/// The marker: a text file that lists, by their paths within the folder, the files and folders (these end in
/// "/") that the program made there.
inline constexpr const char* kMarker = ".gaitslam";

using OutputNames = std::set<std::string, std::less<>>;

/// Returns what the folder's marker lists, or nothing if it has none. Markers and folders that are symbolic
/// links do not count.
std::optional<OutputNames> listed_in(const std::filesystem::path& folder);
bool has_marker(const std::filesystem::path& folder);

/// Returns the text of a marker that lists everything in the folder.
std::string marker_of_all(const std::filesystem::path& folder);

/// Returns the first entry of the folder, by name, that is neither listed nor the leftover of a killed
/// process. A listed folder that has a marker is checked against that one. Symbolic links are never the
/// program's.
std::optional<std::filesystem::path> unlisted_in(const std::filesystem::path& folder);

/// Throws a FileError that names the first unlisted entry of the folder, or the folder if it is a file or a
/// symbolic link. A folder that does not exist passes.
void require_replaceable(const std::filesystem::path& folder);

/// Lists these names in the folder's marker; makes both if they are missing. Throws a FileError that names
/// the first of them that exists but was not listed before; then nothing is changed.
void list_outputs(const std::filesystem::path& folder, const std::vector<std::string>& names);

/// Removes those of these names from the marker that do not exist, and the marker if it then lists nothing.
void unlist_missing(const std::filesystem::path& folder, const std::vector<std::string>& names);

/// Lists these names in the marker, if the folder has one, without a check. For folders in a result that have
/// markers themselves.
void add_to_marker(const std::filesystem::path& folder, const std::vector<std::string>& names);

}  // namespace sim::files
