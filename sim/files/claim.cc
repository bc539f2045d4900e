#include "sim/files/claim.h"

#include "sim/files/durable_file.h"
#include "sim/files/owned_folder.h"

namespace sim::files {
namespace {

namespace fs = std::filesystem;

/// A name, that of a folder with "/" at its end, and what stands there itself, not what a link leads to.
struct Entry {
  Entry(const fs::path& folder, std::string_view name)
      : path(folder / name.substr(0, name.size() - (name.ends_with('/') ? 1 : 0))) {
    std::error_code fault;
    const fs::file_status status = fs::symlink_status(path, fault);
    exists = fs::exists(status);
    is_as_named = exists && !fs::is_symlink(status) && fs::is_directory(status) == name.ends_with('/');
  }
  fs::path path;
  bool exists = false, is_as_named = false;
};

}  // namespace

void claim(const fs::path& folder, const std::vector<std::string>& names) {
  MarkedNames made = listed_in(folder).value_or(MarkedNames{});
  for (const std::string& name : names) {
    const Entry entry(folder, name);
    if (entry.exists && !(entry.is_as_named && made.contains(name)))
      throw FileError(entry.path,
                      "was not made by this version of gaitslam, which would replace it: move it away, or "
                      "name another folder");
  }
  made.insert(names.begin(), names.end());
  fs::create_directories(folder);
  write_durably(folder / kMarker, marker_text(made));
}

void drop_unwritten(const fs::path& folder, const std::vector<std::string>& names) {
  std::optional<MarkedNames> made = listed_in(folder);
  if (!made) return;
  const std::size_t before = made->size();
  for (const std::string& name : names)
    if (!Entry(folder, name).is_as_named) made->erase(name);
  if (made->empty())
    fs::remove(folder / kMarker);
  else if (made->size() < before)
    write_durably(folder / kMarker, marker_text(*made));
}

void add_to_marker(const fs::path& folder, const std::vector<std::string>& names) {
  std::optional<MarkedNames> made = listed_in(folder);
  if (!made) return;
  made->insert(names.begin(), names.end());
  write_durably(folder / kMarker, marker_text(*made));
}

}  // namespace sim::files
