#include <fmt/format.h>

#include <algorithm>
#include <iostream>

#include "sim/files/atomic_file.h"
#include "sim/pages/pages.h"
#include "sim/trials/tuning.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/jobs/results.h"
#include "tools/cli/shared/options.h"
#include "tools/cli/shared/out_folder.h"
#include "tools/cli/shared/version.h"

namespace cli {
namespace {

constexpr const char* kTuneExamples = R"(Examples:
  gaitslam tune scenarios/tuning/circles.yaml --jobs 2
  gaitslam run scenarios/tangent_circle.yaml --with results/tune-circles/best.yaml
The results go to results/tune-<spec>, or to DIR: trials.jsonl (each finished trial), history.csv, tune.json,
report.html and best.yaml. Rerun the command to resume after an interruption, with the same result. Missing recordings
of the cache are made first. If its estimate steers a walk, each setting is simulated. To look at a grid or at samples
use gaitslam sweep.
Exit codes: 0 tuned; 1 worse than the start on the hold-out recordings, so that there is no best.yaml; 2 wrong usage
or configuration.)";

struct TuneRequest : OutRequest {
  std::string spec;
  fs::path models = standard_models();
  Backend backend;
};

/// Makes missing recordings of the spec and adds the folders of those of the cache to it. They are in use
/// while the result lives.
std::vector<recording::CachedRecording> take_from_cache(trials::Spec& spec, const fs::path& models,
                                                        const Backend& backend) {
  std::vector<trials::SpecRun*> runs;
  std::vector<scenario::ReadScenario> scenarios;
  for (auto* side : {&spec.training, &spec.holdout})
    for (trials::SpecRun& run : *side) {
      if (!run.folder.empty()) continue;
      runs.push_back(&run);
      scenarios.push_back(run.read);
      scenarios.back().scenario.seed = run.recorded_seed;
    }
  std::vector<recording::CachedRecording> all;
  if (runs.empty()) return all;
  const Recordings recordings(models);
  const std::vector<Recordings::Made> made = recordings.make(scenarios, backend);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    auto recording = recordings.find(scenarios[i].scenario);
    if (!recording)
      throw UsageError("{} seed {} could not be recorded: {}", scenarios[i].scenario.name,
                       runs[i]->recorded_seed, made[i].ended.complaint);
    runs[i]->folder = recording->folder;
    all.push_back(std::move(*recording));
  }
  return all;
}

int tune_by(TuneRequest& request) {
  require_usable(request.backend, request.out.value_or(""));
  trials::Spec spec = trials::read_spec(request.spec);
  const fs::path standard = fs::path("results") / ("tune-" + spec.name);
  const OutFolder folder(
      request, standard,
      {.names = {"trials.jsonl", "history.csv", "tune.json", "best.yaml", "report.html", "parts/", "slurm/"},
       .continues = true});
  const fs::path& out = folder.path();
  Backend backend = request.backend;
  backend.spool = out / "slurm";
  const auto in_use = take_from_cache(spec, request.models, backend);
  trials::Execution execution{std::max(backend.jobs, 1)};
  const auto steered = [](const trials::SpecRun& run) {
    return run.read.scenario.walk.steering.by == walking::SteeredBy::estimate;
  };
  const bool simulates = std::any_of(spec.training.begin(), spec.training.end(), steered) ||
                         std::any_of(spec.holdout.begin(), spec.holdout.end(), steered);
  if (simulates || backend.slurm())
    execution.remote = in_processes({out / "parts", trials::log_purpose(program_identity(), spec),
                                     request.models, "tune " + request.spec},
                                    backend);
  if (simulates) std::cout << "an estimate steers a walk: each setting is simulated\n" << std::flush;
  trials::TuningResult result;
  {
    ProgressLine progress("tune " + spec.name);
    result = trials::tune(spec, out, execution, program_identity(),
                          [&](double part, const std::string& at) { progress.show(part, at); });
  }
  remove_arrays(backend.spool);
  files::write_atomically(out / "report.html", pages::tune_page(out));
  std::cout << result.text << "results in " << out.string() << '\n';
  if (!result.accepted)
    std::cerr
        << "gaitslam: rejected: worse than the start on the hold-out recordings; best.yaml is not written\n";
  return result.accepted ? 0 : 1;
}

}  // namespace

void add_tune(CLI::App& app, int& exit_code) {
  auto [command, request] =
      add_command(app, exit_code, "tune", "Search for the filter parameters that fit recordings best",
                  kTuneExamples, tune_by);
  command.add_option("spec", request.spec, "the YAML file of the tuning")->required();
  add_backend_options(command, request.backend);
  add_models(command, request.models);
  command.add_option("--out", request.out, "folder for the results");
}

}  // namespace cli
