#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <memory>
#include <optional>

#include "sim/estimators/child_program.h"
#include "sim/export/export.h"
#include "sim/files/text.h"
#include "sim/regression/results.h"
#include "sim/replay/replay.h"
#include "sim/result/score_table.h"
#include "sim/scenario/keys.h"
#include "sim/scenario/scenario.h"
#include "sim/score/alignment.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/processes.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/jobs/results.h"
#include "tools/cli/jobs/terminal.h"
#include "tools/cli/shared/options.h"
#include "tools/cli/shared/out_folder.h"
#include "tools/cli/shared/version.h"

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
Limits are those of the recorded scenario, or given here, as in limits.ate_se3_rmse_m.at_most=0.1.
Rerun the command to resume after an interruption. The exit codes are those of gaitslam run; a command that fails, takes
too long or writes no trajectory ends as estimator_failed, 3. The highest of several recordings counts.
A header of the trajectory that names its columns (tx, qw, p_RS_R_x [m], ...) is obeyed. Folders that other programs
recorded are not accepted: score their trajectories with gaitslam score.)";

struct EvaluateRequest : OutRequest {
  std::vector<std::string> results, limits;  ///< limits: key=value
  std::string command, format;
  std::optional<std::string> name, align, pose;
  double within_s = 3600;
  bool undistort = false, keep = false;
  int jobs = 1;
  std::optional<pid_t> parent;
};

/// The default output of the programs that read a format.
struct Convention {
  const char* format;
  replay::PosedBody body;
  const char* align;
};
constexpr std::array kConventions{Convention{"euroc", replay::PosedBody::imu, "yaw"},
                                  Convention{"openvins", replay::PosedBody::imu, "yaw"},
                                  Convention{"orbslam3", replay::PosedBody::camera, "sim3"},
                                  Convention{"tum", replay::PosedBody::camera, "sim3"}};

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
replay::ExternalRun run_command(const EvaluateRequest& request, const TemporaryFolder& scratch) {
  replay::ExternalRun run{scratch / "trajectory.txt", body_of(request), alignment_of(request)};
  const std::string command =
      replaced(replaced(request.command, "{folder}", sim::files::shell_word((scratch / "export").string())),
               "{trajectory}", sim::files::shell_word(run.trajectory.string()));
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
  run.keep = request.keep;
  return run;
}

scenario::ReadScenario with_command(const fs::path& folder, const EvaluateRequest& request) {
  if (!fs::exists(folder / "scenario.yaml") || !fs::is_directory(folder / "recording"))
    throw UsageError(
        fmt::format("{}: expected the folder of a run, with scenario.yaml and recording/", folder.string()));
  scenario::ReadScenario read = scenario::read_scenario(folder / "scenario.yaml", {request.limits, {}, {}});
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

int evaluate_one(const ResultJob& job, const fs::path& result_folder, const EvaluateRequest& request) {
  const scenario::Scenario& s = job.read.scenario;
  const fs::path& folder = *job.recording;
  result::Outcome outcome;
  {
    ProgressLine progress(fmt::format("{} on {}", s.estimator.name, folder.string()));
    const TemporaryFolder scratch;
    exports::export_run({folder, s.name, s.seed, s.errors, false, request.undistort}, request.format,
                        scratch / "export", sim::files::Existing::reject);
    const result::Timing timing;
    const replay::ExternalRun run = run_command(request, scratch);
    const replay::WalkEnd walk = replay::read_walk_end(folder);
    const result::ResultPlace place{
        result_folder, sim::files::Existing::replace, {}, kVersion, kRevision, libraries(), walk.models_hash};
    outcome = replay::score_external(job.read, folder / "recording", walk, run, place, timing);
  }
  return cli::report(outcome, result_folder);
}

/// The command line that evaluates one of several recordings.
std::vector<std::string> command_of(const EvaluateRequest& request, const std::string& recorded) {
  std::vector<std::string> words{
      "evaluate", recorded,       "--command", request.command,
      "--format", request.format, "--within",  fmt::format("{}", request.within_s)};
  for (const auto& [option, value] :
       {std::pair("--name", &request.name), {"--align", &request.align}, {"--pose", &request.pose}})
    if (*value) words.insert(words.end(), {option, **value});
  words.insert(words.end(), request.limits.begin(), request.limits.end());
  if (request.undistort) words.emplace_back("--undistort");
  if (request.keep) words.emplace_back("--keep");
  return words;
}

std::vector<ResultJob> read_jobs(const EvaluateRequest& request) {
  std::vector<ResultJob> all;
  std::map<std::string, std::string> from;
  for (const std::string& folder : request.results) {
    const scenario::ReadScenario read = with_command(folder, request);
    all.push_back({read, read.scenario.name, folder, 1, command_of(request, folder)});
    if (const auto [earlier, is_new] = from.emplace(all.back().result(), folder); !is_new)
      throw UsageError(
          fmt::format("{} and {} would both be written to {}", earlier->second, folder, earlier->first));
  }
  return all;
}

/// Throws UsageError if a result would replace a recording that is read.
void require_outside_of_all(const fs::path& folder, const std::vector<ResultJob>& jobs) {
  for (const ResultJob& written : jobs)
    for (const ResultJob& read : jobs) require_outside(folder / written.result(), *read.recording);
}

int evaluate_all(const std::vector<ResultJob>& jobs, const OutFolder& out, const EvaluateRequest& request) {
  const auto ended = make_results(
      jobs, out,
      {.models = {},
       .title = fmt::format("{} on {} recordings", jobs[0].read.scenario.estimator.name, jobs.size()),
       .backend = {.jobs = request.jobs},
       .keeps_other_seeds = true});
  print_complaints(jobs, ended);
  int exit_code = 0;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const fs::path folder = out.path() / jobs[i].result();
    const bool there = fs::exists(folder / "score.json");
    const int code = there ? sim::regression::read_result(folder).exit_code : std::max(ended[i].exit_code, 2);
    exit_code = std::max(exit_code, code);
    if (there) text_out() << result::score_table(folder, {colours()}, code == 3) << folder.string() << "\n\n";
  }
  out.finished();
  return exit_code;
}

