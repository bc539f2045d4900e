#include <boost/algorithm/string/replace.hpp>
#include <iostream>

#include "sim/export/export.h"
#include "sim/replay/replay.h"
#include "sim/result/limits.h"
#include "sim/scenario/keys.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/jobs/results.h"
#include "tools/cli/shared/options.h"
#include "tools/cli/shared/version.h"

namespace cli {
namespace {

constexpr const char* kEvaluateExamples = R"(Examples:
  gaitslam evaluate results/tangent_circle/seed-1 --format euroc --command './run_my_slam.sh {folder} {trajectory}'
  gaitslam evaluate results/*/seed-* --format orbslam3 --pose imu --align se3 --columns 't[ns] x y z qx qy qz qw' --command '...'
For each recording, the command exports what the filter received, without any truth, to {folder}, runs your program, and
reads the {trajectory} that it wrote: TUM, KITTI with times.txt next to it, or a table whose columns are named by a header
(as in EuRoC's files) or by --columns, as ORB-SLAM3's in ns; gaitslam score --help lists the names. The result is written
to results/NAME/SCENARIO/seed-N, or below --out. If the scenario has sessions, the program runs on each in turn: {memory} is a folder that
it may keep, {session} the number, and the alignment of the first session applies to all. The errors after SE(3) and Sim(3) alignment are always both given. Limits are those of the recorded scenario unless given here, as in
limits.ate_se3_rmse_m.at_most=0.1. Rerun the command to resume after an interruption.
The exit codes are those of gaitslam run; a program that fails, takes too long or writes no trajectory ends as
estimator_failed (3). With several recordings, the highest exit code counts. Folders recorded by other programs (EuRoC/ASL) cannot be evaluated;
gaitslam replay reads them.)";

struct EvaluateRequest : OutRequest {
  std::vector<std::string> results, limits;  ///< limits: key=value
  std::string command, format;
  std::optional<std::string> name, align, pose, columns;
  double within_s = 3600;
  bool undistort = false, keep = false;
  Backend backend;
  BatchMember batch;
};

replay::PosedBody body_of(const EvaluateRequest& request) {
  const bool of_imu = request.format == "euroc" || request.format == "openvins";
  const std::string name = request.pose.value_or(of_imu ? "imu" : "camera");
  if (name != "camera" && name != "imu") throw UsageError("--pose {}: expected camera or imu", name);
  return name == "imu" ? replay::PosedBody::imu : replay::PosedBody::camera;
}

/// Returns the requested alignment, or one that matches what the exported IMU can observe.
score::Alignment alignment_of(const EvaluateRequest& request) {
  if (request.align) return alignment_named(*request.align);
  const bool gravity = request.format == "euroc" || request.format == "openvins";
  return gravity ? score::Alignment::yaw_position : score::Alignment::se3;
}

/// Runs the command on the export until it ends.
replay::ExternalRun run_command(const EvaluateRequest& request, const TemporaryFolder& scratch,
                                const estimators::Session& session) {
  replay::ExternalRun run{scratch / "trajectory.txt", request.columns.value_or(""), body_of(request),
                          alignment_of(request)};
  std::string command = request.command;
  boost::replace_all(command, "{folder}", files::shell_word((scratch / "export").string()));
  boost::replace_all(command, "{trajectory}", files::shell_word(run.trajectory.string()));
  boost::replace_all(command, "{memory}", files::shell_word(session.memory.string()));
  boost::replace_all(command, "{session}", std::to_string(session.index));
  programs::ChildProgram program({"sh", "-c", "exec 1>&2\n" + command}, "evaluate");
  try {
    program.run(programs::TimeLimit(request.within_s));
    if (!fs::exists(run.trajectory)) run.failed = "it ended without writing {trajectory}";
  } catch (const programs::ProgramFailed& failure) {
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
    throw UsageError("{}: expected the folder of a run, with scenario.yaml and recording/", folder.string());
  scenario::ReadScenario read = scenario::read_scenario(folder / "scenario.yaml", {request.limits, {}, {}});
  if (!read.scenario.slam) throw UsageError("{}: its scenario has no section slam", folder.string());
  const std::string name = request.name ? fmt::format(", name: {}", *request.name) : "";
  const std::string quoted = scenario::quote_if_needed(request.command);
  scenario::find_key("estimator")
      ->read(scenario::parse_yaml(fmt::format("{{command: {}{}}}", quoted, name), {"<--command, --name>"}),
             read.scenario);
  read.scenario.estimator_time = {};
  read.origin["estimator"] = "gaitslam evaluate";
  return read;
}

int evaluate_one(const ResultJob& job, const fs::path& result_folder, const EvaluateRequest& request) {
  const fs::path& folder = *job.recording;
  std::optional<score::Similarity> in_room;
  const auto evaluate_session = [&](const scenario::ReadScenario& read, const estimators::Session& session,
                                    const result::ResultPlace& place, const fs::path& into,
                                    const result::Progress&) {
    const scenario::Scenario& s = read.scenario;
    const fs::path recorded = &read == &job.read ? folder : folder / place.folder.filename();
    const TemporaryFolder scratch;
    exports::ExportedRun exported{recorded, s.name, s.seed, s.errors, false, request.undistort};
    const auto warn = [](const std::string& what) { std::cerr << "warning: " << what << '\n'; };
    exported.warn = warn;
    exports::export_run(exported, request.format, scratch / "export");
    const result::Timing timing;
    replay::ExternalRun run = run_command(request, scratch, session);
    run.warn = warn, run.in_room = &in_room;
    return replay::score_external(read, recorded / "recording", replay::read_walk_end(recorded), run, place,
                                  into, timing);
  };
  result::Outcome outcome;
  {
    ProgressLine progress(fmt::format("{} on {}", job.read.scenario.estimator.name, folder.string()));
    const std::string models = replay::read_walk_end(folder).models_hash;
    outcome = result::make_sessions(
        job.read, result_place(result_folder, models), [](double) {}, evaluate_session);
  }
  return cli::report(outcome, result_folder);
}

/// Returns the command line that evaluates one of several recordings.
std::vector<std::string> command_of(const EvaluateRequest& request, const std::string& recorded) {
  std::vector<std::string> words{
      "evaluate", recorded,       "--command", request.command,
      "--format", request.format, "--within",  fmt::format("{}", request.within_s)};
  for (const auto& [option, value] : {std::pair("--name", &request.name),
                                      {"--align", &request.align},
                                      {"--pose", &request.pose},
                                      {"--columns", &request.columns}})
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
    if (read.scenario.sessions.empty() && request.command.find("{memory}") != std::string::npos)
      throw UsageError("{}: has no sessions, expected some for {{memory}}", folder);
    all.push_back({read, read.scenario.name, folder, 1, command_of(request, folder)});
    if (const auto [earlier, is_new] = from.emplace(all.back().result(), folder); !is_new)
      throw UsageError("{} and {} would both be written to {}", earlier->second, folder, earlier->first);
  }
  return all;
}

int evaluate_all(const std::vector<ResultJob>& jobs, const OutFolder& out, const EvaluateRequest& request) {
  const auto ends = make_results(
      jobs, out,
      {.models = {},
       .title = fmt::format("{} on {} recordings", jobs[0].read.scenario.estimator.name, jobs.size()),
       .backend = request.backend,
       .force = request.force});
  int exit_code = 0;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const fs::path folder = out.path() / jobs[i].result();
    const int code =
        ends[i].finished ? result::read_result(folder).exit_code : std::max(ends[i].exit_code, 2);
    exit_code = std::max(exit_code, code);
    if (ends[i].finished)
      text_out() << result::score_table(folder, {colors()}, code == 3) << folder.string() << "\n\n";
  }
  return exit_code;
}

/// Separates limits.KEY=VALUE from the folders. Throws UsageError for any other key.
void separate_limits(EvaluateRequest& request) {
  const auto is_limit = [](const std::string& word) {
    return word.starts_with("limits.") && word.find('=') != word.npos;
  };
  for (const std::string& word : request.results)
    if (is_limit(word))
      request.limits.push_back(word);
    else if (word.find('=') != word.npos && !fs::exists(word))
      throw UsageError("{}: only limits may be changed, as in limits.rmse_m.at_most=0.1", word);
  std::erase_if(request.results, is_limit);
  if (request.results.empty()) throw UsageError("results: expected the folder of a run");
}

int evaluate(EvaluateRequest& request) {
  join_batch(request.batch);
  separate_limits(request);
  require_one_of({"euroc", "openvins", "orbslam3", "tum"}, request.format, "--format");
  body_of(request);
  if (request.align) alignment_named(*request.align);
  if (request.command.find("{trajectory}") == std::string::npos)
    throw UsageError("--command: lacks {trajectory}, expected it as the name of the file to write");
  const std::vector<ResultJob> jobs = read_jobs(request);
  const fs::path standard = fs::path("results") / jobs[0].read.scenario.estimator.name;
  for (const ResultJob& written : jobs)
    for (const ResultJob& read : jobs)
      require_separate((request.out ? fs::path(*request.out) : standard) / written.result(), *read.recording);
  const bool one = jobs.size() == 1;  // other recordings may use the same folder at the same time
  const OutFolder out(request, standard, one ? OutUse::adds_result : OutUse::adds_results);
  if (!one) return evaluate_all(jobs, out, request);
  const fs::path folder = out.path() / jobs[0].result();
  require_new_result(folder, request.force);
  return evaluate_one(jobs[0], folder, request);
}

}  // namespace

void add_evaluate(CLI::App& app, int& exit_code) {
  auto [command, request] =
      add_command(app, exit_code, "evaluate", "Run another SLAM program on exported recordings and score it",
                  kEvaluateExamples, evaluate);
  command.add_option("results", request.results, "folders of runs, and limits as key=value")->required();
  command.add_option("--command", request.command, "shell command with {folder} and {trajectory}")
      ->required();
  command.add_option("--format", request.format, "euroc, openvins, orbslam3 or tum")->required();
  command.add_option("--name", request.name, "name of the program in results (default: its file name)");
  command.add_option("--pose", request.pose,
                     "the body that its poses describe: imu (default for euroc and openvins) or camera");
  command.add_option("--columns", request.columns,
                     "names of the trajectory's columns in order, such as \"t[ns] x y z qw qx qy qz\"");
  command.add_option(
      "--align", request.align,
      "none, origin, yaw (default for euroc and openvins), se3 (default for tum and orbslam3), sim3 (if the "
      "program cannot know the scale) or scale");
  command.add_option("--within", request.within_s, "time limit of the command, in s")
      ->check(CLI::Range(0.001, 1e9))
      ->capture_default_str();
  command.add_flag("--undistort", request.undistort, "rectify the images, as tum always does");
  command.add_flag("--keep", request.keep, "keep the trajectory, even an unusable one, as trajectory.txt");
  add_backend_options(command, request.backend);
  add_out(command, request);
  add_batch_member(command, request.batch);
}

}  // namespace cli
