// Every scenario shipped in scenarios/ and its folders, for tests that hold of each of them.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace sim::bench {

inline std::filesystem::path scenario_folder() {
  return std::filesystem::path(GAITSLAM_SOURCE_DIR) / "scenarios";
}

/// A scenario says what is walked; suites and what else lies there do not.
inline bool is_scenario(const std::filesystem::path& file) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);)
    if (line == "walk:") return true;
  return false;
}

inline std::vector<std::filesystem::path> scenario_files() {
  std::vector<std::filesystem::path> files;
  for (const std::filesystem::path& file : std::filesystem::recursive_directory_iterator(scenario_folder()))
    if (file.extension() == ".yaml" && is_scenario(file)) files.push_back(file);
  std::sort(files.begin(), files.end());
  return files;
}

/// "faults/stamps.yaml" is "faults_stamps".
inline std::string test_name(const testing::TestParamInfo<std::filesystem::path>& test) {
  std::string name = test.param.lexically_relative(scenario_folder()).replace_extension().string();
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
}

}  // namespace sim::bench
