#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "sim/replay/replay.h"
#include "sim/result/limits.h"
#include "sim/scenario/recording_key.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/jobs/results.h"
#include "tools/cli/shared/live.h"
#include "tools/cli/shared/options.h"
#include "tools/cli/shared/out_folder.h"
#include "tools/cli/shared/version.h"

namespace cli {
namespace {

constexpr const char* kRunExamples = R"(
Examples:
  gaitslam run scenarios/tangent_circle.yaml seed=7 slam.gyro.sigma_rad_s=0.02 --out DIR
  gaitslam run scenarios/tangent_circle.yaml --seeds 1..5 --jobs 2 --without camera,slam
  gaitslam run scenarios/tangent_circle.yaml --view --control
Results go to results/<scenario>/seed-<n>, replacing earlier ones, or to DIR/seed-<n>. Only files that gaitslam made are
replaced, each result when the new one is whole. With --seeds, results of other seeds there are moved to earlier-<n>;
after an interruption, rerun the command to resume.
Exit codes: 0 passed; 1 missed a limit; 2 wrong usage or configuration; 3 fell, collided, diverged or crashed. The highest
of several seeds counts.)";

struct RunRequest : OutRequest {
  std::string scenario;
  std::optional<std::string> seeds;
  scenario::Changes changes;
  fs::path models = standard_models();
  std::optional<int> jobs;
  bool cached = false, all_metrics = false;
  ViewRequest view;
  BatchMember batch;
};

fs::path standard_folder(const scenario::ReadScenario& read) {
  return fs::path("results") / read.scenario.name;
}

/// Replays the recording from the cache. Writes the bytes of run_live, timing.* excepted.
result::Outcome run_cached(const scenario::ReadScenario& read, const result::ResultPlace& place,
                           const result::Progress& progress) {
  constexpr double kWalk = 0.7;  // part of the time that a missing walk takes
  bool walked = false;
  const auto walking = [&](double part) { walked = true, progress(kWalk * part); };
  const auto replaying = [&](double part) { progress(walked ? kWalk + (1 - kWalk) * part : part); };
  const auto recording = Recordings(place.models).get(read, walking);
  return replay::replay(read, recording.folder / "recording", replay::read_walk_end(recording.folder), place,
                        replaying, replay::Recorded::copied);
}

int run_one(const scenario::ReadScenario& read, const RunRequest& request, const fs::path& root) {
  const fs::path folder = root / fmt::format("seed-{}", read.scenario.seed);
  const auto view = view_of_run(request.view, read, request.models);
  result::Outcome outcome;
  {
    ProgressLine progress(fmt::format("{} seed {}", read.scenario.name, read.scenario.seed));
    const result::ResultPlace place =
        result_place(folder, scenario::models_hash(request.models), request.models);
    const auto show = [&](double part) { progress.show(part); };
    const int threads =
        request.jobs.value_or(request.batch.parent ? 1 : 2);  // a process of several has one core
    outcome = request.cached ? run_cached(read, place, show)
                             : run_live(read, place, show, threads, view ? &view->run_observer() : nullptr);
  }
  if (view)
    view->end(fmt::format("The run has ended: {}. gaitslam view {} shows it again.",
                          sim::scenario::name_of(outcome.ending), folder.string()));
  const int exit_code = cli::report(outcome, folder, request.all_metrics);
  const auto is_over_seeds = [](const scenario::MetricLimit& limit) { return !limit.aggregate.empty(); };
  if (std::ranges::any_of(read.scenario.limits.metrics, is_over_seeds))
    text_out() << "limits over seeds (mean, median or worst) are judged with --seeds only\n";
  return exit_code;
}

int run_seeds(const scenario::ReadScenario& read, const RunRequest& request) {
  for (const std::string& argument : request.changes.overrides)
    if (argument.starts_with("seed="))
      throw UsageError("--seeds and seed= are both given, expected one of them");
  const auto jobs = jobs_of_seeds({read, ""}, parse_seeds(*request.seeds));
  const OutFolder out(request, standard_folder(read),
                      {.names = {"summary.json"},
                       .results = results_of(jobs),
                       .identity = identity_of(
                           jobs, {scenario::models_hash(request.models), request.cached ? "cached" : ""})});
  const fs::path& root = out.path();
  const auto ended = make_results(jobs, out,
                                  {.models = request.models,
                                   .title = fmt::format("{} seeds of {}", jobs.size(), read.scenario.name),
                                   .backend = {.jobs = request.jobs.value_or(1)},
                                   .cached = request.cached});
  print_complaints(jobs, ended);
  const result::Summary summary = result::summarize(read.scenario, read_scores(jobs, ended, root));
  result::write_summary(root / "summary.json", summary);
  out.finished();
  const int exit_code = result::exit_code(summary);
  if (output() == Output::json) print_outcome(exit_code, root, {{"summary", result::to_json(summary)}});
  text_out() << result::summary_table(summary, {colours(), request.all_metrics}) << "results in "
             << root.string() << '\n';
  return exit_code;
}

int run(RunRequest& request) {
  require_simulator();
  if (request.view.view && (request.seeds || request.cached))
    throw UsageError(
        fmt::format("--view shows one live walk, expected no {}", request.seeds ? "--seeds" : "--cached"));
  scenario::ReadScenario read = scenario::read_scenario(request.scenario, request.changes);
  join_batch(request.batch, &read);
  require_models(read, request.models);
  if (request.seeds) require_clear_walk(read, request.models);  // once, with the name of the given file
  if (request.seeds) return run_seeds(read, request);
  const OutFolder out(request, standard_folder(read),
                      {.results = {fmt::format("seed-{}", read.scenario.seed)}});
  return run_one(read, request, out.path());
}

}  // namespace

void add_run(CLI::App& app, int& exit_code) {
  auto [command, request] = add_command(
      app, exit_code, "run", "Simulate a walk, run the filter on it and score both", kRunExamples, run);
  add_scenario(command, request.scenario, request.changes)->required();
  add_seeds(command, request.seeds, "run several seeds, each in its own process");
  add_jobs(command, request.jobs,
           "processes at a time with --seeds (default 1); else cores, 1 or 2 (default)");
  add_out(command, request);
  add_models(command, request.models);
  add_cached(command, request.cached);
  add_all_metrics(command, request.all_metrics);
  add_output(command);
  add_view(command, request.view);
  add_batch_member(command, request.batch);
}

}  // namespace cli
