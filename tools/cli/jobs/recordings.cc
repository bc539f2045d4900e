#include "tools/cli/jobs/recordings.h"

#include <fmt/format.h>

#include <iostream>
#include <nlohmann/json.hpp>

#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/scenario/recording_key.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/shared/live.h"
#include "tools/cli/shared/version.h"

namespace cli {
namespace {

namespace fs = std::filesystem;
namespace result = sim::result;
namespace scenario = sim::scenario;

void report_damage(const std::string& what) {
  std::cerr << fmt::format("gaitslam: ignored a damaged recording in the cache: {}\n", what);
}

}  // namespace

Recordings::Recordings(fs::path models)
    : models_(std::move(models)),
      models_hash_(sim::scenario::models_hash(models_)),
      program_(recording_identity()),
      cache_(sim::recording::cache_place()) {}

std::string Recordings::key(const scenario::Scenario& scenario) const {
  std::string programs = program_;
  // The estimator and its inputs shape a walk that the estimate steers.
  if (scenario.walk.steering.by == walking::SteeredBy::estimate)
    programs += program_identity() + sim::estimators::estimator_files_identity(scenario.estimator);
  return sim::scenario::recording_key(scenario, models_hash_, programs);
}

std::optional<sim::recording::CachedRecording> Recordings::find(const scenario::Scenario& scenario) const {
  return cache_.find(key(scenario), report_damage);
}

sim::recording::CachedRecording Recordings::get(const scenario::ReadScenario& read,
                                                const result::Progress& progress) const {
  const auto walk = [&](const fs::path& folder) {
    scenario::ReadScenario recorded = read;
    if (read.scenario.walk.steering.by != walking::SteeredBy::estimate) recorded.scenario.slam.reset();
    run_live(recorded,
             {folder, sim::files::Existing::reject, models_, kVersion, kRevision, libraries(), models_hash_},
             progress);
  };
  return cache_.get(key(read.scenario), {read.scenario.name, read.scenario.seed}, walk, report_damage);
}

std::vector<Ended> Recordings::make(const std::vector<scenario::ReadScenario>& scenarios,
                                    const Backend& backend) const {
  SharedFolder shared(backend);
  CommandLines lines;
  std::vector<std::size_t> missing;
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    const scenario::Scenario& walked = scenarios[i].scenario;
    if (find(walked)) continue;
    const fs::path frozen = shared / (key(walked) + ".yaml"), set_by = shared / (key(walked) + ".json");
    sim::files::write_text(frozen, scenario::to_yaml(walked));
    sim::files::write_text(set_by, sim::files::json_text(nlohmann::ordered_json(scenarios[i].origin)));
    lines.push_back({{"record", frozen.string(), "--models", fs::absolute(models_).string(), "--set-by",
                      set_by.string()}});
    missing.push_back(i);
  }
  if (!missing.empty()) require_simulator();
  std::vector<Ended> all(scenarios.size());
  ProgressLine progress(fmt::format("{} recordings", missing.size()));
  const std::vector<Ended> ended = run_all(lines, backend, [&](double part) { progress.show(part); });
  for (std::size_t i = 0; i < missing.size(); ++i) all[missing[i]] = ended[i];
  return all;
}

}  // namespace cli
