#include <iostream>

#include "sim/replay/replay.h"
#include "sim/result/limits.h"
#include "sim/scenario/keys.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/jobs/results.h"
#include "tools/cli/shared/live.h"
#include "tools/cli/shared/options.h"
#include "tools/cli/shared/version.h"

namespace cli {
namespace {

constexpr const char* kRunExamples = R"(Examples:
  gaitslam run scenarios/tangent_circle.yaml seed=7 slam.gyro.sigma_rad_s=0.02 --out DIR
  gaitslam run scenarios/tangent_circle.yaml --seeds 1..5 --jobs 2 --without camera,slam
  gaitslam run scenarios/tangent_circle.yaml --view --control
Results are written to results/<scenario>/seed-<n> or DIR/seed-<n>. With --seeds, missing seeds are added, and those with
the same settings and program are kept; after an interruption, rerun the command to resume. If a seed of the folder has other
settings, the command ends with an error that names them. --force replaces a result when the new one is complete.
Exit codes: 0 passed; 1 missed a limit; 2 wrong usage or configuration; 3 fell, collided, diverged or crashed. With several
seeds, the highest counts.)";

struct RunRequest : OutRequest {
  std::string scenario;
  std::optional<std::string> seeds;
  scenario::Changes changes;
  Backend backend;
  bool cached = false, all_metrics = false;
  ViewRequest view;
  BatchMember batch;
};

fs::path standard_folder(const scenario::ReadScenario& read) {
  return fs::path("results") / read.scenario.name;
}

/// Replays the recording from the cache. Writes the same bytes as run_live, except for timing.*.
result::Outcome run_cached(const scenario::ReadScenario& read, const result::ResultPlace& place,
                           const result::Progress& progress) {
  constexpr double kWalk = 0.7;  // fraction of the time spent on simulating a missing walk
  bool walked = false;
  std::vector<recording::CachedRecording> walks;
  std::vector<fs::path> sessions;
  const std::size_t before = read.scenario.sessions.size();
  const auto walking = [&](double part) {
    walked = true, progress(kWalk * (double(walks.size()) + part) / double(before + 1));
  };
  const auto replaying = [&](double part) { progress(walked ? kWalk + (1 - kWalk) * part : part); };
  const Recordings recordings(place.models);
  for (std::size_t i = 0; i < before; ++i) {
    walks.push_back(recordings.get(scenario::session(read, i), walking));
    sessions.push_back(walks.back().folder);
  }
  const auto recording = recordings.get(read, walking);
  return replay::replay(read, recording.folder / "recording", replay::read_walk_end(recording.folder), place,
                        replaying, replay::Recorded::copied, sessions);
}

int run_one(const scenario::ReadScenario& read, const RunRequest& request, const fs::path& root) {
  const fs::path folder = root / fmt::format("seed-{}", read.scenario.seed);
  std::unique_ptr<view::ViewSession> view;
  {
    const BlockedInterrupts blocked;  // also in the server's thread
    view = view_of_run(request.view, read, standard_models());
  }
  if (request.view.wait) view->wait_for_viewer();
  result::Outcome outcome;
  {
    ProgressLine progress(fmt::format("{} seed {}", read.scenario.name, read.scenario.seed));
    const result::ResultPlace place =
        result_place(folder, scenario::models_hash(standard_models()), standard_models());
    const auto show = [&](double part) { progress.show(part); };
    const int asked = request.backend.jobs,
              threads = asked > 0              ? asked
                        : request.batch.parent ? 1
                                               : 2;  // one of several has one core
    // Measured times are not repeatable, so no replay could reproduce a run that depends on them.
    const bool by_estimate = read.scenario.walk.steering.by == walking::SteeredBy::estimate;
    const bool measured = read.scenario.estimator_time.model == scenario::TimeModel::measured;
    // The cache has no walks of sessions that are steered in the map of the session before.
    const bool in_map = !read.scenario.sessions.empty() && by_estimate;
    outcome = request.cached && !measured && !in_map
                  ? run_cached(read, place, show)
                  : run_live(read, place, show, threads, view ? &view->run_observer() : nullptr);
  }
  if (view)
    view->end(fmt::format("The run has ended: {}. tools/gaitslam view {} shows it again.",
                          scenario::name_of(outcome.ending), files::shell_word(folder.string())),
              folder);
  const int exit_code = cli::report(outcome, folder, request.all_metrics);
  const auto is_over_seeds = [](const scenario::MetricLimit& limit) { return limit.aggregate.has_value(); };
  if (std::ranges::any_of(read.scenario.limits.metrics, is_over_seeds))
    text_out() << "limits over seeds (mean, median or worst) are judged only with --seeds\n";
  if (!request.view.wait) return exit_code;
  text_out() << "the view shows the result until Ctrl-C" << std::endl;
  BlockedInterrupts().wait();
  return exit_code;
}

int run_seeds(const scenario::ReadScenario& read, const RunRequest& request) {
  for (const std::string& argument : request.changes.overrides)
    if (argument.starts_with("seed="))
      throw UsageError("--seeds: seed= is given as well, expected only one of them");
  const auto jobs = jobs_of_seeds({read, ""}, parse_seeds(*request.seeds));
  const OutFolder out(request, standard_folder(read), OutUse::adds_results);
  const fs::path& root = out.path();
  const std::vector<std::uint64_t> beside =
      seeds_beside(jobs.front(), root, standard_models(), request.force);
  const auto ends = make_results(jobs, out,
                                 {.models = standard_models(),
                                  .title = fmt::format("{} seeds of {}", jobs.size(), read.scenario.name),
                                  .backend = request.backend,
                                  .cached = request.cached,
                                  .force = request.force});
  std::vector<result::SeedScore> scores = read_scores(jobs, ends, root);
  for (const std::uint64_t seed : beside)
    if (std::ranges::count(jobs, seed, &ResultJob::seed) == 0)
      scores.push_back(result::read_result(root / fmt::format("seed-{}", seed)));
  std::ranges::sort(scores, {}, &result::SeedScore::seed);
  const result::Summary summary = result::summarize(read.scenario, scores);
  result::write_summary(root / "summary.json", summary);
  const int exit_code = result::exit_code(summary);
  if (output() == Output::json) print_outcome(exit_code, root, {{"summary", result::to_json(summary)}});
  text_out() << result::summary_table(summary, {colors(), request.all_metrics}) << "results in "
             << root.string() << '\n';
  return exit_code;
}

int run(RunRequest& request) {
  require_simulator();
  if (request.view.view && (request.seeds || request.cached))
    throw UsageError("--view: shows one live walk, expected no {}", request.seeds ? "--seeds" : "--cached");
  if (!request.seeds && request.backend.slurm())
    throw UsageError("--backend slurm: is for several seeds, expected --seeds");
  scenario::ReadScenario read = scenario::read_scenario(request.scenario, request.changes);
  print_warnings(read);
  join_batch(request.batch, &read);
  require_models(read, standard_models());
  if (request.seeds) check_start(read, standard_models());  // once, so that errors name the given file
  if (request.seeds) return run_seeds(read, request);
  const ResultJob job{read, ""};
  const OutFolder out(request, standard_folder(read), OutUse::adds_result);
  require_new_result(out.path() / job.result(), request.force);
  seeds_beside(job, out.path(), standard_models(), request.force);
  return run_one(read, request, out.path());
}

using recording::Cache;

constexpr const char* kRecordExamples = R"(Examples:
  gaitslam record scenarios/tangent_circle.yaml --seeds 1..20 --jobs 2
Recordings are stored in $GAITSLAM_CACHE, else $XDG_CACHE_HOME/gaitslam, else ~/.cache/gaitslam. When the cache
exceeds $GAITSLAM_CACHE_GB (20) GB, the least recently used recordings are removed. A recording is identified by the
keys walk.*, stabilizer.*, world.* and camera.*, the seed, the models, and the sources of walk, world and recording;
sensor errors and filter may differ.
Exit codes: 0 all recordings are available; 2 wrong usage or configuration; 3 the simulation of a walk failed.)";

