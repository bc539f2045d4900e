#include <fmt/format.h>

#include <sstream>

#include "sim/files/atomic_file.h"

namespace sim::files {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kHeader =
    "# Made by gaitslam, which replaces and removes only what is listed here.\n";
constexpr const char* kWhatToDo = "move it away, or name another folder";

fs::file_status status_of(const fs::path& path) {
  std::error_code fault;
  return fs::symlink_status(path, fault);
}

bool is_real_folder(const fs::path& path) { return fs::is_directory(status_of(path)); }
bool is_real_file(const fs::path& path) { return fs::is_regular_file(status_of(path)); }

std::string marker_text(const OutputNames& names) {
  std::string text(kHeader);
  for (const std::string& name : names) text += name + "\n";
  return text;
}

// The path within the folder, in the form of the marker.
std::string listed_as(const fs::path& path, const fs::path& folder) {
  return path.lexically_relative(folder).generic_string() + (is_real_folder(path) ? "/" : "");
}

std::set<fs::path> entries_of(const fs::path& folder) { return {fs::directory_iterator(folder), {}}; }

// True for the marker, a listed file, or the temporary sibling of such a file.
bool is_listed_file(const fs::path& path, const fs::path& folder, const OutputNames& made) {
  if (!is_real_file(path)) return false;
  const std::string name = path.filename().string();
  const fs::path whole =
      is_partial(path) ? path.parent_path() / name.substr(1, name.rfind(".partial") - 1) : path;
  return whole == folder / kMarker || made.contains(listed_as(whole, folder));
}

std::optional<fs::path> unlisted_below(const fs::path& below, const fs::path& folder,
                                       const OutputNames& made) {
  for (const fs::path& path : entries_of(below)) {
    if (is_listed_file(path, folder, made) || lock_leftover(path)) continue;
    if (!is_real_folder(path) || !made.contains(listed_as(path, folder))) return path;
    if (auto found = has_marker(path) ? unlisted_in(path) : unlisted_below(path, folder, made)) return found;
  }
  return std::nullopt;
}

// The path of a listed name, without the slash of a folder: that would follow a link.
fs::path path_of(const fs::path& folder, std::string_view name) {
  return folder / name.substr(0, name.size() - (name.ends_with('/') ? 1 : 0));
}

bool exists_as_listed(const fs::path& folder, const std::string& name) {
  const fs::path path = path_of(folder, name);
  return name.ends_with('/') ? is_real_folder(path) : is_real_file(path);
}

}  // namespace

std::optional<OutputNames> listed_in(const fs::path& folder) {
  if (!is_real_folder(folder) || !is_real_file(folder / kMarker)) return std::nullopt;
  const std::string text = read_text(folder / kMarker);
  if (!text.starts_with(kHeader)) return std::nullopt;
  OutputNames names;
  std::istringstream lines(text.substr(kHeader.size()));
  for (std::string line; std::getline(lines, line);) names.insert(line);
  return names;
}

bool has_marker(const fs::path& folder) { return listed_in(folder).has_value(); }

std::string marker_of_all(const fs::path& folder) {
  OutputNames names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path() != folder / kMarker) names.insert(listed_as(entry.path(), folder));
  return marker_text(names);
}

std::optional<fs::path> unlisted_in(const fs::path& folder) {
  if (const auto made = listed_in(folder)) return unlisted_below(folder, folder, *made);
  const std::set<fs::path> entries = entries_of(folder);
  return entries.empty() ? std::nullopt : std::optional(*entries.begin());
}

void require_replaceable(const fs::path& folder) {
  const fs::file_status status = status_of(folder);
  if (!fs::exists(status)) return;
  if (fs::is_symlink(status)) throw FileError(folder, "is a symbolic link, expected a folder or a new name");
  if (!fs::is_directory(status)) throw FileError(folder, "is a file, expected a folder or a new name");
  const auto unlisted = unlisted_in(folder);
  if (!unlisted) return;
  if (has_marker(folder))
    throw FileError(*unlisted, fmt::format("was not made by gaitslam, and {} would be replaced: {}",
                                           folder.string(), kWhatToDo));
  throw FileError(folder,
                  fmt::format("would be replaced with {} in it, and has no list of what gaitslam made "
                              "there (older versions wrote none): {}",
                              unlisted->filename().string(), kWhatToDo));
}

void list_outputs(const fs::path& folder, const std::vector<std::string>& names) {
  OutputNames made = listed_in(folder).value_or(OutputNames{});
  for (const std::string& name : names) {
    const fs::path path = path_of(folder, name);
    if (fs::exists(status_of(path)) && !(made.contains(name) && exists_as_listed(folder, name)))
      throw FileError(
          path,
          fmt::format("was not made by this version of gaitslam, which would replace it: {}", kWhatToDo));
  }
  made.insert(names.begin(), names.end());
  fs::create_directories(folder);
  write_atomically(folder / kMarker, marker_text(made));
}

void unlist_missing(const fs::path& folder, const std::vector<std::string>& names) {
  std::optional<OutputNames> made = listed_in(folder);
  if (!made) return;
  const std::size_t before = made->size();
  for (const std::string& name : names)
    if (!exists_as_listed(folder, name)) made->erase(name);
  if (made->empty())
    fs::remove(folder / kMarker);
  else if (made->size() < before)
    write_atomically(folder / kMarker, marker_text(*made));
}

void add_to_marker(const fs::path& folder, const std::vector<std::string>& names) {
  std::optional<OutputNames> made = listed_in(folder);
  if (!made) return;
  made->insert(names.begin(), names.end());
  write_atomically(folder / kMarker, marker_text(*made));
}

}  // namespace sim::files
