#include "sim/scenario/recording_key.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "sim/files/hash.h"
#include "sim/files/text.h"
#include "sim/scenario/keys.h"

namespace sim::scenario {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_below(const fs::path& folder) {
  std::error_code fault;
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder, fault))
    if (entry.is_regular_file() && entry.path().extension() != ".md") files.push_back(entry.path());
  if (fault || files.empty()) throw files::FileError(folder, "has no models");
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

std::string models_hash(const fs::path& models) {
  files::Hash hash;
  for (const fs::path& file : files_below(models)) {
    hash.add_part(file.lexically_relative(models).generic_string());
    hash.add_part(files::read_text(file));
  }
  return hash.hex();
}

std::string recording_key(const Scenario& scenario, const std::string& models_hash,
                          const std::string& program) {
  files::Hash hash;
  hash.add_part("recording 1");
  hash.add_part(program);
  hash.add_part(models_hash);
  hash.add_part(fmt::format("seed {}", scenario.seed));
  for (const auto& key : scenario_keys()) {
    if (!shapes_recording(scenario, key.name) || !has_section(scenario, key.name)) continue;
    hash.add_part(key.name);
    hash.add_part(key.print(scenario));
  }
  return hash.hex();
}

std::optional<RecordingDifference> first_difference(const Scenario& recorded, const Scenario& scenario) {
  for (const auto& key : scenario_keys()) {
    if (!shapes_recording(key.name) || !has_section(recorded, key.name)) continue;
    const std::string there = key.print(recorded),
                      now = has_section(scenario, key.name) ? key.print(scenario) : "left out";
    if (there != now) return RecordingDifference{key.name, there, now};
  }
  return std::nullopt;
}

std::string counterfactual(const Scenario& recorded, const Scenario& scenario) {
  if (recorded.walk.steering.by != walking::SteeredBy::estimate) return "";
  if (recorded.estimator_time.model == TimeModel::measured)
    return "the recorded walk was steered by answers whose measured times are not repeatable";
  if (recorded.seed != scenario.seed)
    return fmt::format("the recorded walk was steered with seed {}, not {}", recorded.seed, scenario.seed);
  for (const auto& key : scenario_keys()) {
    if (!shapes_estimate(key.name) || !has_section(recorded, key.name)) continue;
    const std::string there = key.print(recorded), now = key.print(scenario);
    if (there != now)
      return fmt::format("the recorded walk was steered by an estimate with {} {}, not {}", key.name, there,
                         now);
  }
  return "";
}

}  // namespace sim::scenario
