// Runs the built program as a user does: through a shell, in a folder of the test's own.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace tests {

/// What a command left: exit code (128 + signal when killed) and what it printed.
struct Ran {
  int exit_code = -1;
  std::string out, err;
};

/// A test with an empty folder that is its working directory's stand-in, gone afterwards.
class CommandLine : public testing::Test {
 protected:
  CommandLine() { std::filesystem::create_directories(folder_); }
  ~CommandLine() override { std::filesystem::remove_all(folder_); }

  Ran shell(const std::string& command) const {
    const std::string files = (folder_ / ".out").string() + "' 2>'" + (folder_ / ".err").string();
    const int status =
        std::system(("cd '" + folder_.string() + "' && ( " + command + " ) >'" + files + "'").c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), text_of(".out"),
            text_of(".err")};
  }
  Ran gaitslam(const std::string& arguments) const {
    return shell(std::string(GAITSLAM_PROGRAM) + " " + arguments);
  }

  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
  }
  std::string text_of(const std::string& name) const {
    std::ifstream in(folder_ / name);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  /// What is in the folder besides the files of this class.
  std::size_t entries() const {
    std::size_t n = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      n += entry.path().filename() != ".out" && entry.path().filename() != ".err" ? 1 : 0;
    }
    return n;
  }

  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() /
      ("gaitslam test " + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + " " +
       std::to_string(getpid()));
};

}  // namespace tests
