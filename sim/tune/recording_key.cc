#include "sim/tune/recording_key.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "sim/files/hash.h"
#include "sim/files/text.h"
#include "sim/scenario/keys.h"

namespace sim::tune {
namespace {

namespace fs = std::filesystem;

void add_part(files::Hash& hash, std::string_view part) {
  hash.add(fmt::format("{}:", part.size()));
  hash.add(part);
}

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
    add_part(hash, file.lexically_relative(models).generic_string());
    add_part(hash, files::read_text(file));
  }
  return hash.hex();
}

std::string recording_key(const scenario::Scenario& scenario, const std::string& models_hash,
                          const std::string& program) {
  files::Hash hash;
  add_part(hash, "recording 1");
  add_part(hash, program);
  add_part(hash, models_hash);
  add_part(hash, fmt::format("seed {}", scenario.seed));
  for (const auto& key : scenario::scenario_keys()) {
    if (!scenario::shapes_recording(scenario, key.name) || !scenario::has_section(scenario, key.name))
      continue;
    add_part(hash, key.name);
    add_part(hash, key.print(scenario));
  }
  return hash.hex();
}

std::optional<RecordingDifference> first_difference(const scenario::Scenario& recorded,
                                                    const scenario::Scenario& scenario) {
  for (const auto& key : scenario::scenario_keys()) {
    if (!scenario::shapes_recording(key.name) || !scenario::has_section(recorded, key.name)) continue;
    const std::string there = key.print(recorded),
                      now = scenario::has_section(scenario, key.name) ? key.print(scenario) : "left out";
    if (there != now) return RecordingDifference{key.name, there, now};
  }
  return std::nullopt;
}

std::string counterfactual(const scenario::Scenario& recorded, const scenario::Scenario& scenario) {
  if (recorded.walk.steering.by != walking::SteeredBy::estimate) return "";
  if (recorded.seed != scenario.seed)
    return fmt::format("the recorded walk was steered with seed {}, not {}", recorded.seed, scenario.seed);
  for (const auto& key : scenario::scenario_keys()) {
    if (!scenario::shapes_estimate(key.name) || !scenario::has_section(recorded, key.name)) continue;
    const std::string there = key.print(recorded), now = key.print(scenario);
    if (there != now)
      return fmt::format("the recorded walk was steered by an estimate with {} {}, not {}", key.name, there,
                         now);
  }
  return "";
}

}  // namespace sim::tune
