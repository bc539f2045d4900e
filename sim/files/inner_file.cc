#include "sim/files/inner_file.h"

#include <algorithm>
#include <string>
#include <system_error>

#include "sim/files/file_error.h"

namespace sim::files {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLeadsOut = "leads out of the folder";

bool names_inner(const fs::path& name) {
  return !name.empty() && name.is_relative() && std::find(name.begin(), name.end(), "..") == name.end() &&
         name.native().find('\0') == std::string::npos;
}

/// Whether some part of the name is a link, or cannot be looked at.
bool may_lead_elsewhere(const fs::path& folder, const fs::path& name) {
  fs::path at = folder;
  for (const fs::path& part : name) {
    std::error_code error;
    const fs::file_type type = fs::symlink_status(at /= part, error).type();
    if (type == fs::file_type::symlink || type == fs::file_type::none) return true;
  }
  return false;
}

}  // namespace

fs::path inner_file(const fs::path& folder, std::string_view name) {
  if (!names_inner(name)) throw FileError(folder / std::string(name.substr(0, name.find('\0'))), kLeadsOut);
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
