#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>

#include "sim/files/atomic_file.h"
#include "sim/files/text.h"
#include "sim/pages/paper.h"
#include "sim/result/about_file.h"
#include "sim/scenario/yaml.h"
#include "sim/tune/recording_key.h"
#include "sim/view/server.h"
#include "tools/cli/commands.h"
#include "tools/cli/finished.h"
#include "tools/cli/jobs/batch.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/live.h"
#include "tools/cli/model_files.h"
#include "tools/cli/options.h"
#include "tools/cli/out_folder.h"
#include "tools/cli/version.h"
#include "tools/cli/view_session.h"

namespace cli {
namespace {

namespace pages = sim::pages;
namespace scenario = sim::scenario;

constexpr const char* kReproduceExamples = R"(
Examples:
  gaitslam reproduce --jobs 2                      # ten seeds; the page is results/paper/index.html
  gaitslam reproduce --seeds 1..3 --out DIR
  gaitslam reproduce --seeds 1 --view              # one walk after the other in the browser
Every result is kept in the folder. After an interruption the same program continues where it stopped.)";

struct ReproduceRequest {
  std::string seeds = "1..10";
  int jobs = 1;
  bool cached = false;
  ViewRequest view;
  fs::path out = "results/paper", models = standard_models(),
           scenarios = standard_models().parent_path() / "scenarios";
  std::optional<fs::path> recordings;  ///< <experiment>/seed-<n> where it is there to be replayed
};

fs::path seed_folder(const fs::path& root, std::uint64_t seed) { return root / fmt::format("seed-{}", seed); }

/// Empty where the file is missing or damaged: the run is then made again.
sim::result::About about(const fs::path& result) try {
  return sim::result::read_about(result / "about.json");
} catch (const sim::files::FileError&) {
  return {};
}

/// Whether the result is of this program, scenario and seed, and of the recording or the models that are
/// there now. recorded: empty where the walk is simulated.
bool is_done(const fs::path& result, const fs::path& recorded, const std::string& models_hash,
             const scenario::Scenario& scenario, std::uint64_t seed) {
  if (!is_finished(result, scenario, seed)) return false;
  if (recorded.empty()) return about(result).models == models_hash;
  const std::string walked = about(recorded).recording;  // empty before the walk was recorded
  return !walked.empty() && walked == about(result).recording;
}

/// One experiment and where its results are.
struct Experiment {
  pages::PaperExperiment what;
  scenario::ReadScenario read;
  fs::path root, recordings;  ///< recordings: empty where the experiment simulates its walks
  std::string models_hash;
};

const std::string& recorded_name(const pages::PaperExperiment& what) {
  return what.recordings.empty() ? what.name : what.recordings;
}

/// The folder of the recordings that an experiment replays; empty where it simulates its walks.
fs::path recordings_of(const pages::PaperExperiment& what, const ReproduceRequest& request) {
  const std::string& name = recorded_name(what);
  if (request.recordings && fs::is_directory(*request.recordings / name)) return *request.recordings / name;
  return what.recordings.empty() ? fs::path() : request.out / what.recordings;
}

std::vector<Experiment> plan(const ReproduceRequest& request) {
  const std::string models_hash = sim::tune::models_hash(request.models);
  std::vector<Experiment> all;
  for (const pages::PaperExperiment& what : pages::paper_experiments())
    all.push_back({what, scenario::read_scenario((request.scenarios / (what.name + ".yaml")).string()),
                   request.out / what.name, recordings_of(what, request), models_hash});
  return all;
}

std::vector<std::uint64_t> still_to_run(const Experiment& experiment,
                                        const std::vector<std::uint64_t>& seeds) {
  std::vector<std::uint64_t> left;
  for (const std::uint64_t seed : seeds) {
    const fs::path recorded =
        experiment.recordings.empty() ? fs::path() : seed_folder(experiment.recordings, seed);
    if (!is_done(seed_folder(experiment.root, seed), recorded, experiment.models_hash,
                 experiment.read.scenario, seed))
      left.push_back(seed);
  }
  return left;
}

/// Draws which part of the remaining CPU time is done.
class RemainingCost {
 public:
  RemainingCost(const std::vector<Experiment>& experiments, const std::vector<std::uint64_t>& seeds) {
    for (const Experiment& experiment : experiments)
      total_s_ += experiment.what.cost_s * static_cast<double>(still_to_run(experiment, seeds).size());
  }
  void show(const Experiment& experiment, std::size_t seeds, double part) {
    const double here_s = part * experiment.what.cost_s * static_cast<double>(seeds);
    line_.show(std::min(1.0, (done_s_ + here_s) / total_s_), experiment.what.name);
  }
  void finished(const Experiment& experiment, std::size_t seeds) {
    done_s_ += experiment.what.cost_s * static_cast<double>(seeds);
  }

