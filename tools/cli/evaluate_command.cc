#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <iostream>
#include <map>
#include <memory>
#include <optional>

#include "sim/estimators/child_program.h"
#include "sim/export/export.h"
#include "sim/replay/outside_trajectory.h"
#include "sim/scenario/keys.h"
#include "sim/scenario/scenario.h"
#include "sim/score/trajectory_report.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/processes.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/jobs/shell.h"
#include "tools/cli/options.h"
#include "tools/cli/out_folder.h"
#include "tools/cli/version.h"

namespace cli {
namespace {

namespace estimators = sim::estimators;
namespace exports = sim::exports;
namespace replay = sim::replay;
namespace result = sim::result;
namespace scenario = sim::scenario;
namespace score = sim::score;

constexpr const char* kEvaluateExamples = R"(
Examples:
  gaitslam evaluate results/tangent_circle/seed-1 --format euroc --command './run_my_slam.sh {folder} {trajectory}'
  gaitslam evaluate results/*/seed-* --format orbslam3 --pose imu --align se3 --name orbslam3 --command '...'
For each recording: exports what the filter received, without any truth, to a folder of its own, runs the command with
{folder} and {trajectory} replaced, reads the trajectory that the command has written (TUM, EuRoC csv or KITTI with
times.txt beside it), and leaves a result in results/NAME/SCENARIO/seed-N, or below --out.
The exit codes are those of gaitslam run; a command that fails, takes too long or writes no trajectory ends as
estimator_failed, 3. Of several recordings the highest.)";

struct EvaluateRequest : OutRequest {
  std::vector<std::string> results;
  std::string command, format;
  std::optional<std::string> name, align, pose;
  double within_s = 3600;
  bool undistort = false;
};

/// What the programs that read a format write, unless the user says otherwise.
struct Convention {
  const char* format;
  replay::PosedBody body;
  const char* align;
};
constexpr std::array kConventions{Convention{"euroc", replay::PosedBody::imu, "yaw"},
                                  Convention{"openvins", replay::PosedBody::imu, "yaw"},
                                  Convention{"orbslam3", replay::PosedBody::camera, "sim3"},
                                  Convention{"tum", replay::PosedBody::camera, "sim3"},
                                  Convention{"kitti", replay::PosedBody::camera, "sim3"}};

const Convention& convention_of(const std::string& format) {
  std::vector<std::string_view> names;
  for (const Convention& convention : kConventions) {
    if (convention.format == format) return convention;
    names.push_back(convention.format);
  }
  throw UsageError(fmt::format("--format: expected one of {}, not '{}'{}", fmt::join(names, ", "), format,
                               scenario::did_you_mean(format, names)));
}

replay::PosedBody body_of(const EvaluateRequest& request) {
  if (!request.pose) return convention_of(request.format).body;
  if (*request.pose == "camera") return replay::PosedBody::camera;
  if (*request.pose == "imu") return replay::PosedBody::imu;
  throw UsageError(fmt::format("--pose {}: expected camera or imu", *request.pose));
}

score::Alignment alignment_of(const EvaluateRequest& request) {
  const std::string name = request.align.value_or(convention_of(request.format).align);
  if (const auto alignment = score::alignment_of(name)) return *alignment;
  throw UsageError(fmt::format("--align {}: expected none, origin, yaw, se3, sim3 or scale", name));
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != text.npos; at += by.size())
    text.replace(at, what.size(), by);
  return text;
}

/// Runs the command on the export to its end.
replay::OutsideRun run_command(const EvaluateRequest& request, const TemporaryFolder& scratch) {
  replay::OutsideRun run{scratch / "trajectory.txt", body_of(request), alignment_of(request)};
  const std::string command =
      replaced(replaced(request.command, "{folder}", shell_word((scratch / "export").string())),
               "{trajectory}", shell_word(run.trajectory.string()));
  estimators::ChildProgram program({"sh", "-c", "exec 1>&2\n" + command});
  try {
    program.run(std::chrono::steady_clock::now() + std::chrono::duration_cast<std::chrono::nanoseconds>(
                                                       std::chrono::duration<double>(request.within_s)));
    if (!fs::exists(run.trajectory)) run.failed = "it ended without writing {trajectory}";
  } catch (const estimators::EstimatorFailed& failure) {
    run.failed = failure.what();
  }
  const std::string lines = program.last_lines();
  if (run.failed)
    *run.failed = "the command failed: " + *run.failed + (lines.empty() ? "" : "; its last lines: " + lines);
  run.log = program.log();
  run.cpu_ms = program.cpu_ms();
  return run;
}

scenario::ReadScenario with_command(const fs::path& folder, const EvaluateRequest& request) {
  if (!fs::exists(folder / "scenario.yaml") || !fs::is_directory(folder / "recording"))
    throw UsageError(
        fmt::format("{}: expected the folder of a run, with scenario.yaml and recording/", folder.string()));
  scenario::ReadScenario read = scenario::read_scenario(folder / "scenario.yaml");
  if (!read.scenario.slam)
    throw UsageError(fmt::format("{}: its scenario has no section slam", folder.string()));
  const std::string name = request.name ? fmt::format(", name: {}", *request.name) : "";
  const std::string quoted = scenario::quote_if_needed(request.command);
  scenario::find_key("estimator")
      ->read(scenario::parse_yaml(fmt::format("{{command: {}{}}}", quoted, name), {"<--command, --name>"}),
             read.scenario);
  read.origin["estimator"] = "gaitslam evaluate";
  return read;
}

int evaluate_one(const fs::path& folder, const EvaluateRequest& request, const fs::path& root) {
  const scenario::ReadScenario read = with_command(folder, request);
  const scenario::Scenario& s = read.scenario;
  const fs::path out = root / s.name / fmt::format("seed-{}", s.seed);
  result::Outcome outcome;
  {
    ProgressLine progress(fmt::format("{} on {}", s.estimator.name, folder.string()));
    const TemporaryFolder scratch;
    exports::export_run({folder, s.name, s.seed, s.errors, false, request.undistort}, request.format,
                        scratch / "export", sim::files::Existing::refuse);
    const result::Timing timing;
    const replay::OutsideRun run = run_command(request, scratch);
    const result::ResultPlace place{out, sim::files::Existing::replace, {}, kVersion, kRevision, libraries()};
    outcome =
        replay::score_outside(read, folder / "recording", replay::read_walk_end(folder), run, place, timing);
  }
  return cli::report(outcome, out);
}

int evaluate(const EvaluateRequest& request) {
  convention_of(request.format), body_of(request), alignment_of(request);
  if (request.command.find("{trajectory}") == std::string::npos)
    throw UsageError("--command: expected {trajectory} in it, the file that it is to write");
  std::vector<std::string> results;
  std::string name;
  std::map<std::string, std::string> from;
  for (const std::string& folder : request.results) {
    const scenario::Scenario s = with_command(folder, request).scenario;
    name = s.estimator.name;
    results.push_back(fmt::format("{}/seed-{}", s.name, s.seed));
    if (const auto [earlier, is_new] = from.emplace(results.back(), folder); !is_new)
      throw UsageError(
          fmt::format("{} and {} would both be written to {}", earlier->second, folder, results.back()));
  }
  const OutFolder out(request, fs::path("results") / name,
                      {.results = std::move(results), .continues = true});
  int exit_code = 0;
  for (const std::string& folder : request.results)
    exit_code = std::max(exit_code, evaluate_one(folder, request, out.path()));
  return exit_code;
}

}  // namespace

void add_evaluate(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<EvaluateRequest>();
  CLI::App* command =
      app.add_subcommand("evaluate", "Run another SLAM program on exported recordings and score it");
  command->add_option("results", request->results, "folders of runs")->required();
  command
      ->add_option("--command", request->command,
                   "shell command with {folder}, the export, and {trajectory}, the file that it is to write")
      ->required();
  command
      ->add_option("--format", request->format,
                   "format of the export: euroc, openvins, orbslam3, tum or kitti")
      ->required();
  command->add_option("--name", request->name,
                      "what the results call the program; without it, that of its file");
  command->add_option(
      "--pose", request->pose,
      "what its poses are of: camera or imu; unless given imu for euroc and openvins, else camera");
  command->add_option(
      "--align", request->align,
      "how its world is aligned with the true one: none, origin, yaw, se3, sim3 or scale; unless given "
      "yaw for euroc and openvins, else sim3");
  command->add_option("--within", request->within_s, "time limit of the command, in s")
      ->check(CLI::Range(0.001, 1e9))
      ->capture_default_str();
  command->add_flag("--undistort", request->undistort,
                    "rectify images to a pinhole camera, as tum and kitti always do");
  add_out(*command, *request);
  command->footer(kEvaluateExamples);
  command->callback([request, &exit_code] { exit_code = evaluate(*request); });
}

}  // namespace cli
