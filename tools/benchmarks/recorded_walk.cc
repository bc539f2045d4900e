#include "tools/benchmarks/recorded_walk.h"

#include <sstream>
#include <stdexcept>

#include "sim/result/score_input.h"
#include "sim/scenario/scenario.h"
#include "tools/benchmarks/cpu_time.h"

RecordedWalk::RecordedWalk(const std::filesystem::path& result_folder)
    : folder(result_folder), truth(sim::recording::read_truth(result_folder / "recording")) {
  sim::recording::RecordingReader reader(result_folder / "recording");
  setup = reader.setup();
  while (auto observation = reader.next()) observations.push_back(std::move(*observation));
}

Variant read_variant(std::string_view line) {
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos)
    throw std::invalid_argument("a variant is \"name: [key=value]...\", not \"" + std::string(line) + "\"");
  Variant variant{std::string(line.substr(0, colon)), {}, {}};
  std::istringstream words{std::string(line.substr(colon + 1))};
  for (std::string word; words >> word;) {
    if (word.starts_with("scenario="))
      variant.scenario = word.substr(9);
    else
      variant.changes.push_back(word);
  }
  return variant;
}

Trial try_on(const RecordedWalk& walk, const Variant& variant) {
  using namespace sim;
  const auto own = walk.folder / "scenario.yaml";
  scenario::Changes changes{variant.changes, {}};
  changes.overrides.insert(changes.overrides.begin(),
                           "seed=" + std::to_string(scenario::read_scenario(own).scenario.seed));
  const scenario::ReadScenario read = scenario::read_scenario(
      variant.scenario.empty() ? own : std::filesystem::path(variant.scenario), changes);
  tracking::Tracking tracking(read.scenario, walk.setup.calibration, walk.setup.X_WC_start);
  double spent_ms = 0;
  for (const slam::Observation& observation : walk.observations) {
    const double begin = cpu_ms();
    tracking.take(observation);
    spent_ms += cpu_ms() - begin;
  }
  Trial trial;
  trial.tracked = tracking.finish();
  trial.filter_ms = spent_ms / static_cast<double>(walk.observations.size());
  trial.run = result::score_input({read, "completed", "", walk.setup, walk.truth, trial.tracked, ""});
  trial.metrics = score::evaluate(trial.run);
  return trial;
}
