#include <iostream>

#include "sim/pages/pages.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/results.h"
#include "tools/cli/shared/live.h"
#include "tools/cli/shared/options.h"
#include "tools/cli/shared/version.h"

namespace cli {
namespace {

constexpr const char* kReproduceExamples = R"(Examples:
  gaitslam reproduce --jobs 2                      # ten seeds; the page is results/paper/index.html
  gaitslam reproduce --seeds 1..3 --out DIR
All results are kept in the folder. Rerun the command to resume after an interruption; --force replaces those of other programs.)";

struct ReproduceRequest {
  std::optional<std::string> seeds;
  Backend backend;
  bool cached = false, force = false;
  fs::path out = "results/paper", scenarios = standard_models().parent_path() / "scenarios";
};

/// Returns the jobs of all experiments on all seeds.
std::vector<ResultJob> plan(const ReproduceRequest& request) {
  std::vector<ResultJob> all;
  for (const pages::PaperExperiment& what : pages::kPaperExperiments) {
    ResultJob job{scenario::read_scenario((request.scenarios / (what.name + ".yaml")).string()),
                  what.name,
                  {},
                  what.cost_s};
    if (!what.recordings.empty()) job.recording = request.out / what.recordings;
    for (ResultJob& of_seed : jobs_of_seeds(job, parse_seeds(request.seeds.value_or("1..10"))))
      all.push_back(std::move(of_seed));
  }
  return all;
}

/// Runs the unfinished jobs that simulate, or that replay; returns whether each one now has a result.
bool run_jobs(std::vector<ResultJob> jobs, bool replay, const ReproduceRequest& request,
              const OutFolder& out) {
  std::erase_if(jobs, [&](const ResultJob& job) { return job.recording.has_value() != replay; });
  return std::ranges::all_of(make_results(jobs, out,
                                          {.models = standard_models(),
                                           .title = replay ? "reproduce: replays" : "reproduce: walks",
                                           .backend = request.backend,
                                           .cached = request.cached,
                                           .force = request.force}),
                             &ResultEnd::finished);
}

pages::PaperRuns read_results(const std::vector<ResultJob>& jobs, const fs::path& out) {
  pages::PaperRuns runs;
  for (const ResultJob& job : jobs) {
    if (!result::is_result(out / job.result())) continue;
    pages::RunData run = pages::read_run(out / job.result());
    if (job.recording) run.recording = *job.recording / "recording";
    runs[job.folder].push_back(std::move(run));
  }
  return runs;
}

int reproduce(ReproduceRequest& request) {
  require_simulator();
  const std::vector<ResultJob> jobs = plan(request);
  const OutFolder out({}, request.out, OutUse::adds_results);
  bool all_there = run_jobs(jobs, false, request, out);
  all_there &= run_jobs(jobs, true, request, out);
  const pages::PaperRuns runs = read_results(jobs, request.out);
  const fs::path page = request.out / "index.html";
  files::write_atomically(page, pages::paper_page(runs, kRevision));
  for (const pages::PaperRow& row : pages::paper_rows(runs))
    std::cout << fmt::format("{}\n  paper  {}\n  bench  {}\n         {}\n", row.what, row.paper, row.bench,
                             row.agreement);
  std::cout << "page in " << page.string() << '\n';
  return all_there ? 0 : 3;
}

}  // namespace

void add_reproduce(CLI::App& app, int& exit_code) {
  auto [command, request] = add_command(app, exit_code, "reproduce",
                                        "Run the experiments of the paper and compare numbers and figures",
                                        kReproduceExamples, reproduce);
  add_seeds(command, request.seeds, "seeds (default 1..10)");
  add_backend_options(command, request.backend);
  add_cached(command, request.cached);
  command.add_option("--out", request.out, "folder for the page and all results")->capture_default_str();
  command.add_flag("--force", request.force, "replace results of other settings or programs");
  command.add_option("--scenarios", request.scenarios, "folder of the scenarios of the experiments");
}

}  // namespace cli
