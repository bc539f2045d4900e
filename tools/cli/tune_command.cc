#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>

#include "sim/report/tune_page.h"
#include "sim/stream/durable_file.h"
#include "sim/tune/tuning.h"
#include "tools/cli/commands.h"
#include "tools/cli/out_folder.h"
#include "tools/cli/recordings.h"
#include "tools/cli/trial_parts.h"
#include "tools/cli/version.h"

namespace cli {
namespace {

namespace tune = sim::tune;

constexpr const char* kExamples = R"(
Examples:
  gaitslam tune scenarios/tuning/circles.yaml --jobs 2
  gaitslam run scenarios/tangent_circle.yaml --with results/tune-circles/best.yaml
Results go to results/tune-<spec>, or to DIR: trials.jsonl (each finished trial), history.csv, tune.json, report.html and
best.yaml. The same command again goes on where a killed one was, to the same answer. Recordings that the spec names by
scenario and seeds come from the cache, and are made there first. On Slurm each generation of CMA-ES is a job array;
the other optimisers and the polish submit one a setting.
Exit code: 0 tuned, 1 worse than the start on the hold-out recordings (no best.yaml), 2 usage or configuration.)";

struct Request {
  std::string spec;
  std::optional<std::string> out;
  fs::path models = GAITSLAM_MODELS;
  Backend backend;
};

/// One line on the terminal: stage, best so far, settings a minute, time left; silent where there is none.
class Progress {
 public:
  ~Progress() {
    if (drawn_) std::fputs("\r\033[K", stderr);
  }
  void show(const tune::Standing& standing) {
    using std::chrono::duration;
    if (isatty(STDERR_FILENO) != 1) return;
    if (standing.tried <= 1) begin_ = std::chrono::steady_clock::now();
    const double spent_min = duration<double>(std::chrono::steady_clock::now() - begin_).count() / 60;
    const double rate = spent_min > 0 ? (standing.tried - 1) / spent_min : 0;
    std::string line = standing.stage;
    if (standing.of > 0)
      line += fmt::format(": {} of {}, best {:.5g}", standing.tried, standing.of, standing.best);
    if (standing.of > 0 && rate > 0)
      line += fmt::format(", {:.0f} settings a minute, {} left", rate,
                          in_words(60 * std::max(0, standing.of - standing.tried) / rate));
    fmt::print(stderr, "\r\033[K{}", line);
    std::fflush(stderr);
    drawn_ = true;
  }

 private:
  static std::string in_words(double seconds) {
    const int whole = static_cast<int>(std::lround(seconds));
    return whole < 100 ? fmt::format("{} s", whole) : fmt::format("{} min {:02} s", whole / 60, whole % 60);
  }
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  bool drawn_ = false;
};

/// The recordings that the spec takes from the cache, made where they are missing; in use while this lives.
std::vector<tune::CachedRecording> take_from_cache(tune::Spec& spec, const fs::path& models,
                                                   const Backend& backend) {
  std::vector<tune::Footage*> cached;
  std::vector<bench::Scenario> scenarios;
  for (auto* side : {&spec.training, &spec.holdout})
    for (tune::Footage& footage : *side)
      for (const std::uint64_t seed : footage.seeds) {
        cached.push_back(&footage);
        scenarios.push_back(scenario_of(footage, seed).scenario);
        scenarios.back().seed = seed;
      }
  std::vector<tune::CachedRecording> all;
  if (scenarios.empty()) return all;
  const Recordings recordings(models);
  const std::vector<Ended> ended = recordings.make(scenarios, backend);
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    auto found = recordings.find(scenarios[i]);
    if (!found)
      throw UsageError(fmt::format("{} seed {} could not be recorded: {}", scenarios[i].name,
                                   scenarios[i].seed, ended[i].complaint));
    cached[i]->folders.push_back(found->folder);
    all.push_back(std::move(*found));
  }
  return all;
}

/// On a cluster: trials as elements of job arrays.
tune::RunTasks elsewhere(const Request& request, const fs::path& out, const Backend& backend) {
  if (!backend.slurm()) return {};
  return [&request, out, backend](const std::vector<tune::Task>& tasks, tune::TrialLog& log) {
    run_parts(tasks, log,
              {out / "parts", tune::log_purpose(program_identity()), request.models, "tune " + request.spec},
              backend);
  };
}

int tune_by(const Request& request) {
  tune::Spec spec = tune::read_spec(request.spec);
  const fs::path out = request.out ? fs::path(*request.out) : fs::path("results") / ("tune-" + spec.name);
  check_out_folder(out, request.out.has_value(), true);
  const NewFolders made_for_this(out);
  Backend backend = request.backend;
  backend.spool = out / "slurm";
  const auto in_use = take_from_cache(spec, request.models, backend);
  tune::Answer answer;
  {
    Progress progress;
    answer = tune::tune(spec, out, {std::max(backend.jobs, 1), elsewhere(request, out, backend)},
                        program_identity(), [&](const tune::Standing& standing) { progress.show(standing); });
  }
  fs::remove_all(backend.spool);
  sim::stream::write_durably(out / "report.html", sim::report::tune_page(out));
  std::cout << answer.text << "results in " << out.string() << '\n';
  if (!answer.accepted)
    std::cerr << "gaitslam: refused: worse than the start on the hold-out recordings; no best.yaml\n";
  return answer.accepted ? 0 : 1;
}

}  // namespace

void add_tune(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<Request>();
  CLI::App* command =
      app.add_subcommand("tune", "Look for the noise parameters that make the filter truthful");
  command->add_option("spec", request->spec, "the tuning's YAML file")->required();
  add_backend_options(*command, request->backend);
  command->add_option("--models", request->models, "folder of the robot's and room's models");
  command->add_option("--out", request->out, "folder for the results");
  command->footer(kExamples);
  command->callback([request, &exit_code] { exit_code = tune_by(*request); });
}

}  // namespace cli
