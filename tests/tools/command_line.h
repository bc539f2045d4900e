// Runs the built program through a shell, in a temporary folder of the test.
#pragma once

#include <sys/wait.h>

#include <iterator>

#include "tests/sim/files/temporary_folder.h"
#include "tests/sim/result/result_folder.h"

namespace tests {

using nlohmann::json;
using testing::AllOf, testing::ContainsRegex, testing::IsEmpty, testing::MatchesRegex, testing::Not,
    testing::StartsWith;

inline const std::string kSources = GAITSLAM_SOURCE_DIR;
inline const std::string kBlind = "run walk.yaml --without camera,slam ",
                         kBlindStand = "run stand.yaml --without camera,slam ";

/// Exit code (128 + signal if killed) and output of a command.
struct Ran {
  int exit_code = -1;
  std::string out, err;

  /// The same object, for a command that must end with this exit code.
  Ran ends(int code) const {
    EXPECT_EQ(exit_code, code) << out << err;
    return *this;
  }
  /// Standard error without the progress lines that appear every 30 s, for example on a slow machine.
  std::string complaints() const {
    std::string others;
    for (const std::string& line : sim::files::lines_of(err))
      if (!line.starts_with("gaitslam: ") || line.find(" left", line.find(" %,")) == line.npos)
        others += line + "\n";
    return others;
  }
};

/// A scenario with camera and filter; camera: its keys.
inline std::string scenario_of(const std::string& commands, const std::string& camera = "") {
  return "walk: {commands: [" + commands + "]}\ncamera: {" + camera + "}\nslam: {}\n";
}

/// One step, which takes a second, and the cheapest scenario with a camera and a filter.
inline const std::string kStep = "{stand: {duration_s: 0.3}}, {straight: {forward_m: 0.15}}",
                         kShortWalk = scenario_of(kStep, "rate_hz: 10"),
                         kStand = scenario_of("{stand: {duration_s: 0.2}}", "rate_hz: 10") +
                                  "world: {room: office}\n";

/// Runs commands in a temporary folder with kShortWalk as walk.yaml and a cache of recordings.
class CommandLine : public testing::Test {
 protected:
  CommandLine() {
    fs::create_directories(folder_);
    write("walk.yaml", kShortWalk);
    ::setenv("GAITSLAM_CACHE", (folder_ / "the cache").c_str(), 1);
  }
  ~CommandLine() override {
    fs::remove_all(folder_);
    ::unsetenv("GAITSLAM_CACHE");
  }

  Ran shell(const std::string& command) const {
    const std::string files = (folder_ / ".out").string() + "' 2>'" + (folder_ / ".err").string();
    const int status =
        std::system(("cd '" + folder_.string() + "' && ( " + command + " ) >'" + files + "'").c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), text_of(".out"),
            text_of(".err")};
  }
  Ran gaitslam(const std::string& arguments) const { return shell(GAITSLAM_PROGRAM " " + arguments); }
  /// Runs a command in the background until a shell condition is true, and sends it the signal.
  Ran ended_when(const std::string& condition, const std::string& signal,
                 const std::string& arguments) const {
    return shell("env --default-signal=INT " GAITSLAM_PROGRAM " " + arguments +
                 " & command=$!; while kill -0 $command && ! { " + condition +
                 "; }; do sleep 0.02; done 2>/dev/null; kill -" + signal + " $command; wait $command");
  }
  /// Checks a JSON file against a schema of sim/result/schemas.
  Ran checked(const std::string& schema, const std::string& file) const {
    return shell("/usr/bin/python3 '" GAITSLAM_SOURCE_DIR
                 "/tests/tools/check_schema.py' '" GAITSLAM_SOURCE_DIR "/sim/result/schemas/" +
                 schema + ".schema.json' " + file);
  }
  /// Standard output of a command that must succeed.
  std::string ok(const std::string& arguments) const {
    SCOPED_TRACE(arguments);
    return gaitslam(arguments).ends(0).out;
  }

  /// Copies results of `run walk.yaml --seeds 1..3` into `to`. They are made once for all tests of a build;
  /// the program makes them again if the scenario, the models or the program change.
  void short_walks(const std::string& to, const std::string& seeds = "1") const {
    write("walk.yaml", kShortWalk);
    shell("program='" GAITSLAM_PROGRAM "' to='" + to + "' seeds='" + seeds +
          R"sh(' && export program to seeds &&
        export store="${program%/tools/*}/tests/short_walks" && exec flock "$store.lock" sh -c '
          mkdir -p "$store" "$to" && cp walk.yaml "$store" &&
          (cd "$store" && "$program" run walk.yaml --seeds 1..3 --jobs 2 --out walks --force) || exit 1
          for n in $seeds; do cp -r "$store/walks/seed-$n" "$to" || exit 1; done')sh")
        .ends(0);
  }

  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
  }
  std::string text_of(const std::string& name) const {
    std::ifstream in(folder_ / name);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  json json_in(const std::string& name) const { return json::parse(text_of(name)); }
  /// Standard error of a command that must be rejected: exit code 2, one line, no output.
  std::string refusal(const std::string& arguments) const {
    SCOPED_TRACE(arguments);
    const Ran ran = gaitslam(arguments).ends(2);
    EXPECT_EQ(std::ranges::count(ran.err, '\n'), 1) << ran.err;
    EXPECT_EQ(ran.out, "");
    return ran.err;
  }

  /// Expects that the command is rejected with this message and leaves no file.
  void expect_refused(const std::string& arguments, const std::string& complaint) const {
    const std::size_t before = entries();
    const std::string error = refusal(arguments);
    EXPECT_NE(error.find(complaint), error.npos) << arguments << ": " << error;
    EXPECT_EQ(entries(), before) << arguments;
  }

  void expect_refused(const std::vector<std::pair<std::string, std::string>>& complaints) const {
    for (const auto& [arguments, complaint] : complaints) expect_refused(arguments, complaint);
  }

  /// Number of files and folders that the commands left.
  std::size_t entries() const {
    std::size_t n = 0;
    for (const auto& entry : fs::directory_iterator(folder_))
      n += entry.path().filename() != ".out" && entry.path().filename() != ".err";
    return n;
  }

  const fs::path folder_ =
      fs::temp_directory_path() /
      ("gaitslam test " + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + " " +
       std::to_string(getpid()));
};

}  // namespace tests
