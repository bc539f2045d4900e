#include "sim/files/contained_path.h"

#include <algorithm>
#include <string>
#include <system_error>

#include "sim/files/text.h"

namespace sim::files {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLeadsOut = "leads out of the folder";

bool stays_inside(const fs::path& name) {
  return !name.empty() && name.is_relative() && std::find(name.begin(), name.end(), "..") == name.end() &&
         name.native().find('\0') == std::string::npos;
}

/// True if a part of the name is a link or cannot be examined.
bool may_lead_elsewhere(fs::path at, const fs::path& name) {
  return std::any_of(name.begin(), name.end(), [&](const fs::path& part) {
    std::error_code error;
    const fs::file_type type = fs::symlink_status(at /= part, error).type();
    return type == fs::file_type::symlink || type == fs::file_type::none;
  });
}

}  // namespace

fs::path contained_path(const fs::path& folder, std::string_view name) {
  if (!stays_inside(name)) throw FileError(folder / std::string(name.substr(0, name.find('\0'))), kLeadsOut);
  const fs::path file = folder / name;
  if (!may_lead_elsewhere(folder, name)) return file;
  std::error_code no_root, no_file;
  const fs::path root = fs::canonical(folder, no_root), real = fs::weakly_canonical(file, no_file);
  if (no_root || no_file)
    throw FileError(file, "cannot be opened: " + (no_root ? no_root : no_file).message());
  if (std::mismatch(root.begin(), root.end(), real.begin(), real.end()).first != root.end())
    throw FileError(file, kLeadsOut);
  return file;
}

}  // namespace sim::files
