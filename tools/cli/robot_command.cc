#include <stdlib.h>

#include <iostream>

#include "sim/files/atomic_file.h"
#include "sim/live/commands.h"
#include "sim/physics/adapted.h"
#include "tools/cli/commands.h"
#include "tools/cli/shared/options.h"

namespace cli {
namespace {

struct WalkerRequest {};

int answer_messages(WalkerRequest&) { return live::run_plan_program(); }

struct RobotRequest {
  fs::path robot;
  std::optional<fs::path> out;
};

/// A folder in the temporary folder, removed at the end.
class GuessedRobot {
 public:
  explicit GuessedRobot(const fs::path& model) {
    std::string pattern = (fs::temp_directory_path() / "gaitslam-robot-XXXXXX").string();
    if (!mkdtemp(pattern.data())) files::fail_by_errno(pattern, "cannot be made");
    folder_ = pattern;
    files::write_text(folder_ / "robot.yaml", physics::first_robot_file(model, fs::absolute(model).string()));
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

int check_one(RobotRequest& request) {
  const auto print = [](const std::string& line) { std::cout << line << std::endl; };
  if (fs::is_directory(request.robot)) return live::check_robot(request.robot, print) ? 0 : 1;
  const GuessedRobot guessed(request.robot);
  print("no robot.yaml: checked with what gaitslam robot init would guess");
  try {
    return live::check_robot(guessed.folder(), print) ? 0 : 1;
  } catch (const std::invalid_argument& e) {  // places in a file that does not stay
    std::string text = e.what();
    const std::string folder = guessed.folder().string() + "/";
    if (const auto at = text.find(folder); at != text.npos) text.replace(at, folder.size(), "guessed ");
    throw std::invalid_argument(text);
  }
}

int write_first(RobotRequest& request) {
  const fs::path folder = request.out.value_or(request.robot.parent_path()), file = folder / "robot.yaml";
  if (fs::exists(file)) throw files::FileError(file, "exists already and is not overwritten");
  const std::string text = physics::first_robot_file(
      request.robot, fs::proximate(request.robot, folder.empty() ? "." : folder).string());
  fs::create_directories(folder);
  files::write_atomically(file, text);
  std::cout << file.string() << ": written; look at each guess, then run gaitslam robot check "
            << files::shell_word(folder.empty() ? "." : folder.string()) << '\n';
  return 0;
}

}  // namespace

void add_robot(CLI::App& app, int& exit_code) {
  CLI::App& command = add_group(app, "robot");
  auto [checker, check_request] = add_command(command, exit_code, "check", check_one);
  checker.add_option("robot", check_request.robot, "folder with robot.yaml, or a model file, MJCF or URDF")
      ->required();
  auto [writer, init_request] = add_command(command, exit_code, "init", write_first);
  writer.add_option("model", init_request.robot, "model file, MJCF or URDF")->required();
  writer.add_option("--out", init_request.out, "folder of robot.yaml (default: that of the model)");
}

void add_walker(CLI::App& app, int& exit_code) { add_command(app, exit_code, "walker", answer_messages); }

}  // namespace cli
