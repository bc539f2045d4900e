#include <iostream>

#include "sim/files/atomic_file.h"
#include "sim/live/run.h"
#include "sim/physics/adapted.h"
#include "tools/cli/commands.h"
#include "tools/cli/gait_search.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/shared/options.h"

namespace cli {
namespace {

constexpr const char* kRobotExamples = R"(Examples:
  gaitslam robot init my_robot/robot.xml     # writes my_robot/robot.yaml; review its guesses
  gaitslam robot check my_robot
  gaitslam run scenarios/tangent_circle.yaml world.robot=./my_robot
See "Your own robot in an hour" in models/README.md.)";
constexpr const char* kRobotCheckExamples = R"(Examples:
  gaitslam robot check models/robots/hrp2
Exit codes: 0 the robot stands and walks where it is sent; 1 it does not; 2 it cannot be read.)";

constexpr const char* kWalkerExamples = R"(Example:
  gaitslam run scenarios/tangent_circle.yaml 'walk.controller={program: [tools/gaitslam, walker]}'
  gaitslam run ramp.yaml world.room=office_ramp \
      'walk.controller={program: [tools/gaitslam, walker], options: {slope: true}}'
sim/controllers/README.md describes the messages and the options plan and slope.)";

struct WalkerRequest {};

int answer_messages(WalkerRequest&) { return live::run_plan_program(); }

struct RobotRequest {
  fs::path robot;
  std::optional<fs::path> out;
  bool no_search = false;
  GaitSearch search;
};

int check_one(RobotRequest& request) {
  if (!fs::is_directory(request.robot))
    throw UsageError("robot check {}: expected a folder with robot.yaml; 'gaitslam robot init' writes one",
                     request.robot.string());
  return live::check_robot(request.robot, [](const std::string& line) { std::cout << line << std::endl; })
             ? 0
             : 1;
}

int write_first(RobotRequest& request) {
  fs::path folder = request.out.value_or(request.robot.parent_path());
  if (folder.empty()) folder = ".";
  const fs::path file = folder / "robot.yaml";
  if (fs::exists(file)) throw files::FileError(file, "already exists and is not overwritten");
  const std::string model = fs::proximate(request.robot, folder).string();
  const auto write = [&](const std::string& text) {
    fs::create_directories(folder);
    files::write_atomically(file, text);
  };
  if (request.no_search) {
    write(physics::first_robot_file(request.robot, model));
  } else {
    const OnInterrupt on_interrupt(
        fmt::format("{} has the best gait so far; to search again, first move it away", file.string()));
    ProgressLine progress("search the gait");
    search_gait(request.robot, model, request.search, write,
                [&](double part, const std::string& at) { progress.show(part, at); });
  }
  const std::string rig = physics::FirstRobotFile(request.robot).rig();
  const fs::path rig_file = folder / "rig.yaml";
  if (!rig.empty() && !fs::exists(rig_file)) {
    files::write_atomically(rig_file, rig);
    std::cout << rig_file.string() << ": written; for --with, has further sensors of the model\n";
  }
  std::cout << file.string() << ": written; review each guess, then run gaitslam robot check "
            << files::shell_word(folder.string()) << '\n';
  return 0;
}

}  // namespace

void add_robot(CLI::App& app, int& exit_code) {
  CLI::App& command =
      *app.add_subcommand("robot", "Check a robot's model and robot.yaml, or write a first robot.yaml");
  command.require_subcommand(1);
  command.footer(kRobotExamples);
  auto [checker, check_request] = add_command(
      command, exit_code, "check",
      "Print what is read from a robot; make it stand 5 s and walk in place and in each direction",
      kRobotCheckExamples, check_one);
  checker.add_option("robot", check_request.robot, "folder with robot.yaml")->required();
  auto [writer, init_request] = add_command(
      command, exit_code, "init",
      "Write a first robot.yaml: guess feet, legs, base, chest and head, and search for a gait by walking",
      "", write_first);
  writer.add_option("model", init_request.robot, "model file, MJCF or URDF")->required();
  writer.add_option("--out", init_request.out, "folder for robot.yaml (default: the model's folder)");
  writer.add_flag("--no-search", init_request.no_search, "guess the gait without walking");
  writer.add_option("--seed", init_request.search.seed, "seed of the search (default: 1)");
}

void add_walker(CLI::App& app, int& exit_code) {
  add_command(app, exit_code, "walker",
              "Run the built-in walking controller as a program that answers gaitslam_walker.h messages",
              kWalkerExamples, answer_messages);
}

}  // namespace cli
