// A folder is a rule: what its files may include. The linker alone does not hold it, since Debian has the
// headers of MuJoCo, OpenGL and OpenCV where every compiler looks.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;

/// Files whose path begins with `files` may include what begins with one of `may_include`, and the standard
/// library.
struct Rule {
  std::string_view files;
  std::vector<std::string_view> may_include;
};

/// The first rule that fits a file holds.
const std::vector<Rule>& rules() {
  static const std::vector<Rule> all{
      {"walking/", {"walking/", "Eigen/"}},
      {"slam/", {"slam/", "Eigen/", "opencv2/core", "opencv2/imgproc"}},
      {"sim/score/", {"sim/score/", "Eigen/"}},
      {"sim/stream/",
       {"sim/stream/", "slam/camera.h", "slam/observation.h", "slam/options.h", "Eigen/", "opencv2/core",
        "opencv2/imgcodecs", "fmt/", "yaml-cpp/", "xxhash.h", "libdeflate.h", "fcntl.h", "signal.h", "unistd.h", "sys/"}},
      {"sim/world/",
       {"sim/world/", "walking/", "Eigen/", "mujoco/", "GL/", "opencv2/core", "opencv2/imgproc", "dlfcn.h",
        "unistd.h"}},
      {"sim/bench/run.", {"sim/", "slam/", "walking/", "Eigen/", "fmt/"}},
      {"sim/bench/",
       {"sim/bench/", "sim/score/", "sim/stream/", "sim/world/options.h", "slam/", "walking/", "Eigen/",
        "fmt/", "nlohmann/", "yaml-cpp/", "opencv2/core", "opencv2/imgproc", "time.h"}},
      {"sim/tune/",
       {"sim/tune/", "sim/bench/", "sim/score/", "sim/stream/", "slam/", "Eigen/", "fmt/", "nlohmann/",
        "opencv2/core", "pagmo/", "nlopt.h", "fcntl.h", "unistd.h", "sys/"}},
  };
  return all;
}

/// Nobody but run and the program may begin a live run: replay must link without the simulator.
bool sees_live_run(std::string_view file, std::string_view included) {
  return included == "sim/bench/run.h" && !file.starts_with("sim/bench/run.");
}

/// <vector>, <cmath>: the standard library has neither folders nor endings.
bool is_standard(std::string_view included) { return included.find_first_of("./") == included.npos; }

bool is_allowed(const Rule& rule, std::string_view file, std::string_view included) {
  const bool listed = std::any_of(rule.may_include.begin(), rule.may_include.end(),
                                  [&](std::string_view prefix) { return included.starts_with(prefix); });
  return (listed || is_standard(included)) && included.find("..") == included.npos &&
         !sees_live_run(file, included);
}

/// What each #include of a text names; "?" for one that names nothing the test can read (a macro).
std::vector<std::string> includes(const std::string& text) {
  std::vector<std::string> names;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    line.erase(std::remove_if(line.begin(), line.end(), [](unsigned char c) { return std::isspace(c) != 0; }),
               line.end());
    if (!line.starts_with("#include")) continue;
    const std::size_t begin = line.find_first_of("<\""), end = line.find_last_of(">\"");
    names.push_back(begin == line.npos || end <= begin ? "?" : line.substr(begin + 1, end - begin - 1));
  }
  return names;
}

/// "file: included" for each include that the file's rule forbids.
std::vector<std::string> violations(const std::string& file, const std::string& text) {
  std::vector<std::string> found;
  for (const Rule& rule : rules()) {
    if (!file.starts_with(rule.files)) continue;
    for (const std::string& included : includes(text)) {
      if (included == "?" || !is_allowed(rule, file, included)) found.push_back(file + ": " + included);
    }
    return found;
  }
  return found;
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<fs::path> sources_below(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string ending = entry.path().extension();
    if (ending == ".h" || ending == ".cc") files.push_back(entry.path());
  }
  return files;
}

const fs::path kRoot = GAITSLAM_SOURCE_DIR;

