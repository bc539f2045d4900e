#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>

#include "sim/files/atomic_file.h"
#include "sim/files/json.h"
#include "sim/files/output_manifest.h"
#include "sim/pages/pages.h"
#include "sim/tune/tuning.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/jobs/slurm.h"
#include "tools/cli/jobs/trial_parts.h"
#include "tools/cli/model_files.h"
#include "tools/cli/options.h"
#include "tools/cli/out_folder.h"
#include "tools/cli/recordings.h"
#include "tools/cli/version.h"

namespace cli {
namespace {

namespace scenario = sim::scenario;
namespace tune = sim::tune;

constexpr const char* kTuneExamples = R"(
Examples:
  gaitslam tune scenarios/tuning/circles.yaml --jobs 2
  gaitslam run scenarios/tangent_circle.yaml --with results/tune-circles/best.yaml
CMA-ES searches the whole range of the parameters, then Nelder and Mead's method polishes the best setting, and the
loss is profiled along each parameter. The results go to results/tune-<spec>, or to DIR: trials.jsonl (each finished
trial), history.csv, tune.json, report.html and best.yaml. After an interruption the same command continues, and ends
with the same result. A folder with the result of a tuning of another name is refused. Recordings that the spec names
by scenario and seeds are taken from the cache, and recorded there first if they are missing. A walk that is steered
by its estimate is simulated anew with each setting. On Slurm each generation of CMA-ES is a job array, and so is each
setting of the polish.
To look at a grid or at samples instead of the best setting use gaitslam sweep.
Exit codes: 0 tuned; 1 worse than the start on the hold-out recordings, so that there is no best.yaml; 2 wrong usage
or configuration.)";

struct TuneRequest {
  std::string spec;
  OutRequest out;
  fs::path models = standard_models();
  Backend backend;
};

/// Settings that a tuning tries unless its profiles find a better one: the search, and eight for each
/// profile.
int planned_settings(const tune::Spec& spec) {
  return spec.trials + (spec.profiles ? 8 * static_cast<int>(spec.parameters.size()) : 0);
}

std::string stage_text(const tune::Progress& at) {
  return at.of == 0 ? at.stage : fmt::format("{}, setting {}, best {:.5g}", at.stage, at.tried, at.best);
}

bool steered_by_estimate(const tune::RecordingSet& set) {
  return tune::first_scenario_of(set).scenario.walk.steering.by == walking::SteeredBy::estimate;
}

/// Whether the spec has walks that each setting of the filter steers differently, so that its trials are
/// simulations instead of replays.
bool simulates_each_setting(const tune::Spec& spec) {
  return std::any_of(spec.training.begin(), spec.training.end(), steered_by_estimate) ||
         std::any_of(spec.holdout.begin(), spec.holdout.end(), steered_by_estimate);
}

/// Finds the recordings that the spec takes from the cache, after making those that are missing. They are in
/// use while the result lives.
std::vector<tune::CachedRecording> take_from_cache(tune::Spec& spec, const fs::path& models,
                                                   const Backend& backend) {
  std::vector<tune::RecordingSet*> cached;
  std::vector<scenario::ReadScenario> scenarios;
  for (auto* side : {&spec.training, &spec.holdout})
    for (tune::RecordingSet& set : *side)
      for (const std::uint64_t seed : set.seeds) {
        cached.push_back(&set);
        scenarios.push_back(scenario_of(set, seed));
        scenarios.back().scenario.seed = seed;
      }
  std::vector<tune::CachedRecording> all;
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

/// Runs trials in processes of their own, which can simulate: here, or as elements of job arrays.
tune::RunTasks run_in_processes(const TuneRequest& request, const fs::path& out, const Backend& backend) {
  return [&request, out, backend](const std::vector<tune::Task>& tasks, tune::TrialLog& log) {
    run_parts(tasks, log,
              {out / "parts", tune::log_purpose(program_identity()), request.models, "tune " + request.spec},
              backend);
  };
}

/// Throws UsageError where the folder holds the finished result of a tuning of another name.
void require_same_tuning(const fs::path& out, const tune::Spec& spec) {
  const auto made = sim::files::listed_in(out);
  if (!made || !made->contains("tune.json") || !fs::exists(out / "tune.json")) return;
  const std::string name = sim::files::read_json(out / "tune.json").at("name").text();
  if (name != spec.name)
    throw UsageError(fmt::format("{}: holds the result of the tuning {}, not of {}; name another folder",
                                 out.string(), name, spec.name));
}

int tune_by(const TuneRequest& request) {
  require_usable(request.backend, request.out.out.value_or(""));
  tune::Spec spec = tune::read_spec(request.spec);
  const fs::path standard = fs::path("results") / ("tune-" + spec.name);
  require_same_tuning(request.out.out.value_or(standard.string()), spec);
  const OutFolder folder(
      request.out, standard,
      {.names = {"trials.jsonl", "history.csv", "tune.json", "best.yaml", "report.html", "parts/", "slurm/"},
       .continues = true});
  const fs::path& out = folder.path();
  Backend backend = request.backend;
  backend.spool = out / "slurm";
  const auto in_use = take_from_cache(spec, request.models, backend);
  tune::Execution execution{std::max(backend.jobs, 1)};
  const bool simulates = simulates_each_setting(spec);
  if (simulates || backend.slurm()) execution.remote = run_in_processes(request, out, backend);
  if (simulates)
    std::cout << "a walk is steered by its estimate: it is simulated anew with each setting\n" << std::flush;
  tune::TuningResult result;
  {
    ProgressLine progress("tune " + spec.name);
    const int planned = planned_settings(spec);
    const auto show = [&](const tune::Progress& at) {
      const int of = at.of == 0 ? 0 : std::max(at.of, planned);
      progress.show(of == 0 ? 1 : static_cast<double>(at.tried) / of, stage_text(at));
    };
    result = tune::tune(spec, out, execution, program_identity(), show);
  }
  remove_arrays(backend.spool);
  sim::files::write_atomically(out / "report.html", sim::pages::tune_page(out));
  std::cout << result.text << "results in " << out.string() << '\n';
  if (!result.accepted)
    std::cerr
        << "gaitslam: refused: worse than the start on the hold-out recordings; best.yaml is not written\n";
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
