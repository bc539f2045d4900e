#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>

#include "sim/replay/replay.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/jobs/recordings.h"
#include "tools/cli/jobs/results.h"
#include "tools/cli/shared/interruption.h"
#include "tools/cli/shared/live.h"
#include "tools/cli/shared/model_files.h"
#include "tools/cli/shared/options.h"

namespace cli {
namespace {

namespace fs = std::filesystem;
namespace replay = sim::replay;
namespace scenario = sim::scenario;

constexpr double kWalkSeconds = 15;  // of computing, for the shipped scenarios

constexpr const char* kRecordExamples = R"(
Examples:
  gaitslam record scenarios/tangent_circle.yaml --seeds 1..20 --jobs 2
  gaitslam record scenarios/hall.yaml world.seed=3
Recordings are kept in $GAITSLAM_CACHE, else $XDG_CACHE_HOME/gaitslam, else ~/.cache/gaitslam. When the cache
exceeds $GAITSLAM_CACHE_GB (20) GB, the least recently used recordings are removed. A recording is identified by the
keys walk.*, stabilizer.*, world.* and camera.*, the seed, the models, and the sources of walk, world and recording;
sensor errors and filter may differ.
Exit codes: 0 all recordings are there; 2 wrong usage or configuration; 3 the simulation of a walk failed.)";

struct RecordRequest {
  std::string scenario;
  std::optional<std::string> seeds;
  scenario::Changes changes;
  fs::path models = standard_models();
  Backend backend;
  BatchMember batch;
};

/// Prints how the walk ended; returns the exit code.
int report_walk(std::uint64_t seed, const sim::recording::CachedRecording& recording) {
  const replay::WalkEnd walk = replay::read_walk_end(recording.folder);
  std::cout << fmt::format("seed {}: {}, {}: {}\n", seed, recording.made ? "recorded" : "was in the cache",
                           sim::scenario::name_of(walk.ended.ending), recording.folder.string());
  if (walk.ended.ending != sim::scenario::Ending::failed) return 0;
  std::cerr << fmt::format("gaitslam: seed {}: failed: {}\n", seed, walk.ended.cause);
  return 3;
}

int record_one(const scenario::ReadScenario& read, const Recordings& recordings) {
  ProgressLine progress(fmt::format("{} seed {}", read.scenario.name, read.scenario.seed));
  return report_walk(read.scenario.seed, recordings.get(read, [&](double part) { progress.show(part); }));
}

int record_seeds(const scenario::ReadScenario& read, const RecordRequest& request,
                 const Recordings& recordings) {
  std::vector<scenario::ReadScenario> scenarios;
  for (const std::uint64_t seed : parse_seeds(*request.seeds)) {
    scenarios.push_back(read);
    scenarios.back().scenario.seed = seed;
  }
  std::vector<bool> there;
  for (const scenario::ReadScenario& one : scenarios)
    there.push_back(recordings.find(one.scenario).has_value());
  Backend backend = request.backend;
  backend.spool = recordings.place().folder / "slurm";
  backend.seconds_each = kWalkSeconds;
  const std::vector<Ended> ended = recordings.make(scenarios, backend);
  int exit_code = 0;
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    const scenario::Scenario& scenario = scenarios[i].scenario;
    auto recording = recordings.find(scenario);
    if (recording) recording->made = !there[i];
    if (!recording) std::cerr << fmt::format("seed {}: {}", scenario.seed, ended[i].complaint);
    exit_code = std::max(
        exit_code, recording ? report_walk(scenario.seed, *recording) : std::max(ended[i].exit_code, 2));
  }
  return exit_code;
}

int record(const RecordRequest& request) {
  if (request.batch.parent) die_with(*request.batch.parent);
  scenario::ReadScenario read = scenario::read_scenario(request.scenario, request.changes);
  if (request.batch.set_by) take_origin(read, *request.batch.set_by);
  const Recordings recordings(request.models);
  if (request.seeds) require_clear_walk(read, request.models);  // once, with the file's name
  const OnInterrupt on_interrupt(fmt::format("finished recordings are kept in {}; to make the others",
                                             recordings.place().folder.string()));
  return request.seeds ? record_seeds(read, request, recordings) : record_one(read, recordings);
}

}  // namespace

void add_record(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<RecordRequest>();
  CLI::App* command =
      app.add_subcommand("record", "Simulate a walk and keep the readings of ideal sensors for replays");
  add_scenario(*command, request->scenario, request->changes)->required();
  add_seeds(*command, request->seeds);
  add_backend_options(*command, request->backend);
  add_models(*command, request->models);
  add_batch_member(*command, request->batch);
  command->footer(kRecordExamples);
  command->callback([request, &exit_code] { exit_code = record(*request); });
}

}  // namespace cli
