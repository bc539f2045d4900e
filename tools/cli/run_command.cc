#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "sim/files/text.h"
#include "sim/regression/result_set.h"
#include "sim/replay/replay.h"
#include "sim/result/summary.h"
#include "sim/scenario/yaml.h"
#include "sim/tune/recording_key.h"
#include "tools/cli/commands.h"
#include "tools/cli/finished.h"
#include "tools/cli/jobs/batch.h"
#include "tools/cli/jobs/earlier.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/jobs/terminal.h"
#include "tools/cli/live.h"
#include "tools/cli/model_files.h"
#include "tools/cli/options.h"
#include "tools/cli/out_folder.h"
#include "tools/cli/recordings.h"
#include "tools/cli/version.h"
#include "tools/cli/view_session.h"

namespace cli {
namespace {

namespace replay = sim::replay;
namespace result = sim::result;
namespace scenario = sim::scenario;

constexpr const char* kRunExamples = R"(
Examples:
  gaitslam run scenarios/tangent_circle.yaml
  gaitslam run scenarios/tangent_circle.yaml seed=7 slam.gyro.sigma_rad_s=0.02 --out DIR
  gaitslam run scenarios/tangent_circle.yaml --seeds 1..5 --jobs 2 --without camera,slam
  gaitslam run scenarios/tangent_circle.yaml --json > outcome.json
  gaitslam run scenarios/tangent_circle.yaml --view --control
Results go to results/<scenario>/seed-<n>, replacing earlier ones, or to DIR/seed-<n>. Only what gaitslam made is
replaced, each result when the new one is whole. With --seeds, results of other seeds there are moved to earlier-<n>,
and after an interruption the same command goes on with the seeds that are left.
Exit codes: 0 passed; 1 missed a limit; 2 wrong usage or configuration; 3 fell, collided, diverged or crashed. Of several seeds
the highest.)";

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
  constexpr double kWalk = 0.7;  // part of the time that the walk takes, where it is missing
  bool walked = false;
  const auto walking = [&](double part) { walked = true, progress(kWalk * part); };
  const auto replaying = [&](double part) { progress(walked ? kWalk + (1 - kWalk) * part : part); };
  const auto recording = Recordings(place.models).get(read, walking);
  return replay::replay(read, recording.folder / "recording", replay::read_walk_end(recording.folder), place,
                        replaying, replay::Recorded::copied);
}

/// One of several runs at once has one core.
int threads(const RunRequest& request) { return request.jobs.value_or(request.batch.parent ? 1 : 2); }

int run_one(const scenario::ReadScenario& read, const RunRequest& request, const fs::path& root) {
  const fs::path folder = root / fmt::format("seed-{}", read.scenario.seed);
  const auto view = view_of_run(request.view, read, request.models);
  result::Outcome outcome;
  {
    ProgressLine progress(fmt::format("{} seed {}", read.scenario.name, read.scenario.seed));
    const result::ResultPlace place{
        folder,      sim::files::Existing::replace,         request.models, kVersion, kRevision,
        libraries(), sim::tune::models_hash(request.models)};
    const auto show = [&](double part) { progress.show(part); };
    outcome = request.cached
                  ? run_cached(read, place, show)
                  : run_live(read, place, show, threads(request), view ? &view->run_observer() : nullptr);
  }
  if (view)
    view->end(fmt::format("The run has ended: {}. gaitslam view {} shows it again.",
                          sim::scenario::name_of(outcome.ending), folder.string()));
  return cli::report(outcome, folder, request.all_metrics);
}

/// Prints once what several seeds complain of alike.
void print_complaints(const std::vector<SeedOutcome>& outcomes) {
  std::map<std::string, std::vector<std::uint64_t>> seeds;
  for (const SeedOutcome& outcome : outcomes)
    if (outcome.exit_code > 1) seeds[outcome.complaint].push_back(outcome.seed);
  for (const auto& [complaint, of] : seeds)
    std::cerr << fmt::format("seed{} {}: {}", of.size() > 1 ? "s" : "", fmt::join(of, ", "), complaint);
}

void require_one_walk_to_view(const RunRequest& request) {
  if (request.view.view && (request.seeds || request.cached))
    throw UsageError(fmt::format("--view shows one walk as it goes on, expected no {}",
                                 request.seeds ? "--seeds" : "--cached"));
}

