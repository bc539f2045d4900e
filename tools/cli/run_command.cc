#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iostream>
#include <map>
#include <memory>
#include <optional>

#include "sim/bench/replay.h"
#include "sim/bench/scenario_yaml.h"
#include "sim/bench/summary.h"
#include "tools/cli/batch.h"
#include "tools/cli/commands.h"
#include "tools/cli/live.h"
#include "tools/cli/out_folder.h"
#include "tools/cli/progress.h"
#include "tools/cli/recordings.h"
#include "tools/cli/seeds.h"
#include "tools/cli/version.h"

namespace cli {
namespace {

constexpr const char* kExamples = R"(
Examples:
  gaitslam run scenarios/tangent_circle.yaml
  gaitslam run scenarios/tangent_circle.yaml seed=7 slam.gyro.sigma_rad_s=0.02 --out DIR
  gaitslam run scenarios/tangent_circle.yaml --seeds 1..5 --jobs 2 --without camera,slam
Results go to results/<scenario>/seed-<n>, replacing earlier ones, or to DIR/seed-<n>.
Exit code: 0 passed, 1 missed a limit, 2 usage or configuration, 3 fell, diverged or crashed; of several seeds the worst.)";

struct Request {
  std::string scenario;
  std::optional<std::string> seeds, out;
  bench::Changes changes;
  fs::path models = GAITSLAM_MODELS;
  int jobs = 1;
  bool force = false, cached = false;
  std::optional<pid_t> batch;
  std::optional<fs::path> set_by;  ///< of a batch
};

/// The same bytes as run_live but for timing.*, from the recording in the cache.
bench::Outcome run_cached(const bench::ReadScenario& read, const bench::ResultPlace& place,
                          const bench::Progress& progress) {
  const auto recording = Recordings(place.models).get(read, progress);
  return bench::replay(read, recording.folder / "recording", bench::read_walk_end(recording.folder), place,
                       progress, bench::Recorded::copied);
}

int run_one(const bench::ReadScenario& read, const Request& request, const fs::path& root) {
  const fs::path folder = root / fmt::format("seed-{}", read.scenario.seed);
  bench::Outcome outcome;
  {
    ProgressLine progress(fmt::format("{} seed {}", read.scenario.name, read.scenario.seed));
    const bench::ResultPlace place{
        folder, sim::stream::Existing::replace, request.models, kVersion, kRevision, libraries()};
    const auto show = [&](double part) { progress.show(part); };
    outcome = request.cached ? run_cached(read, place, show) : run_live(read, place, show);
  }
  return report(outcome, folder);
}

/// What several seeds say alike is said once.
void print_complaints(const std::vector<SeedOutcome>& outcomes) {
  std::map<std::string, std::vector<std::uint64_t>> seeds;
  for (const SeedOutcome& outcome : outcomes)
    if (outcome.exit_code > 1) seeds[outcome.complaint].push_back(outcome.seed);
  for (const auto& [complaint, of] : seeds)
    std::cerr << fmt::format("seed{} {}: {}", of.size() > 1 ? "s" : "", fmt::join(of, ", "), complaint);
}

int run_seeds(const bench::ReadScenario& read, const Request& request, const fs::path& root) {
  const bool seed_typed =
      std::any_of(request.changes.overrides.begin(), request.changes.overrides.end(),
                  [](const std::string& argument) { return argument.starts_with("seed="); });
  if (seed_typed) throw UsageError("--seeds and seed= are both given, expected one of them");
  const auto outcomes = run_batch(read.scenario, {parse_seeds(*request.seeds),
                                                  root,
                                                  request.models,
                                                  {},
                                                  read.origin,
                                                  request.cached,
                                                  {.jobs = request.jobs}});
  std::vector<bench::SeedScore> scores;
  for (const SeedOutcome& outcome : outcomes)
    scores.push_back(bench::read_seed_score(root, outcome.seed, outcome.exit_code));
  print_complaints(outcomes);
  const bench::Summary summary = bench::summarize(read.scenario, scores);
  bench::write_summary(root / "summary.json", summary);
  std::cout << bench::summary_table(summary) << "results in " << root.string() << '\n';
  return bench::exit_code(summary);
}

int run(const Request& request) {
  if (request.batch) die_with(*request.batch);
  require_simulator();
  bench::ReadScenario read = bench::read_scenario(request.scenario, request.changes);
  if (request.set_by) take_origin(read, *request.set_by);
  const fs::path root = request.out ? fs::path(*request.out) : fs::path("results") / read.scenario.name;
  check_out_folder(root, request.out.has_value(), request.force);
  const NewFolders made_for_this(root);
  return request.seeds ? run_seeds(read, request, root) : run_one(read, request, root);
}

}  // namespace

void add_run(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<Request>();
  CLI::App* command = app.add_subcommand("run", "Walk a scenario, track it and score it");
  command->add_option("scenario", request->scenario, "the scenario's YAML file")->required();
  command->add_option("changes", request->changes.overrides, "what to set otherwise (gaitslam config --keys)")
      ->option_text("key=value ...");
  command->add_option("--seeds", request->seeds, "several seeds, each in its own process: 1..5 or 1,2,7");
  command->add_option("--jobs", request->jobs, "processes at a time")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  add_with(command, request->changes);
  command->add_option("--without", request->changes.without, "sections to leave out: camera,slam")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_option("--out", request->out, "folder for the results");
  command->add_option("--models", request->models, "folder of the robot's and room's models");
  command->add_flag("--cached", request->cached,
                    "replay the recording that the cache has of this walk; what it has not is put there");
  command->add_flag("--force", request->force, "write into a folder that exists");
  command->add_option("--set-by", request->set_by)->group("");
  command->add_option("--die-with-parent", request->batch)->group("");
  command->footer(kExamples);
  command->callback([request, &exit_code] { exit_code = run(*request); });
}

}  // namespace cli
