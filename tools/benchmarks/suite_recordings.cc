#include "tools/benchmarks/suite_recordings.h"

#include <array>
#include <cstdio>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "sim/scenario/scenario.h"

namespace {

std::string quoted(const std::string& word) { return "'" + word + "'"; }

/// What a shell command prints. Throws std::runtime_error where it fails.
std::string output_of(const std::string& command) {
  FILE* const pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
  std::string text;
  std::array<char, 4096> part;
  while (const std::size_t n = std::fread(part.data(), 1, part.size(), pipe)) text.append(part.data(), n);
  if (pclose(pipe) != 0) throw std::runtime_error("failed: " + command);
  return text;
}

/// The folders in "seed 1: was in the cache, completed: FOLDER".
std::vector<std::filesystem::path> folders_in(const std::string& text) {
  std::vector<std::filesystem::path> all;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (const auto at = line.find(": /"); line.starts_with("seed ") && at != std::string::npos)
      all.emplace_back(line.substr(at + 2));
  return all;
}

}  // namespace

std::vector<RecordedEntry> record_suite(const sim::regression::Suite& suite, const std::string& program) {
  std::vector<RecordedEntry> all;
  for (const sim::regression::SuiteEntry& entry : suite.entries) {
    std::string command = quoted(program) + " record " + quoted(entry.file.string());
    for (const std::string& change : entry.changes.overrides) command += " " + quoted(change);
    const auto read = sim::scenario::read_scenario(entry.file, entry.changes);
    all.push_back({read.scenario.name, entry.file, entry.changes.overrides,
                   folders_in(output_of(command + " --seeds " + suite.seeds))});
    if (all.back().folders.empty()) throw std::runtime_error("no recording by " + command);
  }
  return all;
}