struct RecordRequest {
  std::string scenario;
  std::optional<std::string> seeds;
  scenario::Changes changes;
  Backend backend;
  BatchMember batch;
};

int report_walk(std::uint64_t seed, const fs::path& recording, bool is_new) {
  const replay::WalkEnd walk = replay::read_walk_end(recording);
  std::cout << fmt::format("seed {}: {}, {}: {}\n", seed, is_new ? "recorded" : "was in the cache",
                           scenario::name_of(walk.ended.ending), recording.string());
  if (walk.ended.ending != scenario::Ending::failed) return 0;
  std::cerr << fmt::format("gaitslam: seed {}: failed: {}\n", seed, walk.ended.cause);
  return 3;
}

int record_seeds(const scenario::ReadScenario& read, const RecordRequest& request,
                 const Recordings& recordings) {
  std::vector<scenario::ReadScenario> scenarios;
  for (const std::uint64_t seed : parse_seeds(*request.seeds)) {
    scenarios.push_back(read);
    scenarios.back().scenario.seed = seed;
  }
  Backend backend = request.backend;
  backend.spool = recordings.place().folder / ("slurm-" + recordings.key(scenarios[0].scenario));
  backend.seconds_each = 15;  // computing time for the shipped scenarios
  int exit_code = 0;
  const std::vector<Recordings::Made> all = recordings.make(scenarios, backend);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::uint64_t seed = scenarios[i].scenario.seed;
    if (all[i].folder.empty()) std::cerr << fmt::format("seed {}: {}", seed, all[i].record.cause);
    exit_code = std::max(exit_code, all[i].folder.empty() ? std::max(exit_code_of(all[i].record), 2)
                                                          : report_walk(seed, all[i].folder, all[i].is_new));
  }
  return exit_code;
}