TEST(IncludeRule, EachFolderSeesOnlyWhatItMay) {
  for (const std::string folder :
       {"walking", "slam", "sim/score", "sim/stream", "sim/world", "sim/bench", "sim/tune"}) {
    const auto files = sources_below(kRoot / folder);
    EXPECT_GE(files.size(), 2u) << folder << ": too few files for a test that would notice";
    for (const fs::path& file : files) {
      EXPECT_THAT(violations(fs::relative(file, kRoot), text_of(file)), IsEmpty());
    }
  }
}

TEST(IncludeRule, OnlyTheLivePartOfTheProgramSeesTheSimulator) {
  for (const fs::path& file : sources_below(kRoot / "tools/cli")) {
    if (file.filename() == "live_world.cc" || file.filename() == "robot_view.cc") continue;
    for (const std::string& included : includes(text_of(file))) {
      EXPECT_FALSE(included.starts_with("mujoco/") || included.starts_with("sim/world/") ||
                   included == "sim/bench/run.h")
          << file << ": " << included;
    }
  }
}

TEST(IncludeRule, PlantedViolationsAreFound) {
  const std::pair<const char*, const char*> planted[]{
      {"slam/filter.cc", "sim/world/world.h"},         {"slam/filter.cc", "walking/plan.h"},
      {"slam/filter.cc", "mujoco/mujoco.h"},           {"slam/filter.cc", "opencv2/imgcodecs.hpp"},
      {"slam/filter.cc", "sim/stream/random.h"},       {"slam/filter.cc", "../sim/world/world.h"},
      {"slam/filter.cc", "slam/../sim/world/world.h"}, {"walking/plan.h", "slam/options.h"},
      {"walking/plan.h", "opencv2/core.hpp"},          {"walking/plan.h", "sim/world/options.h"},
      {"sim/score/drift.cc", "slam/observation.h"},    {"sim/score/drift.cc", "walking/plan.h"},
      {"sim/score/drift.cc", "opencv2/core.hpp"},      {"sim/stream/recording.h", "walking/plan.h"},
      {"sim/stream/recording.h", "sim/score/drift.h"}, {"sim/stream/recording.h", "mujoco/mujoco.h"},
      {"sim/stream/recording.h", "slam/filter.h"},     {"sim/world/world.cc", "slam/filter.h"},
      {"sim/world/world.cc", "sim/score/drift.h"},     {"sim/bench/scenario.h", "sim/world/world.h"},
      {"sim/bench/replay.cc", "sim/bench/run.h"},      {"sim/bench/replay.cc", "GL/gl.h"},
      {"sim/bench/result.cc", "mujoco/mujoco.h"},      {"walking/plan.h", "unistd.h"},
      {"sim/tune/trial_log.cc", "sim/world/world.h"},  {"sim/tune/trial_log.cc", "sim/bench/run.h"},
      {"sim/bench/replay.cc", "sim/tune/trial_log.h"}};
  for (const auto& [file, included] : planted) {
    const std::string forbidden = std::string(file) + ": " + included;
    EXPECT_THAT(violations(file, "#include <vector>\n#include \"" + std::string(included) + "\"\n"),
                ElementsAre(forbidden));
    EXPECT_THAT(violations(file, "  #  include\t<" + std::string(included) + ">  // why\n"),
                ElementsAre(forbidden));
  }
  EXPECT_THAT(violations("slam/filter.cc", "#include HEADER\n"), ElementsAre("slam/filter.cc: ?"));
}

TEST(IncludeRule, WhatIsAllowedIsNotReported) {
  EXPECT_THAT(
      violations("slam/filter.cc", "#include <cmath>\n#include <Eigen/Core>\n#include \"slam/kalman.h\"\n"),
      IsEmpty());
  EXPECT_THAT(
      violations("sim/bench/run.cc", "#include \"sim/world/world.h\"\n#include \"sim/bench/run.h\"\n"),
      IsEmpty());
  EXPECT_THAT(violations("sim/bench/scenario.h", "#include \"sim/world/options.h\"\n"), IsEmpty());
}

}  // namespace
