// Every scenario in scenarios/ and its folders.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace sim::scenario {

inline std::filesystem::path scenario_folder() {
  return std::filesystem::path(GAITSLAM_SOURCE_DIR) / "scenarios";
}

/// Files in scenarios/suites and scenarios/tuning are not scenarios, those in scenarios/bases are parts.
inline std::vector<std::filesystem::path> scenario_files() {
  const std::set<std::string> others{"suites", "tuning", "bases"};
  std::vector<std::filesystem::path> files;
  for (const std::filesystem::path& file : std::filesystem::recursive_directory_iterator(scenario_folder()))
    if (file.extension() == ".yaml" && !others.contains(file.parent_path().filename())) files.push_back(file);
  std::sort(files.begin(), files.end());
  return files;
}

/// Returns the file's stem.
inline std::string test_name(const testing::TestParamInfo<std::filesystem::path>& test) {
  std::string name = test.param.lexically_relative(scenario_folder()).replace_extension().string();
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
}

}  // namespace sim::scenario