void require_no_seed_typed(const RunRequest& request) {
  const bool seed_typed =
      std::any_of(request.changes.overrides.begin(), request.changes.overrides.end(),
                  [](const std::string& argument) { return argument.starts_with("seed="); });
  if (seed_typed) throw UsageError("--seeds and seed= are both given, expected one of them");
}

/// The score of each seed: of those that were run, and of those that were finished before.
std::vector<result::SeedScore> read_scores(const fs::path& root, const std::vector<std::uint64_t>& seeds,
                                           const std::vector<SeedOutcome>& outcomes) {
  std::vector<result::SeedScore> scores;
  for (const std::uint64_t seed : seeds) {
    const auto ran = std::find_if(outcomes.begin(), outcomes.end(),
                                  [seed](const SeedOutcome& outcome) { return outcome.seed == seed; });
    scores.push_back(ran == outcomes.end() ? sim::regression::read_result(root / fmt::format("seed-{}", seed))
                                           : result::read_seed_score(root, seed, ran->exit_code));
  }
  return scores;
}

int run_seeds(const scenario::ReadScenario& read, const RunRequest& request) {
  require_no_seed_typed(request);
  const std::vector<std::uint64_t> seeds = parse_seeds(*request.seeds);
  const std::string identity =
      identity_of_runs({inputs_of(read.scenario), sim::tune::models_hash(request.models)}, seeds,
                       request.cached ? "cached" : "");
  std::vector<std::string> results;
  for (const std::uint64_t seed : seeds) results.push_back(fmt::format("seed-{}", seed));
  const OutFolder out(request, standard_folder(read),
                      {.names = {"summary.json"}, .results = std::move(results), .identity = identity});
  const fs::path& root = out.path();
  const auto left = unfinished(out, "", read.scenario, seeds);
  if (left.size() < seeds.size())
    text_out() << fmt::format("{} finished before\n",
                              sim::files::counted(seeds.size() - left.size(), "seed"));
  Batch batch{
      left, root, request.models, {}, read.origin, request.cached, {.jobs = request.jobs.value_or(1)}};
  batch.on_made = [&out](std::uint64_t seed) { out.note_made(fmt::format("seed-{}", seed)); };
  const auto outcomes = run_batch(read.scenario, batch);
  const std::vector<result::SeedScore> scores = read_scores(root, seeds, outcomes);
  set_aside(root, results_of_other_seeds(root, seeds));
  print_complaints(outcomes);
  const result::Summary summary = result::summarize(read.scenario, scores);
  result::write_summary(root / "summary.json", summary);
  out.finished();
  const int exit_code = result::exit_code(summary);
  if (output() == Output::json) print_outcome(exit_code, root, {{"summary", result::to_json(summary)}});
  text_out() << result::summary_table(summary, {colours(), request.all_metrics}) << "results in "
             << root.string() << '\n';
  return exit_code;
}

int run(const RunRequest& request) {
  if (request.batch.parent) die_with(*request.batch.parent);
  require_simulator();
  require_one_walk_to_view(request);
  scenario::ReadScenario read = scenario::read_scenario(request.scenario, request.changes);
  if (request.batch.set_by) take_origin(read, *request.batch.set_by);
  require_models(read, request.models);
  if (request.seeds) require_clear_walk(read, request.models);  // once, and by the name of the user's file
  if (request.seeds) return run_seeds(read, request);
  const OutFolder out(request, standard_folder(read),
                      {.results = {fmt::format("seed-{}", read.scenario.seed)}});
  return run_one(read, request, out.path());
}

}  // namespace

void add_run(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<RunRequest>();
  CLI::App* command = app.add_subcommand("run", "Simulate a walk, run the filter on it and score both");
  add_scenario(*command, request->scenario, request->changes)->required();
  add_seeds(*command, request->seeds);
  add_jobs(
      *command, request->jobs,
      "number of cores to use: processes at a time with --seeds (1 unless given), otherwise 1 or 2 (2 unless "
      "given: images are rendered beside the walk)");
  add_out(*command, *request);
  add_models(*command, request->models);
  command->add_flag(
      "--cached", request->cached,
      "replay the recording of this walk from the cache; record it there first if it is missing");
  add_all_metrics(*command, request->all_metrics);
  add_output(*command);
  add_view(*command, request->view);
  add_batch_member(*command, request->batch);
  command->footer(kRunExamples);
  command->callback([request, &exit_code] { exit_code = run(*request); });
}

}  // namespace cli
