#include "sim/files/claim.h"

#include "sim/files/durable_file.h"
#include "sim/files/owned_folder.h"

namespace sim::files {
namespace {
namespace fs = std::filesystem;

bool is_there(const fs::path& folder, const std::string& name) {
  std::error_code fault;
  return fs::exists(fs::symlink_status(folder / name, fault));
}
}

void claim(const fs::path& folder, const std::vector<std::string>& names) {
  MarkedNames made = listed_in(folder).value_or(MarkedNames{});
  std::error_code fault;
  for (const std::string& name : names) {
    const fs::path path = folder / (name.ends_with('/') ? name.substr(0, name.size() - 1) : name);
    const bool known = made.contains(name) && !fs::is_symlink(fs::symlink_status(path, fault));
    if (!known && fs::exists(fs::symlink_status(path, fault)))
      throw FileError(path,
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
    if (!is_there(folder, name)) made->erase(name);
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
