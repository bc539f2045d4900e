#include "tools/benchmarks/recorded_walk.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "sim/result/score_input.h"
#include "sim/scenario/scenario.h"
#include "tools/benchmarks/cpu_time.h"

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
  trial.run = result::score_input({read, "completed", "", walk.setup, walk.truth, trial.tracked, ""});
  trial.metrics = score::evaluate(trial.run);
  return trial;
}
