#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <iostream>

#include "sim/files/text.h"
#include "sim/replay/replay.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/jobs/results.h"
#include "tools/cli/shared/live.h"
#include "tools/cli/shared/options.h"

namespace cli {
namespace {

using sim::recording::Cache;

constexpr const char* kRecordExamples = R"(
Examples:
  gaitslam record scenarios/tangent_circle.yaml --seeds 1..20 --jobs 2
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
int report_walk(std::uint64_t seed, const fs::path& recording, bool is_new) {
  const replay::WalkEnd walk = replay::read_walk_end(recording);
  std::cout << fmt::format("seed {}: {}, {}: {}\n", seed, is_new ? "recorded" : "was in the cache",
                           sim::scenario::name_of(walk.ended.ending), recording.string());
  if (walk.ended.ending != sim::scenario::Ending::failed) return 0;
  std::cerr << fmt::format("gaitslam: seed {}: failed: {}\n", seed, walk.ended.cause);
  return 3;
}

int record_one(const scenario::ReadScenario& read, const Recordings& recordings) {
  ProgressLine progress(fmt::format("{} seed {}", read.scenario.name, read.scenario.seed));
  const auto recording = recordings.get(read, [&](double part) { progress.show(part); });
  return report_walk(read.scenario.seed, recording.folder, recording.made);
}

int record_seeds(const scenario::ReadScenario& read, const RecordRequest& request,
                 const Recordings& recordings) {
  std::vector<scenario::ReadScenario> scenarios;
  for (const std::uint64_t seed : parse_seeds(*request.seeds)) {
    scenarios.push_back(read);
    scenarios.back().scenario.seed = seed;
  }
  Backend backend = request.backend;
  backend.spool = recordings.place().folder / "slurm";
  backend.seconds_each = 15;  // of computing, for the shipped scenarios
  int exit_code = 0;
  const std::vector<Recordings::Made> all = recordings.make(scenarios, backend);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::uint64_t seed = scenarios[i].scenario.seed;
    if (all[i].folder.empty()) std::cerr << fmt::format("seed {}: {}", seed, all[i].ended.complaint);
    exit_code = std::max(exit_code, all[i].folder.empty() ? std::max(all[i].ended.exit_code, 2)
                                                          : report_walk(seed, all[i].folder, all[i].is_new));
  }
  return exit_code;
}

int record(RecordRequest& request) {
  scenario::ReadScenario read = scenario::read_scenario(request.scenario, request.changes);
  join_batch(request.batch, &read);
  const Recordings recordings(request.models);
  if (request.seeds) require_clear_walk(read, request.models);  // once, with the file's name
  const OnInterrupt on_interrupt(fmt::format("finished recordings are kept in {}; to make the others",
                                             recordings.place().folder.string()));
  return request.seeds ? record_seeds(read, request, recordings) : record_one(read, recordings);
}

constexpr const char* kCacheExamples = R"(
Examples:
  gaitslam cache list
  gaitslam cache clean            # removes all recordings that are not in use
  gaitslam cache clean --to 5     # removes the least recently used until 5 GB are left)";

constexpr double kGigabyte = 1e9, kMegabyte = 1e6;

struct CleanRequest {
  double gigabytes = 0;
};

int list(CleanRequest&) {
  const Cache cache(sim::recording::cache_place());
  std::uintmax_t total = 0;
  for (const Cache::Entry& entry : cache.list()) {
    total += entry.bytes;
    std::cout << fmt::format("{}  {:>6.1f} MB  {:%Y-%m-%d %H:%M}  {} seed {}{}\n", entry.key,
                             static_cast<double>(entry.bytes) / kMegabyte,
                             fmt::localtime(entry.last_used_ns / 1'000'000'000), entry.scenario, entry.seed,
                             entry.in_use ? "  (in use)" : "");
  }
  std::cout << fmt::format("{:.2f} of {:.2f} GB in {}\n", static_cast<double>(total) / kGigabyte,
                           static_cast<double>(cache.place().most_bytes) / kGigabyte,
                           cache.place().folder.string());
  return 0;
}

int clean(CleanRequest& request) {
  const Cache cache(sim::recording::cache_place());
  const Cache::Cleaned cleaned = cache.clean(static_cast<std::uintmax_t>(request.gigabytes * kGigabyte));
  std::cout << fmt::format(
      "{} removed, {:.2f} GB; {} kept because they are in use or have files that gaitslam did not make\n",
      sim::files::counted(cleaned.removed, "recording"), static_cast<double>(cleaned.bytes) / kGigabyte,
      cleaned.kept);
  return 0;
}

}  // namespace

void add_record(CLI::App& app, int& exit_code) {
  auto [command, request] = add_command(app, exit_code, "record",
                                        "Simulate a walk and keep the readings of ideal sensors for replays",
                                        kRecordExamples, record);
  add_scenario(command, request.scenario, request.changes)->required();
  add_seeds(command, request.seeds, "record several seeds, each in its own process");
  add_backend_options(command, request.backend);
  add_models(command, request.models);
  add_batch_member(command, request.batch);
}

void add_cache(CLI::App& app, int& exit_code) {
  CLI::App& command = *app.add_subcommand("cache", "List or remove the recordings that are kept for replays");
  command.require_subcommand(1);
  command.footer(kCacheExamples);
  add_command(command, exit_code, "list", "List the recordings, the least recently used first", "", list);
  auto [cleaner, request] =
      add_command(command, exit_code, "clean", "Remove recordings that are not in use", "", clean);
  cleaner.add_option("--to", request.gigabytes, "remove until at most this many GB are left")
      ->check(CLI::Range(0.0, 1e9));
}

}  // namespace cli