/// Separates limits.KEY=VALUE from the folders. Throws UsageError for another key.
EvaluateRequest with_limits(EvaluateRequest request) {
  for (const std::string& word : request.results) {
    const std::size_t equals = word.find('=');
    if (word.starts_with("limits.") && equals != word.npos)
      request.limits.push_back(word);
    else if (equals != word.npos && !fs::exists(word))
      throw UsageError(fmt::format("{}: only limits may be changed, as in limits.rmse_m.at_most=0.1", word));
  }
  std::erase_if(request.results, [&](const std::string& word) {
    return std::find(request.limits.begin(), request.limits.end(), word) != request.limits.end();
  });
  if (request.results.empty()) throw UsageError("results: expected the folder of a run");
  return request;
}

int evaluate(const EvaluateRequest& typed) {
  const EvaluateRequest request = with_limits(typed);
  if (request.parent) die_with(*request.parent);
  convention_of(request.format), body_of(request), alignment_of(request);
  if (request.command.find("{trajectory}") == std::string::npos)
    throw UsageError("--command: expected {trajectory} in it, the file that it is to write");
  const std::vector<ResultJob> jobs = read_jobs(request);
  const fs::path standard = fs::path("results") / jobs[0].read.scenario.estimator.name;
  require_outside_of_all(request.out ? fs::path(*request.out) : standard, jobs);
  // One recording has no identity, so that others can be evaluated beside it into the same folder.
  const std::string identity =
      jobs.size() == 1
          ? ""
          : identity_of(jobs, {request.format, request.pose.value_or(""), request.align.value_or(""),
                               request.undistort ? "undistorted" : "", request.keep ? "kept" : ""});
  const OutFolder out(request, standard,
                      {.results = results_of(jobs), .continues = true, .identity = identity});
  return jobs.size() == 1 ? evaluate_one(jobs[0], out.path() / jobs[0].result(), request)
                          : evaluate_all(jobs, out, request);
}

}  // namespace

void add_evaluate(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<EvaluateRequest>();
  CLI::App* command =
      app.add_subcommand("evaluate", "Run another SLAM program on exported recordings and score it");
  command->add_option("results", request->results, "folders of runs, and limits as key=value")->required();
  command
      ->add_option("--command", request->command,
                   "shell command with {folder}, the export, and {trajectory}, the file that it is to write")
      ->required();
  command->add_option("--format", request->format, "format of the export: euroc, openvins, orbslam3 or tum")
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
                    "rectify images to a pinhole camera, as tum always does");
  command->add_flag("--keep", request->keep,
                    "keep the trajectory in the result as trajectory.txt, also one that cannot be used");
  add_jobs(*command, request->jobs);
  add_out(*command, *request);
  add_parent(*command, request->parent);
  command->footer(kEvaluateExamples);
  command->callback([request, &exit_code] { exit_code = evaluate(*request); });
}

}  // namespace cli
