#include "tools/benchmarks/recorded_walks.h"

#include <time.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <sstream>
#include <stdexcept>

#include "sim/result/score_input.h"
#include "sim/scenario/scenario.h"

namespace {

std::string quoted(const std::string& word) { return "'" + word + "'"; }

/// The output of a shell command. Throws std::runtime_error if it fails.
std::string output_of(const std::string& command) {
  FILE* const pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
  std::string text;
  std::array<char, 4096> part;
  while (const std::size_t n = std::fread(part.data(), 1, part.size(), pipe)) text.append(part.data(), n);
  if (pclose(pipe) != 0) throw std::runtime_error("failed: " + command);
  return text;
}

/// The folders in lines such as "seed 1: was in the cache, completed: FOLDER".
std::vector<std::filesystem::path> folders_in(const std::string& text) {
  std::vector<std::filesystem::path> all;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (const auto at = line.find(": /"); line.starts_with("seed ") && at != std::string::npos)
      all.emplace_back(line.substr(at + 2));
  return all;
}

/// CPU time of the process, all threads counted.
double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

}  // namespace

RecordedWalk::RecordedWalk(const std::filesystem::path& result_folder)
    : seed(sim::scenario::read_scenario(result_folder / "scenario.yaml").scenario.seed),
      truth(sim::recording::read_truth(result_folder / "recording")) {
  sim::recording::RecordingReader reader(result_folder / "recording");
  setup = reader.setup();
  while (auto observation = reader.next()) observations.push_back(std::move(*observation));
}

void RecordedWalk::take_images_of(const RecordedWalk& other) {
  for (std::size_t i = 0; i < std::min(observations.size(), other.observations.size()); ++i)
    observations[i].image = other.observations[i].image;
}

Variant read_variant(std::string_view line) {
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos)
    throw std::invalid_argument("a variant is \"name: [key=value]...\", not \"" + std::string(line) + "\"");
  Variant variant{std::string(line.substr(0, colon)), {}};
  std::istringstream words{std::string(line.substr(colon + 1))};
  for (std::string word; words >> word;) variant.changes.push_back(word);
  return variant;
}

Trial try_on(const RecordedWalk& walk, const std::filesystem::path& scenario,
             const std::vector<std::string>& changes) {
  using namespace sim;
  scenario::Changes with_seed{changes, {}};
  with_seed.overrides.push_back("seed=" + std::to_string(walk.seed));
  const scenario::ReadScenario read = scenario::read_scenario(scenario, with_seed);
  tracking::Tracking tracking(read.scenario, walk.setup.calibration, walk.setup.X_WC_start);
  double spent_ms = 0;
  for (const slam::Observation& observation : walk.observations) {
    const double begin = cpu_ms();
    tracking.process(observation);
    spent_ms += cpu_ms() - begin;
  }
  Trial trial;
  trial.tracked = tracking.finish();
  trial.filter_ms = spent_ms / static_cast<double>(walk.observations.size());
  trial.run =
      result::score_input({read, {scenario::Ending::completed}, walk.setup, walk.truth, trial.tracked, ""});
  trial.metrics = score::evaluate(trial.run);
  return trial;
}

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
