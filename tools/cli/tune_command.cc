#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>

#include "sim/files/atomic_file.h"
#include "sim/pages/pages.h"
#include "sim/trials/tuning.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/jobs/recordings.h"
#include "tools/cli/jobs/trials.h"
#include "tools/cli/shared/model_files.h"
#include "tools/cli/shared/options.h"
#include "tools/cli/shared/out_folder.h"
#include "tools/cli/shared/version.h"

namespace cli {
namespace {

namespace scenario = sim::scenario;
namespace trials = sim::trials;

constexpr const char* kTuneExamples = R"(
Examples:
  gaitslam tune scenarios/tuning/circles.yaml --jobs 2
  gaitslam run scenarios/tangent_circle.yaml --with results/tune-circles/best.yaml
CMA-ES searches the whole range of the parameters. The results go to results/tune-<spec>, or to DIR: trials.jsonl (each
finished trial), history.csv, tune.json, report.html and best.yaml. Rerun the command to resume after an interruption,
with the same result. A folder with the result of another tuning is rejected. Recordings that the spec names by scenario
and seeds come from the cache; missing ones are recorded first. If its estimate steers a walk, each setting is
simulated. On Slurm each generation of CMA-ES is a job array.
To look at a grid or at samples instead of the best setting use gaitslam sweep.
Exit codes: 0 tuned; 1 worse than the start on the hold-out recordings, so that there is no best.yaml; 2 wrong usage
or configuration.)";

struct TuneRequest {
  std::string spec;
  OutRequest out;
  fs::path models = standard_models();
  Backend backend;
};

bool steered_by_estimate(const trials::RecordingSet& set) {
  return trials::first_scenario_of(set).scenario.walk.steering.by == walking::SteeredBy::estimate;
}

/// True if the estimate steers a walk: trials are then simulations instead of replays.
bool simulates_each_setting(const trials::Spec& spec) {
  return std::any_of(spec.training.begin(), spec.training.end(), steered_by_estimate) ||
         std::any_of(spec.holdout.begin(), spec.holdout.end(), steered_by_estimate);
}

/// Makes missing recordings of the spec and adds those of the cache to it. They are in use while the result
/// lives.
std::vector<sim::recording::CachedRecording> take_from_cache(trials::Spec& spec, const fs::path& models,
                                                             const Backend& backend) {
  std::vector<trials::RecordingSet*> cached;
  std::vector<scenario::ReadScenario> scenarios;
  for (auto* side : {&spec.training, &spec.holdout})
    for (trials::RecordingSet& set : *side)
      for (const std::uint64_t seed : set.seeds) {
        cached.push_back(&set);
        scenarios.push_back(scenario_of(set, seed));
        scenarios.back().scenario.seed = seed;
      }
  std::vector<sim::recording::CachedRecording> all;
  if (scenarios.empty()) return all;
  const Recordings recordings(models);
  const std::vector<Ended> ended = recordings.make(scenarios, backend);
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    const scenario::Scenario& scenario = scenarios[i].scenario;
    auto found = recordings.find(scenario);
    if (!found)
      throw UsageError(fmt::format("{} seed {} could not be recorded: {}", scenario.name, scenario.seed,
                                   ended[i].complaint));
    cached[i]->folders.push_back(found->folder);
    all.push_back(std::move(*found));
  }
  return all;
}

int tune_by(const TuneRequest& request) {
  require_usable(request.backend, request.out.out.value_or(""));
  trials::Spec spec = trials::read_spec(request.spec);
  if (!spec.warning.empty()) std::cerr << "gaitslam: warning: " << spec.warning << '\n';
  const fs::path standard = fs::path("results") / ("tune-" + spec.name);
  const OutFolder folder(
      request.out, standard,
      {.names = {"trials.jsonl", "history.csv", "tune.json", "best.yaml", "report.html", "parts/", "slurm/"},
       .continues = true});
  const fs::path& out = folder.path();
  Backend backend = request.backend;
  backend.spool = out / "slurm";
  const auto in_use = take_from_cache(spec, request.models, backend);
  trials::Execution execution{std::max(backend.jobs, 1)};
  const bool simulates = simulates_each_setting(spec);
  if (simulates || backend.slurm())
    execution.remote = in_processes({out / "parts", trials::log_purpose(program_identity(), spec),
                                     request.models, "tune " + request.spec},
                                    backend);
  if (simulates) std::cout << "an estimate steers a walk: each setting is simulated\n" << std::flush;
  trials::TuningResult result;
  {
    ProgressLine progress("tune " + spec.name);
    const auto show = [&](const trials::Progress& at) {
      progress.show(
          at.of == 0 ? 1 : static_cast<double>(at.tried) / at.of,
          at.of == 0 ? at.stage : fmt::format("{}, setting {}, best {:.5g}", at.stage, at.tried, at.best));
    };
    result = trials::tune(spec, out, execution, program_identity(), show);
  }
  remove_arrays(backend.spool);
  sim::files::write_atomically(out / "report.html", sim::pages::tune_page(out));
  std::cout << result.text << "results in " << out.string() << '\n';
  if (!result.accepted)
    std::cerr
        << "gaitslam: rejected: worse than the start on the hold-out recordings; best.yaml is not written\n";
  return result.accepted ? 0 : 1;
}

}  // namespace

void add_tune(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<TuneRequest>();
  CLI::App* command = app.add_subcommand("tune", "Search for the filter parameters that fit recordings best");
  command->add_option("spec", request->spec, "the YAML file of the tuning")->required();
  add_backend_options(*command, request->backend);
  add_models(*command, request->models);
  command->add_option("--out", request->out.out, "folder for the results");
  command->footer(kTuneExamples);
  command->callback([request, &exit_code] { exit_code = tune_by(*request); });
}

}  // namespace cli
