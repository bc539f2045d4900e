// Names of files that a list in a folder gives: what leads out of the folder is refused.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <utility>

namespace sim::files {

/// folder/name. Throws FileError where the name is empty, absolute or has "..", or where a link on the way
/// leads out of the folder: lists in files from others must not open anything else.
std::filesystem::path contained_path(const std::filesystem::path& folder, std::string_view name);

/// The same for the many names of a list: a folder that they share is looked at once.
class ContainedPaths {
 public:
  explicit ContainedPaths(std::filesystem::path folder) : folder_(std::move(folder)) {}
  std::filesystem::path file(std::string_view name);

 private:
  bool may_lead_elsewhere(const std::filesystem::path& name);

  std::filesystem::path folder_;
  std::set<std::string> plain_;  // folders below it to which no link leads
};

}  // namespace sim::files
