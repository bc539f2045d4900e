#include "sim/files/contained_path.h"

#include <algorithm>
#include <string>
#include <system_error>

#include "sim/files/text.h"

namespace sim::files {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLeadsOut = "leads out of the folder";

bool names_inner(const fs::path& name) {
  return !name.empty() && name.is_relative() && std::find(name.begin(), name.end(), "..") == name.end() &&
         name.native().find('\0') == std::string::npos;
}

}  // namespace

/// Whether some part of the name is a link, or cannot be looked at.
bool ContainedPaths::may_lead_elsewhere(const fs::path& name) {
  const auto is_plain = [](const fs::path& path) {
    std::error_code error;
    const fs::file_type type = fs::symlink_status(path, error).type();
    return type != fs::file_type::symlink && type != fs::file_type::none;
  };
  const fs::path parent = name.parent_path();
  if (!plain_.contains(parent.native())) {
    fs::path at = folder_;
    for (const fs::path& part : parent)
      if (!is_plain(at /= part)) return true;
    plain_.insert(parent.native());
  }
  return !is_plain(folder_ / name);
}

fs::path ContainedPaths::file(std::string_view name) {
  if (!names_inner(name)) throw FileError(folder_ / std::string(name.substr(0, name.find('\0'))), kLeadsOut);
  const fs::path file = folder_ / name;
  if (!may_lead_elsewhere(name)) return file;
  std::error_code no_root, no_file;
  const fs::path root = fs::canonical(folder_, no_root), real = fs::weakly_canonical(file, no_file);
  if (no_root || no_file)
    throw FileError(file, "cannot be opened: " + (no_root ? no_root : no_file).message());
  if (std::mismatch(root.begin(), root.end(), real.begin(), real.end()).first != root.end())
    throw FileError(file, kLeadsOut);
  return file;
}

fs::path contained_path(const fs::path& folder, std::string_view name) {
  return ContainedPaths(folder).file(name);
}

}  // namespace sim::files
