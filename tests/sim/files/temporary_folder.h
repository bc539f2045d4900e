// Test helpers: a temporary folder, the error of a call, running without root's permissions, and
// matchers for several texts.
#pragma once

#include <unistd.h>

#include "sim/files/text.h"

namespace sim::files {

/// The text of the Error that a call throws; empty if it throws none.
template <class Error = FileError>
std::string error_of(const auto& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

class TemporaryFolder {
 public:
  TemporaryFolder() {
    const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
    path_ = fs::temp_directory_path() / (std::string("gaitslam-") + test->test_suite_name() + "-" +
                                         test->name() + "-" + std::to_string(getpid()));
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~TemporaryFolder() { fs::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const fs::path& path() const { return path_; }
  fs::path operator/(const std::string& name) const { return path_ / name; }

 private:
  fs::path path_;
};

/// Runs as a user other than root while the object lives, because root has all permissions.
class AsUser {
 public:
  AsUser() { EXPECT_TRUE(before_ != 0 || seteuid(kNobody) == 0); }
  ~AsUser() { EXPECT_EQ(seteuid(before_), 0); }
  AsUser(const AsUser&) = delete;
  AsUser& operator=(const AsUser&) = delete;

 private:
  static constexpr uid_t kNobody = 65534;
  const uid_t before_ = geteuid();
};

}  // namespace sim::files

namespace tests {

namespace fs = sim::fs;

/// Returns the text with each `from` replaced. Headers of regular expressions take seconds to compile.
inline std::string replaced(std::string text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != text.npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

/// Returns the rows of a data file below tests/, whose fields are separated by " | "; # starts a comment.
inline std::vector<std::vector<std::string>> rows_of(const std::string& file) {
  std::vector<std::vector<std::string>> rows;
  for (const std::string& line :
       sim::files::lines_of(sim::files::read_text(GAITSLAM_SOURCE_DIR "/tests/" + file))) {
    if (line.empty() || line[0] == '#') continue;
    rows.emplace_back();
    for (std::size_t from = 0, to = 0; to != line.npos; from = to + 3)
      rows.back().push_back(line.substr(from, (to = line.find(" | ", from)) - from));
  }
  EXPECT_GT(rows.size(), 3u) << file;
  return rows;
}

/// Match texts that contain all of several parts, or none of them.
auto Has(const auto&... parts) { return testing::AllOf(testing::HasSubstr(parts)...); }
auto Lacks(const auto&... parts) { return testing::AllOf(testing::Not(testing::HasSubstr(parts))...); }

}  // namespace tests
