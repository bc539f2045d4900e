#include <iostream>

#include "sim/replay/replay.h"
#include "sim/result/score_file.h"
#include "sim/scenario/keys.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/shared/options.h"
#include "tools/cli/shared/out_folder.h"
#include "tools/cli/shared/version.h"

namespace cli {
namespace {

constexpr const char* kReplayExamples = R"(Examples:
  gaitslam replay results/tangent_circle/seed-1 slam.gyro.sigma_rad_s=0.02 --out DIR
  gaitslam replay results/tangent_circle/seed-1 seed=2        # the same walk, other noise
  gaitslam replay MH_01_easy --out DIR                        # an external EuRoC/ASL folder
  gaitslam replay theirs/seed-1 --scenario theirs/seed-1/scenario.yaml  # starts its program
The clock of an external IMU is compared with that of the truth, using rotation rates, for offsets up to 10 s. If the truth
has no orientations, an offset between IMU and images cannot be detected.
Results are written to RESULT/replay or to DIR, in place of an earlier replay only with --force. The exit codes are those of
gaitslam run.)";

struct ReplayRequest : OutRequest {
  fs::path result;
  std::optional<std::string> scenario;
  scenario::Changes changes;
  bool all_metrics = false;
  BatchMember batch;
};

/// Throws UsageError if only the result, which may be untrusted, names the program to start.
void require_asked_for(const scenario::ReadScenario& read, const scenario::Scenario& recorded,
                       const ReplayRequest& request) {
  const programs::Choice& choice = read.scenario.estimator;
  if (choice.source == programs::Source::built_in || choice != recorded.estimator) return;
  if (request.scenario) return;
  for (const std::string& change : request.changes.overrides)
    if (change.starts_with("estimator=")) return;
  throw UsageError(
      "{}: estimator: is {}, which a replay starts only if the command line names it, expected "
      "--scenario {} or estimator=filter",
      read.origin.find("estimator")->second, scenario::find_key("estimator")->print(read.scenario),
      files::shell_word((request.result / "scenario.yaml").string()));
}

/// Reads the origin of each key from about.json, because a result's scenario.yaml sets every key. A different
/// scenario keeps its own origins; naming the result's own file only allows its estimator to start.
void keep_origin(scenario::ReadScenario& read, const ReplayRequest& request) {
  std::error_code error;
  if (request.scenario && !fs::equivalent(*request.scenario, request.result / "scenario.yaml", error)) return;
  if (!fs::exists(request.result / "about.json")) return;
  auto origin = result::read_about(request.result / "about.json").set_by;
  if (origin.empty()) return;
  for (const auto& [key, by] : read.origin)
    if (by.starts_with("argument")) origin[key] = by;
  read.origin = std::move(origin);
}

/// Reads a result's stored scenario. Throws ConfigError, naming the revision that wrote it if it differs.
scenario::ReadScenario read_stored(const fs::path& result, const fs::path& file) {
  try {
    return scenario::read_scenario(file);
  } catch (const scenario::ConfigError& error) {
    const fs::path about = result / "about.json";
    const std::string made = fs::exists(about) ? result::read_about(about).revision : "";
    if (made.empty() || made == kRevision) throw;
    throw scenario::ConfigError(
        fmt::format("{}; gaitslam revision {} wrote this result, this is {}: replay it with that revision, "
                    "or run the walk again",
                    error.what(), made, kRevision));
  }
}

scenario::ReadScenario read_request(const ReplayRequest& request) {
  const fs::path own = request.result / "scenario.yaml";
  if (!fs::exists(own))
    throw UsageError(
        "{}: is not a result, expected a folder with scenario.yaml and recording/, or one in the "
        "EuRoC/ASL layout (with mav0/)",
        request.result.string());
  const std::string file = request.scenario.value_or(own.string());
  const scenario::Scenario recorded = read_stored(request.result, own).scenario;
  const scenario::ReadScenario read = scenario::read_scenario(file, request.changes);
  const std::string& last = request.changes.with.empty() ? file : request.changes.with.back();
  if (const auto other = scenario::first_difference(recorded, read.scenario); other && last != own.string())
    throw UsageError("{}: {} is {} in the recording of {}, and {} here", last, other->key, other->recorded,
                     request.result.string(), other->now);
  require_asked_for(read, recorded, request);
  return read;
}

int replay_result(ReplayRequest& request) {
  if (!fs::is_directory(request.result))
    throw UsageError("{}: no such result folder", request.result.string());
  std::optional<recording::AslFolder> external;
  if (recording::is_asl_folder(request.result)) {
    if (request.scenario)
      throw UsageError("--scenario: the folder has no scenario to replace, expected a result folder");
    external.emplace(request.result);
  }
  scenario::ReadScenario read =
      external ? replay::external_scenario(*external, request.changes) : read_request(request);
  if (external)
    for (const std::string& remark : external->sensors().remarks) std::cerr << "gaitslam: " << remark << '\n';
  for (const auto& [key, origin] : read.origin)
    if ((scenario::shapes_recording(key) || key == "sessions") && origin.starts_with("argument"))
      throw UsageError("{}: affects the recording, which a replay cannot change; rerun the scenario", key);
  if (!external) keep_origin(read, request);
  join_batch(request.batch, &read);
  if (read.scenario.sessions.empty() && fs::exists(request.result / "memory"))
    throw UsageError("{}: is a session of a program with a memory, expected the result with all its sessions",
                     request.result.string());
  if (!read.scenario.slam) throw UsageError("slam: is missing, expected a scenario with a filter");
  const OutFolder out(request, request.result / "replay", OutUse::result);
  require_separate(out.path(), request.result);
  replay::WalkEnd walk;
  if (!external) {
    walk = replay::read_walk_end(request.result);
    walk.counterfactual = scenario::counterfactual(
        scenario::read_scenario(request.result / "scenario.yaml").scenario, read.scenario);
  }
  result::Outcome outcome;
  {
    ProgressLine progress("replay of " + request.result.string());
    const result::ResultPlace place = result_place(out.path(), walk.models_hash);
    const auto show = [&](double part) { progress.show(part); };
    outcome = external ? replay::replay_external(read, *external, place, show)
                       : replay::replay(read, request.result / "recording", walk, place, show);
  }
  return cli::report(outcome, out.path(), request.all_metrics);
}

}  // namespace

void add_replay(CLI::App& app, int& exit_code) {
  auto [command, request] =
      add_command(app, exit_code, "replay", "Run the filter again on the recording of a run", kReplayExamples,
                  replay_result);
  add_result(command, request.result, ", or a folder in the EuRoC/ASL layout");
  add_overrides(command, request.changes.overrides, "(errors.*, slam.*, limits.* and seed)");
  add_with(command, request.changes);
  command.add_option("--scenario", request.scenario, "replay with another scenario file for the same walk");
  add_out(command, request);
  add_all_metrics(command, request.all_metrics);
  add_output(command);
  add_batch_member(command, request.batch);
}

}  // namespace cli
