#include "sim/bench/result_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "sim/bench/scenario_limits.h"
#include "sim/bench/suite.h"
#include "sim/stream/file_error.h"

namespace sim::bench {
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
  const ReadScenario read = read_scenario(results.front() / "scenario.yaml");
  ResultSet set{{read.scenario.name, config_of(read), {}}, read.scenario, folder};
  for (const fs::path& result : results) set.results.seeds.push_back(read_result(result));
  auto& seeds = set.results.seeds;
  std::sort(seeds.begin(), seeds.end(), [](const auto& a, const auto& b) { return a.seed < b.seed; });
  const auto twice = std::adjacent_find(seeds.begin(), seeds.end(),
                                        [](const auto& a, const auto& b) { return a.seed == b.seed; });
  if (twice != seeds.end())
    throw stream::FileError(folder, fmt::format("seed {} is there twice", twice->seed));
  return set;
}

}  // namespace

int exit_code_of(const Scenario& scenario, const SeedScore& score) {
  const auto& allowed = scenario.limits.ending;
  if (std::find(allowed.begin(), allowed.end(), score.ending) == allowed.end()) return 3;
  const bool kept = std::all_of(scenario.limits.metrics.begin(), scenario.limits.metrics.end(),
                                [&](const MetricLimit& limit) {
                                  if (!limit.aggregate.empty() || !scenario.slam) return true;
                                  for (const SeedMetric& metric : score.metrics)
                                    if (metric.name == limit.metric)
                                      return metric.value && keeps(limit, *metric.value);
                                  return false;
                                });
  return kept ? 0 : 1;
}

SeedScore read_result(const fs::path& folder) {
  SeedScore score = read_score(folder / "score.json");
  std::ifstream in(folder / "about.json");
  const auto about = nlohmann::json::parse(in, nullptr, false);
  if (!about.is_object() || !about.contains("recording_xxh3_128"))
    throw stream::FileError(folder / "about.json", "expected JSON with recording_xxh3_128");
  score.recording = about["recording_xxh3_128"];
  score.exit_code = exit_code_of(read_scenario(folder / "scenario.yaml").scenario, score);
  return score;
}

std::vector<ResultSet> read_result_sets(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw stream::FileError(folder, "no such folder of results");
  if (is_result(folder)) return {read_set(folder.parent_path(), {folder})};
  if (const auto results = results_in(folder); !results.empty()) return {read_set(folder, results)};
  std::vector<ResultSet> sets;
  for (const fs::path& below : folders_in(folder))
    if (const auto results = results_in(below); !results.empty()) sets.push_back(read_set(below, results));
  if (sets.empty()) throw stream::FileError(folder, "has no result in it, expected seed-<n>/score.json");
  return sets;
}

}  // namespace sim::bench
