#include <stdlib.h>

#include <iostream>

#include "sim/files/atomic_file.h"
#include "sim/live/run.h"
#include "sim/physics/adapted.h"
#include "tools/cli/commands.h"
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
  gaitslam robot check unitree/g1_29dof.xml  # a model without robot.yaml: uses what robot init would guess
Exit codes: 0 the robot stands and walks in place; 1 it does not; 2 it cannot be read.)";

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
};

/// A guessed robot.yaml in a temporary folder, which the destructor removes.
class GuessedRobot {
 public:
  explicit GuessedRobot(const fs::path& model) {
    const std::string text = physics::first_robot_file(model, fs::absolute(model).string());
    std::string pattern = (fs::temp_directory_path() / "gaitslam-robot-XXXXXX").string();
    if (!mkdtemp(pattern.data())) files::fail_by_errno(pattern, "cannot be made");
    folder_ = pattern;
    files::write_text(folder_ / "robot.yaml", text);
  }
  ~GuessedRobot() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  GuessedRobot(const GuessedRobot&) = delete;
  GuessedRobot& operator=(const GuessedRobot&) = delete;
  const fs::path& folder() const { return folder_; }

 private:
  fs::path folder_;
};

constexpr const char* kGuess = "no robot.yaml (using what gaitslam robot init would guess)";

int check_one(RobotRequest& request) {
  const auto print = [](const std::string& line) { std::cout << line << std::endl; };
  if (fs::is_directory(request.robot)) return live::check_robot(request.robot, print) ? 0 : 1;
  const GuessedRobot guessed(request.robot);
  const auto without_folder = [&](std::string text) {
    for (const std::string& folder : {guessed.folder().string() + "/", guessed.folder().string()})
      for (std::size_t at = text.find(folder); at != text.npos; at = text.find(folder))
        text.replace(at, folder.size(), folder.ends_with('/') ? "guessed " : kGuess);
    return text;
  };
  try {
    return live::check_robot(guessed.folder(), [&](const std::string& line) { print(without_folder(line)); })
               ? 0
               : 1;
  } catch (const std::exception& e) {
    throw std::runtime_error(without_folder(e.what()));
  }
}

int write_first(RobotRequest& request) {
  fs::path folder = request.out.value_or(request.robot.parent_path());
  if (folder.empty()) folder = ".";
  const fs::path file = folder / "robot.yaml";
  if (fs::exists(file)) throw files::FileError(file, "already exists and is not overwritten");
  const std::string text =
      physics::first_robot_file(request.robot, fs::proximate(request.robot, folder).string());
  fs::create_directories(folder);
  files::write_atomically(file, text);
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
  auto [checker, check_request] =
      add_command(command, exit_code, "check",
                  "Print the data read from a robot; make it stand for 5 s and walk in place",
                  kRobotCheckExamples, check_one);
  checker.add_option("robot", check_request.robot, "folder with robot.yaml, or a model file, MJCF or URDF")
      ->required();
  auto [writer, init_request] =
      add_command(command, exit_code, "init",
                  "Write a first robot.yaml with guessed feet, legs, base, chest and head", "", write_first);
  writer.add_option("model", init_request.robot, "model file, MJCF or URDF")->required();
  writer.add_option("--out", init_request.out, "folder for robot.yaml (default: the model's folder)");
}

void add_walker(CLI::App& app, int& exit_code) {
  add_command(app, exit_code, "walker",
              "Run the built-in walking controller as a program that answers gaitslam_walker.h messages",
              kWalkerExamples, answer_messages);
}

}  // namespace cli