 private:
  double total_s_ = 0, done_s_ = 0;
  ProgressLine line_{"reproduce"};
};

/// Runs the seeds that have no result yet; returns whether every seed has one now.
bool run_experiment(const Experiment& experiment, const ReproduceRequest& request,
                    const std::vector<std::uint64_t>& seeds, RemainingCost& cost) {
  Batch batch{still_to_run(experiment, seeds), experiment.root, request.models};
  batch.backend.jobs = request.jobs;
  batch.cached = request.cached && experiment.recordings.empty();
  if (!experiment.recordings.empty()) batch.recordings = experiment.recordings;
  batch.origin = experiment.read.origin;
  if (request.view.view) batch.more = view_arguments(request.view);
  const std::size_t left = batch.seeds.size();
  batch.progress = [&](double part) { cost.show(experiment, left, part); };
  bool all_there = true;
  for (const SeedOutcome& outcome : run_batch(experiment.read.scenario, batch)) {
    if (fs::exists(seed_folder(experiment.root, outcome.seed) / "score.json")) continue;
    std::cerr << fmt::format("{} seed {}: {}", experiment.what.name, outcome.seed, outcome.complaint);
    all_there = false;
  }
  cost.finished(experiment, left);
  return all_there;
}

pages::RunData read(const fs::path& result, const Experiment& experiment, std::uint64_t seed) {
  pages::RunData run = pages::read_run(result);
  if (!experiment.recordings.empty()) run.recording = seed_folder(experiment.recordings, seed) / "recording";
  return run;
}

pages::PaperRuns read_results(const std::vector<Experiment>& experiments,
                              const std::vector<std::uint64_t>& seeds) {
  pages::PaperRuns runs;
  for (const Experiment& experiment : experiments)
    for (const std::uint64_t seed : seeds)
      if (const fs::path result = seed_folder(experiment.root, seed); fs::exists(result / "score.json"))
        runs[experiment.what.name].push_back(read(result, experiment, seed));
  return runs;
}

void print(const std::vector<pages::PaperRow>& rows) {
  for (const pages::PaperRow& row : rows)
    std::cout << fmt::format("{}\n  paper  {}\n  bench  {}\n         {}\n", row.what, row.paper, row.bench,
                             agreement_text(row.agreement));
}

/// Finds a free port and draws a token where none is given, for the processes that show their walks there one
/// after the other. Prints the URL.
void open_view(ViewRequest& place) {
  const sim::view::Access access = sim::view::Server({place.address, place.port, place.token}, {}).access();
  place.port = access.port;
  ::setenv(kViewToken, access.token.c_str(), 1);
  std::cout << "view at " << sim::view::url(access) << std::endl;
}

/// Throws UsageError where results would replace recordings that were asked for.
void require_outside_of_recordings(const ReproduceRequest& request) {
  if (!request.recordings) return;
  for (const pages::PaperExperiment& written : pages::paper_experiments())
    for (const pages::PaperExperiment& read : pages::paper_experiments())
      require_outside(request.out / written.name, *request.recordings / recorded_name(read));
}

int reproduce(ReproduceRequest& request) {
  require_simulator();
  if (request.view.view && (request.jobs > 1 || request.cached))
    throw UsageError("--view shows one walk at a time as it goes on, expected --jobs 1 and no --cached");
  const std::vector<std::uint64_t> seeds = parse_seeds(request.seeds);
  const std::vector<Experiment> experiments = plan(request);
  require_outside_of_recordings(request);
  const OutFolder out({}, request.out, {.names = {"index.html"}, .continues = true});
  if (request.view.view) open_view(request.view);
  bool all_there = true;
  {
    RemainingCost cost(experiments, seeds);
    for (const Experiment& experiment : experiments)
      all_there &= run_experiment(experiment, request, seeds, cost);
  }
  const pages::PaperRuns runs = read_results(experiments, seeds);
  const fs::path page = request.out / "index.html";
  sim::files::write_atomically(page, pages::paper_page(runs, kRevision));
  print(pages::paper_rows(runs));
  std::cout << "page in " << page.string() << '\n';
  return all_there ? 0 : 3;
}

}  // namespace

void add_reproduce(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<ReproduceRequest>();
  CLI::App* command =
      app.add_subcommand("reproduce", "Run the experiments of the paper and compare numbers and figures");
  command->add_option("--seeds", request->seeds, "seeds, as in 1..10 or 1,2,7")->capture_default_str();
  add_jobs(*command, request->jobs);
  command->add_flag("--cached", request->cached,
                    "take walks from the cache of recordings; record those that are missing there first");
  command->add_option("--out", request->out, "folder for the page and all results")->capture_default_str();
  command->add_option(
      "--recordings", request->recordings,
      "replay the recordings in DIR/<scenario>/seed-<n>, where they exist, instead of simulating");
  add_models(*command, request->models);
  add_view(*command, request->view);
  command->add_option("--scenarios", request->scenarios, "folder of the scenarios of the experiments");
  command->footer(kReproduceExamples);
  command->callback([request, &exit_code] { exit_code = reproduce(*request); });
}

}  // namespace cli
