// Helpers for tests of result folders.
#pragma once

#include <nlohmann/json.hpp>

#include "sim/files/text.h"

namespace tests {

namespace fs = sim::fs;

/// Relative path -> content of every file below a folder, except timing.* and the files in folders `without`.
inline std::map<std::string, std::string> files(const fs::path& folder, const std::string& without = "-") {
  std::map<std::string, std::string> contents;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder), last = entry.path().filename();
    if (!entry.is_regular_file() || last.starts_with("timing.") ||
        ("/" + name).find("/" + without) != name.npos)
      continue;
    contents[name] = sim::files::read_text(entry.path());
  }
  return contents;
}

/// The names of files that differ or exist in only one of two folders.
inline std::vector<std::string> differences(const std::map<std::string, std::string>& a,
                                            const std::map<std::string, std::string>& b) {
  std::vector<std::string> names;
  for (const auto& [name, content] : a)
    if (!b.contains(name) || b.at(name) != content) names.push_back(name);
  for (const auto& [name, content] : b)
    if (!a.contains(name)) names.push_back(name);
  return names;
}

inline std::vector<std::string> differences(const fs::path& a, const fs::path& b,
                                            const std::string& without = "-") {
  return differences(files(a, without), files(b, without));
}

inline nlohmann::json json_of(const fs::path& file) {
  return nlohmann::json::parse(sim::files::read_text(file));
}

inline double metric(const fs::path& folder, const std::string& name) {
  const nlohmann::json value = json_of(folder / "score.json")["metrics"][name]["value"];
  return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace tests