int record(RecordRequest& request) {
  scenario::ReadScenario read = scenario::read_scenario(request.scenario, request.changes);
  join_batch(request.batch, &read);
  const Recordings recordings(standard_models());
  if (request.seeds) check_start(read, standard_models());  // once, so that errors name the file
  const OnInterrupt on_interrupt(fmt::format("finished recordings are kept in {}; to make the others",
                                             recordings.place().folder.string()));
  if (request.seeds) return record_seeds(read, request, recordings);
  ProgressLine progress(fmt::format("{} seed {}", read.scenario.name, read.scenario.seed));
  const auto recording = recordings.get(read, [&](double part) { progress.show(part); });
  return report_walk(read.scenario.seed, recording.folder, recording.made);
}

constexpr const char* kCacheExamples = R"(Examples:
  gaitslam cache clean            # removes all recordings that are not in use
  gaitslam cache clean --to 5     # removes the least recently used ones until 5 GB are left)";

constexpr double kGigabyte = 1e9;

struct CleanRequest {
  double gigabytes = 0;
};

int clean(CleanRequest& request) {
  const Cache cache(recording::cache_place());
  const Cache::Cleaned cleaned = cache.clean(std::uintmax_t(request.gigabytes * kGigabyte));
  std::cout << fmt::format("{} removed from {}, {:.2f} GB; {} kept because they are in use\n",
                           files::counted(cleaned.removed, "recording"), cache.place().folder.string(),
                           double(cleaned.bytes) / kGigabyte, cleaned.kept);
  return 0;
}

}  // namespace

void add_run(CLI::App& app, int& exit_code) {
  auto [command, request] = add_command(
      app, exit_code, "run", "Simulate a walk, run the filter on it and score both", kRunExamples, run);
  add_scenario(command, request.scenario, request.changes)->required();
  add_seeds(command, request.seeds, "run several seeds, each in its own process");
  add_backend_options(command, request.backend,
                      "with --seeds, processes at a time (default 1), or array elements; otherwise cores, 1 "
                      "or 2 (default 2)");
  add_out(command, request);
  add_cached(command, request.cached);
  add_all_metrics(command, request.all_metrics);
  add_output(command);
  add_view(command, request.view);
  add_batch_member(command, request.batch);
}

void add_record(CLI::App& app, int& exit_code) {
  auto [command, request] = add_command(app, exit_code, "record",
                                        "Simulate a walk and store the readings of ideal sensors for replays",
                                        kRecordExamples, record);
  add_scenario(command, request.scenario, request.changes)->required();
  add_seeds(command, request.seeds, "record several seeds, each in its own process");
  add_backend_options(command, request.backend);
  add_batch_member(command, request.batch);
}

void add_cache(CLI::App& app, int& exit_code) {
  CLI::App& command = *app.add_subcommand("cache", "Remove recordings stored for replays");
  command.require_subcommand(1);
  command.footer(kCacheExamples);
  auto [cleaner, request] =
      add_command(command, exit_code, "clean", "Remove recordings that are not in use", "", clean);
  cleaner.add_option("--to", request.gigabytes, "remove until at most this many GB are left")
      ->check(CLI::Range(0.0, 1e9));
}

/// The hidden command that an array element runs.
void add_element(CLI::App& app, int& exit_code) {
  auto [command, request] =
      add_command(app, exit_code, "element", "Run the jobs of an array element", "", run_element);
  command.group("");
  command.add_option("folder", request.folder)->required();
  command.add_option("each", request.each)->required();
}

}  // namespace cli
