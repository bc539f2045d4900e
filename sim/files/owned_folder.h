// What the program made is known by a marker, so that it replaces and removes nothing else.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>

#include "sim/files/file_error.h"

namespace sim::files {

/// The marker of a folder: a text file that lists, by their paths within the folder, the files and the
/// folders (these end in "/") that the program made there.
inline constexpr const char* kMarker = ".gaitslam";

/// What a marker lists.
using MarkedNames = std::set<std::string, std::less<>>;
/// The names that the marker of the folder itself, no symbolic link to it, lists; nothing without a marker.
std::optional<MarkedNames> listed_in(const std::filesystem::path& folder);
/// The text of a marker.
std::string marker_text(const MarkedNames& names);
/// The text of the marker of a folder in which the program made everything that is there now.
std::string marker_of_all(const std::filesystem::path& folder);

/// Whether the folder itself, no symbolic link to it, has a marker.
bool has_marker(const std::filesystem::path& folder);

/// The first thing in the folder, by name, that the program did not make there: it is not listed in the
/// marker and no leftover of a process that was killed. What is in a listed folder with a marker of its own
/// is judged by that one. Symbolic links are not followed and never the program's. Nothing when all was made
/// by the program, or the folder is empty.
std::optional<std::filesystem::path> foreign_in(const std::filesystem::path& folder);

/// Throws a FileError that names the first thing in the folder that the program did not make, or the folder
/// when it is none or a symbolic link. A folder that does not exist is nobody's.
void require_own(const std::filesystem::path& folder);

/// Whether a file or folder has the name under which write_durably() or DurableFolder make theirs
/// (".X.partial").
bool is_partial(const std::filesystem::path& path);

/// Removes what is in the folder, its marker excepted; links are not followed. Throws a FileError that names
/// what cannot be removed.
void empty_but_marker(const std::filesystem::path& folder);

}  // namespace sim::files
