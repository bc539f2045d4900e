#include "sim/regression/result_set.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim/files/json.h"
#include "sim/regression/suite.h"
#include "sim/result/limits.h"

namespace sim::regression {
namespace {

namespace fs = std::filesystem;

bool is_result(const fs::path& folder) { return fs::exists(folder / "score.json"); }

// The folders below one, by name.
std::vector<fs::path> folders_in(const fs::path& folder) {
  std::vector<fs::path> all;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory()) all.push_back(entry.path());
  std::sort(all.begin(), all.end());
  return all;
}

std::vector<fs::path> results_in(const fs::path& folder) {
  std::vector<fs::path> all = folders_in(folder);
  std::erase_if(all, [](const fs::path& f) { return !is_result(f); });
  return all;
}

ResultSet read_set(const fs::path& folder, const std::vector<fs::path>& results) {
  const scenario::ReadScenario read = scenario::read_scenario(results.front() / "scenario.yaml");
  ResultSet set{{read.scenario.name, config_of(read), {}}, read.scenario, folder};
  for (const fs::path& result : results) set.results.seeds.push_back(read_result(result));
  auto& seeds = set.results.seeds;
  std::sort(seeds.begin(), seeds.end(), [](const auto& a, const auto& b) { return a.seed < b.seed; });
  const auto twice = std::adjacent_find(seeds.begin(), seeds.end(),
                                        [](const auto& a, const auto& b) { return a.seed == b.seed; });
  if (twice != seeds.end()) throw files::FileError(folder, fmt::format("has seed {} twice", twice->seed));
  return set;
}

}  // namespace

result::SeedScore read_result(const fs::path& folder) {
  result::SeedScore score = result::read_score(folder / "score.json");
  score.recording = files::read_json(folder / "about.json").at("recording_xxh3_128").text();
  const scenario::Scenario scenario = scenario::read_scenario(folder / "scenario.yaml").scenario;
  const auto limits = result::judge_run(scenario, [&](const std::string& name) { return score.value(name); });
  score.exit_code = result::exit_code(scenario, score.ending, limits);
  return score;
}

std::vector<ResultSet> read_result_sets(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw files::FileError(folder, "is no folder of results");
  if (is_result(folder)) return {read_set(folder.parent_path(), {folder})};
  if (const auto results = results_in(folder); !results.empty()) return {read_set(folder, results)};
  std::vector<ResultSet> sets;
  for (const fs::path& below : folders_in(folder))
    if (const auto results = results_in(below); !results.empty()) sets.push_back(read_set(below, results));
  if (sets.empty()) throw files::FileError(folder, "contains no result, expected seed-<n>/score.json");
  return sets;
}

}  // namespace sim::regression
