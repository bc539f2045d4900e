#include <fmt/format.h>

#include <cstdlib>
#include <iostream>
#include <memory>
#include <optional>

#include "sim/files/atomic_file.h"
#include "sim/pages/paper.h"
#include "sim/view/server.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/results.h"
#include "tools/cli/shared/live.h"
#include "tools/cli/shared/model_files.h"
#include "tools/cli/shared/options.h"
#include "tools/cli/shared/out_folder.h"
#include "tools/cli/shared/version.h"
#include "tools/cli/shared/view_session.h"

namespace cli {
namespace {

namespace pages = sim::pages;
namespace scenario = sim::scenario;

constexpr const char* kReproduceExamples = R"(
Examples:
  gaitslam reproduce --jobs 2                      # ten seeds; the page is results/paper/index.html
  gaitslam reproduce --seeds 1..3 --out DIR
  gaitslam reproduce --seeds 1 --view              # one walk after the other in the browser
Every result is kept in the folder. Rerun the command to resume after an interruption.)";

struct ReproduceRequest {
  std::string seeds = "1..10";
  int jobs = 1;
  bool cached = false;
  ViewRequest view;
  fs::path out = "results/paper", models = standard_models(),
           scenarios = standard_models().parent_path() / "scenarios";
};

/// The jobs of all experiments on all seeds.
std::vector<ResultJob> plan(const ReproduceRequest& request) {
  std::vector<ResultJob> all;
  for (const pages::PaperExperiment& what : pages::paper_experiments()) {
    ResultJob job{scenario::read_scenario((request.scenarios / (what.name + ".yaml")).string()),
                  what.name,
                  {},
                  what.cost_s};
    if (!what.recordings.empty()) job.recording = request.out / what.recordings;
    for (ResultJob& of_seed : jobs_of_seeds(job, parse_seeds(request.seeds)))
      all.push_back(std::move(of_seed));
  }
  return all;
}

/// Runs the unfinished jobs that simulate, or those that replay; returns whether each has a result now.
bool run_jobs(std::vector<ResultJob> jobs, bool replay, const ReproduceRequest& request,
              const OutFolder& out) {
  std::erase_if(jobs, [&](const ResultJob& job) { return job.recording.has_value() != replay; });
  const auto ended =
      make_results(jobs, out,
                   {.models = request.models,
                    .title = replay ? "reproduce: replays" : "reproduce: walks",
                    .backend = {.jobs = request.jobs},
                    .cached = request.cached,
                    .counts_older = true,
                    .keeps_other_seeds = true,
                    .more = request.view.view ? view_arguments(request.view) : std::vector<std::string>{}});
  bool all_there = true;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    if (fs::exists(out.path() / jobs[i].result() / "score.json")) continue;
    std::cerr << fmt::format("{}: {}", jobs[i].result(), ended[i].complaint);
    all_there = false;
  }
  return all_there;
}

pages::PaperRuns read_results(const std::vector<ResultJob>& jobs, const fs::path& out) {
  pages::PaperRuns runs;
  for (const ResultJob& job : jobs) {
    if (!fs::exists(out / job.result() / "score.json")) continue;
    pages::RunData run = pages::read_run(out / job.result());
    if (job.recording) run.recording = *job.recording / "recording";
    runs[job.folder].push_back(std::move(run));
  }
  return runs;
}

void print(const std::vector<pages::PaperRow>& rows) {
  for (const pages::PaperRow& row : rows)
    std::cout << fmt::format("{}\n  paper  {}\n  bench  {}\n         {}\n", row.what, row.paper, row.bench,
                             agreement_text(row.agreement));
}

/// Finds a free port and draws a token unless given, for the processes that show their walks one after the
/// other. Prints the URL.
void open_view(ViewRequest& place) {
  const sim::view::Access access = sim::view::Server({place.address, place.port, place.token}, {}).access();
  place.port = access.port;
  ::setenv(kViewToken, access.token.c_str(), 1);
  std::cout << "view at " << sim::view::url(access) << std::endl;
}

int reproduce(ReproduceRequest& request) {
  require_simulator();
  if (request.view.view && (request.jobs > 1 || request.cached))
    throw UsageError("--view shows one live walk at a time, expected --jobs 1 and no --cached");
  const std::vector<ResultJob> jobs = plan(request);
  const OutFolder out({}, request.out, {.names = {"index.html"}, .continues = true});
  if (request.view.view) open_view(request.view);
  bool all_there = run_jobs(jobs, false, request, out);
  all_there &= run_jobs(jobs, true, request, out);
  const pages::PaperRuns runs = read_results(jobs, request.out);
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
                    "take walks from the cache of recordings; record missing ones first");
  command->add_option("--out", request->out, "folder for the page and all results")->capture_default_str();
  add_models(*command, request->models);
  add_view(*command, request->view);
  command->add_option("--scenarios", request->scenarios, "folder of the scenarios of the experiments");
  command->footer(kReproduceExamples);
  command->callback([request, &exit_code] { exit_code = reproduce(*request); });
}

}  // namespace cli
