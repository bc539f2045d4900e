#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "sim/bench/scenario_yaml.h"
#include "sim/report/paper.h"
#include "sim/stream/durable_file.h"
#include "tools/cli/batch.h"
#include "tools/cli/commands.h"
#include "tools/cli/live.h"
#include "tools/cli/seeds.h"
#include "tools/cli/version.h"

namespace cli {
namespace {

namespace bench = sim::bench;
namespace fs = std::filesystem;
namespace report = sim::report;

constexpr const char* kExamples = R"(
Examples:
  gaitslam reproduce --jobs 2                       # ten seeds, page in results/paper/index.html
  gaitslam reproduce --seeds 1..3 --out DIR
Run again with the same program, it goes on where it was stopped.)";

struct Request {
  std::string seeds = "1..10";
  int jobs = 1;
  fs::path out = "results/paper";
  fs::path scenarios = fs::path(GAITSLAM_MODELS).parent_path() / "scenarios";
  fs::path models;
};

nlohmann::json read_json(const fs::path& file) {
  std::ifstream in(file);
  return nlohmann::json::parse(in, nullptr, false);
}

/// This very program has run this very scenario and seed to its end.
bool is_done(const fs::path& folder, bench::Scenario scenario, std::uint64_t seed) {
  const nlohmann::json about = read_json(folder / "about.json");
  if (!about.is_object() || about.value("revision", "") != kRevision || !fs::exists(folder / "score.json")) return false;
  scenario.seed = seed;
  std::ifstream in(folder / "scenario.yaml", std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(in), {}) == bench::to_yaml(scenario);
}

std::vector<std::uint64_t> still_to_run(const fs::path& root, const bench::Scenario& scenario,
                                        const std::vector<std::uint64_t>& seeds) {
  std::vector<std::uint64_t> left;
  for (const std::uint64_t seed : seeds)
    if (!is_done(root / fmt::format("seed-{}", seed), scenario, seed)) left.push_back(seed);
  return left;
}

/// What is said while it runs, with the time that is left if the rest goes as what was done.
class Course {
 public:
  explicit Course(std::size_t experiments) : experiments_(experiments) {}
  void begin(const std::string& name) {
    const double spent =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begun_).count();
    const std::string left =
        done_ == 0 ? "" : fmt::format(", about {:.0f} s left", spent / static_cast<double>(done_) *
                                                                     static_cast<double>(experiments_ - done_));
    std::cerr << fmt::format("reproduce: {} of {}: {}{}\n", done_ + 1, experiments_, name, left);
    ++done_;
  }

 private:
  std::size_t experiments_, done_ = 0;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
};

std::vector<report::RunData> run_experiment(const report::PaperExperiment& experiment, const Request& request,
                                            const std::vector<std::uint64_t>& seeds) {
  const bench::Scenario scenario = bench::read_scenario(request.scenarios / experiment.scenario).scenario;
  const fs::path root = request.out / experiment.name;
  Batch batch{still_to_run(root, scenario, seeds), request.jobs, root, request.models, {}};
  if (!experiment.recordings.empty()) batch.recordings = request.out / experiment.recordings;
  for (const SeedOutcome& outcome : run_batch(scenario, batch))
    if (outcome.exit_code > 1) std::cerr << fmt::format("  seed {}: {}", outcome.seed, outcome.complaint);
  std::vector<report::RunData> runs;
  for (const std::uint64_t seed : seeds) {
    const fs::path folder = root / fmt::format("seed-{}", seed);
    if (fs::exists(folder / "score.json")) runs.push_back(report::read_run(folder));
  }
  return runs;
}

void print(const std::vector<report::PaperRow>& rows) {
  for (const report::PaperRow& row : rows)
    std::cout << fmt::format("{}\n  paper  {}\n  bench  {}\n  {}\n", row.what, row.paper, row.bench, row.verdict);
}

int reproduce(const Request& request) {
  require_simulator();
  const std::vector<std::uint64_t> seeds = parse_seeds(request.seeds);
  const auto& experiments = report::paper_experiments();
  Course course(experiments.size());
  report::PaperRuns runs;
  for (const report::PaperExperiment& experiment : experiments) {
    course.begin(experiment.name);
    runs[experiment.name] = run_experiment(experiment, request, seeds);
  }
  const fs::path page = request.out / "index.html";
  sim::stream::write_durably(page, report::paper_page(runs, kRevision));
  print(report::paper_rows(runs));
  std::cout << "page in " << page.string() << '\n';
  return 0;
}

}  // namespace

void add_reproduce(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<Request>();
  CLI::App* command = app.add_subcommand("reproduce", "Run the paper's experiments; its numbers and figures beside ours");
  command->add_option("--seeds", request->seeds, "1..10 or 1,2,7")->capture_default_str();
  command->add_option("--jobs", request->jobs, "processes at a time")->check(CLI::Range(1, 1024))->capture_default_str();
  command->add_option("--out", request->out, "folder of the page and all results")->capture_default_str();
  command->add_option("--models", request->models, "folder of the robot's and rooms' models");
  command->footer(kExamples);
  command->callback([request, &exit_code] { exit_code = reproduce(*request); });
}

}  // namespace cli
