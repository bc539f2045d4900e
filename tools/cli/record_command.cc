#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>

#include "sim/bench/replay.h"
#include "tools/cli/backend.h"
#include "tools/cli/commands.h"
#include "tools/cli/live.h"
#include "tools/cli/out_folder.h"
#include "tools/cli/progress.h"
#include "tools/cli/recordings.h"
#include "tools/cli/seeds.h"
#include "tools/cli/trial_commands.h"

namespace cli {
namespace {

constexpr double kWalkSeconds = 15;  // of computing, for the shipped scenarios

constexpr const char* kExamples = R"(
Examples:
  gaitslam record scenarios/tangent_circle.yaml --seeds 1..20 --jobs 2
  gaitslam record scenarios/hall.yaml world.seed=3
Recordings are kept in $GAITSLAM_CACHE, else $XDG_CACHE_HOME/gaitslam, else ~/.cache/gaitslam, of at most
$GAITSLAM_CACHE_GB (20) GB: the least recently used go first. What shapes a recording (the keys walk.*,
stabilizer.*, world.*, camera.*, the seed, the models, the sources of walk, world and recording) names it;
sensor errors and filter do not.
Exit code: 0 all are there, 2 usage or configuration, 3 a walk's simulation failed.)";

struct Request {
  std::string scenario;
  std::optional<std::string> seeds;
  bench::Changes changes;
  fs::path models = GAITSLAM_MODELS;
  Backend backend;
  std::optional<pid_t> parent;
};

/// A line for people; the exit code.
int tell(std::uint64_t seed, const sim::tune::CachedRecording& recording) {
  const bench::WalkEnd walk = bench::read_walk_end(recording.folder);
  std::cout << fmt::format("seed {}: {}, {}: {}\n", seed, recording.made ? "recorded" : "was in the cache",
                           walk.ending, recording.folder.string());
  if (walk.ending != "failed") return 0;
  std::cerr << fmt::format("gaitslam: seed {}: failed: {}\n", seed, walk.cause);
  return 3;
}

int record_one(const bench::ReadScenario& read, const Recordings& recordings) {
  ProgressLine progress(fmt::format("{} seed {}", read.scenario.name, read.scenario.seed));
  return tell(read.scenario.seed, recordings.get(read, [&](double part) { progress.show(part); }));
}

int record_seeds(const bench::ReadScenario& read, const Request& request, const Recordings& recordings) {
  std::vector<bench::Scenario> scenarios;
  for (const std::uint64_t seed : parse_seeds(*request.seeds)) {
    scenarios.push_back(read.scenario);
    scenarios.back().seed = seed;
  }
  std::vector<bool> there;
  for (const bench::Scenario& scenario : scenarios) there.push_back(recordings.find(scenario).has_value());
  Backend backend = request.backend;
  backend.spool = recordings.place().folder / "slurm";
  backend.seconds_each = kWalkSeconds;
  const std::vector<Ended> ended = recordings.make(scenarios, backend);
  int exit_code = 0;
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    auto recording = recordings.find(scenarios[i]);
    if (recording) recording->made = !there[i];
    if (!recording) std::cerr << fmt::format("seed {}: {}", scenarios[i].seed, ended[i].complaint);
    exit_code = std::max(exit_code,
                         recording ? tell(scenarios[i].seed, *recording) : std::max(ended[i].exit_code, 2));
  }
  return exit_code;
}

int record(const Request& request) {
  if (request.parent) die_with(*request.parent);
  const bench::ReadScenario read = bench::read_scenario(request.scenario, request.changes);
  const Recordings recordings(request.models);
  return request.seeds ? record_seeds(read, request, recordings) : record_one(read, recordings);
}

}  // namespace

void add_record(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<Request>();
  CLI::App* command =
      app.add_subcommand("record", "Walk a scenario and keep what ideal sensors gave, for replays");
  command->add_option("scenario", request->scenario, "the scenario's YAML file")->required();
  command->add_option("changes", request->changes.overrides, "what to set otherwise (gaitslam config --keys)")
      ->option_text("key=value ...");
  command->add_option("--seeds", request->seeds, "several seeds, each in its own process: 1..5 or 1,2,7");
  add_backend_options(*command, request->backend);
  command->add_option("--without", request->changes.without, "sections to leave out: camera,slam")
      ->delimiter(',')
      ->allow_extra_args(false);
  add_with(command, request->changes);
  command->add_option("--models", request->models, "folder of the robot's and room's models");
  command->add_option("--die-with-parent", request->parent)->group("");
  command->footer(kExamples);
  command->callback([request, &exit_code] { exit_code = record(*request); });
}

}  // namespace cli
