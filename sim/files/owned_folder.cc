#include "sim/files/owned_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "sim/files/file_lock.h"
#include "sim/files/text.h"

namespace sim::files {
namespace {

namespace fs = std::filesystem;
using Names = MarkedNames;

constexpr std::string_view kHeader =
    "# Made by gaitslam, which replaces and removes only what is listed here.\n";

fs::file_status status_of(const fs::path& path) {
  std::error_code fault;
  return fs::symlink_status(path, fault);
}

bool is_real_folder(const fs::path& path) { return fs::is_directory(status_of(path)); }
bool is_real_file(const fs::path& path) { return fs::is_regular_file(status_of(path)); }

// The path within the folder as the marker has it.
std::string listed_as(const fs::path& path, const fs::path& folder) {
  return path.lexically_relative(folder).generic_string() + (is_real_folder(path) ? "/" : "");
}

std::vector<fs::path> sorted_entries(const fs::path& folder) {
  std::vector<fs::path> all;
  for (const auto& entry : fs::directory_iterator(folder)) all.push_back(entry.path());
  std::sort(all.begin(), all.end());
  return all;
}

// A partial folder of a process that was killed: nobody holds the lock of its marker.
bool is_leftover(const fs::path& path) {
  if (!is_partial(path) || !is_real_folder(path) || !is_real_file(path / kMarker)) return false;
  return FileLock::take(path / kMarker, FileLock::Mode::exclusive, FileLock::IfHeld::give_up,
                        FileLock::IfAbsent::give_up)
      .has_value();
}

// The file of which this is the partial one, or the file itself.
fs::path whole_of(const fs::path& path) {
  if (!is_partial(path)) return path;
  const std::string name = path.filename().string();
  return path.parent_path() / name.substr(1, name.rfind(".partial") - 1);
}

// Whether the file is the marker, in the marker's list, or the partial one of such a file.
bool is_listed_file(const fs::path& path, const fs::path& folder, const Names& made) {
  if (!is_real_file(path)) return false;
  const fs::path whole = whole_of(path);
  return whole == folder / kMarker || made.contains(listed_as(whole, folder));
}

// What to name of a folder that is not listed: the first thing in it, unless that is not the user's own
// either.
fs::path first_in(const fs::path& folder) {
  if (!is_real_folder(folder) || is_real_file(folder / kMarker)) return folder;
  const std::vector<fs::path> entries = sorted_entries(folder);
  return entries.empty() ? folder : first_in(entries.front());
}

std::optional<fs::path> foreign_below(const fs::path& below, const fs::path& folder, const Names& made) {
  for (const fs::path& path : sorted_entries(below)) {
    if (is_listed_file(path, folder, made) || is_leftover(path)) continue;
    if (!is_real_folder(path) || !made.contains(listed_as(path, folder))) return first_in(path);
    if (auto foreign = has_marker(path) ? foreign_in(path) : foreign_below(path, folder, made))
      return foreign;
  }
  return std::nullopt;
}

constexpr const char* kWhatToDo = "move it away, or name another folder";

}  // namespace

std::optional<MarkedNames> listed_in(const fs::path& folder) {
  if (!is_real_folder(folder) || !is_real_file(folder / kMarker)) return std::nullopt;
  const std::string text = read_text(folder / kMarker);
  if (!text.starts_with(kHeader)) return std::nullopt;
  MarkedNames names;
  for (std::size_t at = kHeader.size(); at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    names.insert(text.substr(at, end - at));
    at = end + 1;
  }
  return names;
}

std::string marker_text(const MarkedNames& names) {
  std::string text(kHeader);
  for (const std::string& name : names) text += name + "\n";
  return text;
}

std::string marker_of_all(const fs::path& folder) {
  Names names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path() != folder / kMarker) names.insert(listed_as(entry.path(), folder));
  return marker_text(names);
}

bool has_marker(const fs::path& folder) { return listed_in(folder).has_value(); }

std::optional<fs::path> foreign_in(const fs::path& folder) {
  if (const auto made = listed_in(folder)) return foreign_below(folder, folder, *made);
  const std::vector<fs::path> entries = sorted_entries(folder);
  return entries.empty() ? std::nullopt : std::optional(entries.front());
}

void require_own(const fs::path& folder) {
  const fs::file_status status = status_of(folder);
  if (!fs::exists(status)) return;
  if (fs::is_symlink(status)) throw FileError(folder, "is a symbolic link, expected a folder or a new name");
  if (!fs::is_directory(status)) throw FileError(folder, "is a file, expected a folder or a new name");
  const auto foreign = foreign_in(folder);
  if (!foreign) return;
  if (has_marker(folder))
    throw FileError(*foreign, fmt::format("was not made by gaitslam, and {} would be replaced: {}",
                                          folder.string(), kWhatToDo));
  throw FileError(folder,
                  fmt::format("would be replaced with {} in it, and has no list of what gaitslam made "
                              "there (older versions wrote none): {}",
                              foreign->filename().string(), kWhatToDo));
}

bool is_partial(const fs::path& path) {
  const std::string name = path.filename().string();
  return name.starts_with('.') && (name.ends_with(".partial") || name.find(".partial-") != name.npos);
}

void empty_but_marker(const fs::path& folder) {
  for (const fs::path& path : sorted_entries(folder))
    if (path != folder / kMarker) {
      std::error_code fault;
      fs::remove_all(path, fault);
      if (fault) throw FileError(path, "cannot be removed: " + fault.message());
    }
}

}  // namespace sim::files
