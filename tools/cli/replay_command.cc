#include <fmt/format.h>

#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "sim/bench/foreign_replay.h"
#include "sim/bench/recording_keys.h"
#include "sim/bench/replay.h"
#include "sim/bench/scenario_keys.h"
#include "sim/bench/scenario_yaml.h"
#include "sim/stream/asl_folder.h"
#include "tools/cli/batch.h"
#include "tools/cli/commands.h"
#include "tools/cli/out_folder.h"
#include "tools/cli/progress.h"
#include "tools/cli/version.h"

namespace cli {
namespace {

constexpr const char* kExamples = R"(
Examples:
  gaitslam replay results/tangent_circle/seed-1
  gaitslam replay results/tangent_circle/seed-1 slam.gyro.sigma_rad_s=0.02 --out DIR
  gaitslam replay results/tangent_circle/seed-1 seed=2        # the same walk with other sensor noise
  gaitslam replay MH_01_easy --out DIR                        # a EuRoC/ASL folder recorded elsewhere
The results go to RESULT/replay, replacing earlier ones, or to DIR. Exit code: as for run.)";

struct Request {
  fs::path result;
  std::optional<std::string> out, scenario;
  bench::Changes changes;
  bool force = false;
  std::optional<pid_t> batch;
  std::optional<fs::path> set_by;  ///< of a batch
};

/// What the recording has in it cannot be changed by replaying it.
void require_replayable(const bench::ReadScenario& read) {
  for (const auto& [key, origin] : read.origin) {
    if (bench::shapes_recording(key) && origin.starts_with("argument")) {
      throw UsageError(
          fmt::format("{}: shapes the recording, which replay does not change; run the scenario again", key));
    }
  }
}

/// Another scenario may tell the filter other things, not the walk.
void require_same_walk(const bench::Scenario& recorded, const bench::Scenario& scenario,
                       const std::string& file, const Request& request) {
  for (const auto& key : bench::scenario_keys()) {
    if (!bench::shapes_recording(key.name) || !bench::has_section(recorded, key.name)) continue;
    const std::string there = key.print(recorded),
                      here = bench::has_section(scenario, key.name) ? key.print(scenario) : "left out";
    if (there != here)
      throw UsageError(fmt::format("{}: {} is {} in the recording of {}, and {} here", file, key.name, there,
                                   request.result.string(), here));
  }
}

/// A result's scenario.yaml has every key: what the run did not set is at its default, and what it set was
/// set where the run's about.json says.
void keep_origin(bench::ReadScenario& read, const fs::path& result) {
  std::ifstream in(result / "about.json");
  const auto about = nlohmann::json::parse(in, nullptr, false);
  if (!about.is_object() || !about.contains("set_by")) return;
  auto origin = about["set_by"].get<decltype(read.origin)>();
  for (const auto& [key, by] : read.origin)
    if (by.starts_with("argument")) origin[key] = by;
  read.origin = std::move(origin);
}

bench::ReadScenario read_request(const Request& request) {
  const fs::path own = request.result / "scenario.yaml";
  if (!fs::exists(own))
    throw UsageError(
        fmt::format("{}: expected a result folder (with scenario.yaml and recording/) or one in the "
                    "EuRoC/ASL layout (with mav0/)",
                    request.result.string()));
  const std::string file = request.scenario.value_or(own.string());
  const bench::ReadScenario read = bench::read_scenario(file, request.changes);
  const std::string& last = request.changes.with.empty() ? file : request.changes.with.back();
  if (last != own.string())
    require_same_walk(bench::read_scenario(own).scenario, read.scenario, last, request);
  return read;
}

int replay(const Request& request) {
  if (request.batch) die_with(*request.batch);
  if (!fs::is_directory(request.result)) {
    throw UsageError(fmt::format("{}: no such result folder", request.result.string()));
  }
  const bool foreign = sim::stream::is_asl_folder(request.result);
  if (foreign && request.scenario) throw UsageError("--scenario: expected a result folder to replay with it");
  bench::ReadScenario read =
      foreign ? bench::foreign_scenario(request.result, request.changes) : read_request(request);
  require_replayable(read);
  if (request.set_by)
    take_origin(read, *request.set_by);
  else if (!foreign && !request.scenario)
    keep_origin(read, request.result);
  if (!read.scenario.slam) throw UsageError("slam: is left out, expected a filter to replay");
  const fs::path folder = request.out ? fs::path(*request.out) : request.result / "replay";
  check_out_folder(folder, request.out.has_value(), request.force);
  const NewFolders made_for_this(folder);
  bench::Outcome outcome;
  {
    ProgressLine progress("replay of " + request.result.string());
    const bench::ResultPlace place{folder,     sim::stream::Existing::replace, {}, kVersion, kRevision,
                                   libraries()};
    const auto show = [&](double part) { progress.show(part); };
    outcome = foreign ? bench::replay_foreign(read, request.result, place, show)
                      : bench::replay(read, request.result / "recording",
                                      bench::read_walk_end(request.result), place, show);
  }
  return report(outcome, folder);
}

}  // namespace

void add_replay(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<Request>();
  CLI::App* command = app.add_subcommand("replay", "Run the filter again on the recording of a run");
  command
      ->add_option("result", request->result,
                   "a result folder, as results/tangent_circle/seed-1, or one in the EuRoC/ASL layout")
      ->required();
  command
      ->add_option("changes", request->changes.overrides,
                   "what to set otherwise: errors.*, slam.*, limits.*, seed")
      ->option_text("key=value ...");
  add_with(command, request->changes);
  command->add_option("--scenario", request->scenario,
                      "what to set, from another scenario's file that walks the recorded walk");
  command->add_option("--out", request->out, "folder for the results");
  command->add_flag("--force", request->force, "replace a folder that exists");
  command->add_option("--set-by", request->set_by)->group("");
  command->add_option("--die-with-parent", request->batch)->group("");
  command->footer(kExamples);
  command->callback([request, &exit_code] { exit_code = replay(*request); });
}

}  // namespace cli
