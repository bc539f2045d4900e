// The project's own files: the front page shows the last measurements of tools/figures/front_page.py, and
// each folder has a rule about what its files may include. The linker cannot enforce it, since Debian's
// headers of MuJoCo, OpenGL and OpenCV are in the compiler's default path.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;

/// Files with the prefix `files` may include headers with one of these prefixes, and the standard library.
struct Rule {
  std::string_view files;
  std::vector<std::string_view> may_include;
};

/// The first rule that matches a file applies.
const std::vector<Rule>& rules() {
  static const std::vector<Rule> all{
      {"walking/", {"walking/", "Eigen/"}},
      {"slam/", {"slam/", "Eigen/", "opencv2/core", "opencv2/imgproc"}},
      {"sim/files/",
       {"sim/files/", "Eigen/", "fmt/", "nlohmann/", "sha2.h", "xxhash.h", "fcntl.h", "signal.h", "unistd.h",
        "sys/"}},
      {"sim/score/", {"sim/score/", "sim/files/", "Eigen/", "boost/math/", "fmt/"}},
      {"sim/trajectory_score/",
       {"sim/trajectory_score/", "sim/score/", "sim/files/", "Eigen/", "fmt/", "nlohmann/"}},
      {"sim/sensor_errors/",
       {"sim/sensor_errors/", "slam/observation.h", "walking/keys.h", "Eigen/", "opencv2/core", "fmt/"}},
      {"sim/recording/",
       {"sim/recording/", "sim/score/types.h", "sim/files/", "sim/sensor_errors/", "slam/camera.h",
        "slam/observation.h", "slam/options.h", "Eigen/", "opencv2/core", "opencv2/imgcodecs", "fmt/",
        "yaml-cpp/", "libdeflate.h", "nlohmann/", "dlfcn.h", "fcntl.h", "unistd.h", "sys/"}},
      {"sim/export/",
       {"sim/export/", "sim/recording/", "sim/files/", "sim/sensor_errors/", "slam/camera.h",
        "slam/observation.h", "slam/options.h", "Eigen/", "opencv2/core", "fmt/", "libdeflate.h"}},
      {"sim/physics/", {"sim/physics/", "walking/", "Eigen/", "fmt/", "mujoco/", "unistd.h"}},
      {"sim/camera/",
       {"sim/camera/", "sim/physics/", "sim/room/", "sim/score/types.h", "walking/", "Eigen/", "fmt/",
        "mujoco/", "GL/", "opencv2/core", "opencv2/imgproc", "dlfcn.h"}},
      {"sim/room/", {"sim/room/", "opencv2/core", "opencv2/imgproc"}},
      {"sim/estimators/",
       {"sim/estimators/", "sim/files/hash.h", "slam/", "Eigen/", "opencv2/core", "fmt/", "errno.h",
        "fcntl.h", "poll.h", "signal.h", "stddef.h", "stdint.h", "stdio.h", "stdlib.h", "string.h", "time.h",
        "unistd.h", "sys/"}},
      {"sim/scenario/",
       {"sim/scenario/", "sim/estimators/", "sim/files/", "sim/sensor_errors/", "sim/score/metrics.h",
        "sim/physics/options.h", "sim/camera/options.h", "slam/observation.h", "slam/options.h", "walking/",
        "Eigen/", "fmt/", "yaml-cpp/"}},
      {"sim/tracking/",
       {"sim/tracking/", "sim/estimators/", "sim/scenario/", "sim/sensor_errors/", "slam/", "Eigen/"}},
      {"sim/result/",
       {"sim/result/", "sim/tracking/", "sim/scenario/", "sim/recording/", "sim/score/", "sim/files/",
        "slam/", "walking/", "Eigen/", "fmt/", "nlohmann/", "time.h"}},
      {"sim/replay/",
       {"sim/replay/", "sim/result/", "sim/tracking/", "sim/scenario/", "sim/recording/", "sim/score/",
        "sim/files/", "slam/", "Eigen/", "fmt/", "nlohmann/"}},
      {"sim/regression/",
       {"sim/regression/", "sim/result/", "sim/scenario/", "sim/score/", "sim/files/", "fmt/", "nlohmann/"}},
      {"sim/pages/",
       {"sim/pages/", "sim/regression/", "sim/replay/", "sim/result/", "sim/tracking/", "sim/scenario/",
        "sim/recording/", "sim/score/", "sim/files/", "slam/", "Eigen/", "fmt/", "nlohmann/",
        "opencv2/core"}},
      {"sim/view/live/",
       {"sim/view/", "sim/live/", "sim/physics/", "sim/camera/", "sim/export/", "sim/recording/",
        "sim/files/", "walking/plan.h", "Eigen/", "fmt/", "opencv2/", "mujoco/"}},
      {"sim/view/",
       {"sim/view/", "sim/pages/", "sim/export/", "sim/result/", "sim/tracking/", "sim/scenario/",
        "sim/recording/", "sim/score/", "sim/files/", "slam/", "walking/hrp2.h", "Eigen/", "fmt/",
        "nlohmann/", "opencv2/", "boost/asio/", "boost/beast/", "arpa/inet.h", "sys/random.h"}},
      {"sim/trials/",
       {"sim/trials/", "sim/replay/", "sim/result/", "sim/tracking/", "sim/scenario/", "sim/recording/",
        "sim/sensor_errors/random.h", "sim/score/", "sim/files/", "slam/", "Eigen/", "fmt/", "nlohmann/",
        "opencv2/core", "boost/random/", "fcntl.h", "unistd.h", "sys/"}},
      {"sim/live/",
       {"sim/live/", "sim/physics/", "sim/camera/", "sim/result/", "sim/tracking/", "sim/scenario/",
        "sim/recording/", "sim/sensor_errors/random.h", "sim/sensor_errors/faults.h", "sim/score/",
        "sim/files/", "slam/", "walking/", "Eigen/", "fmt/", "nlohmann/", "opencv2/core", "opencv2/imgproc"}},
      {"tools/cli/jobs/",
       {"tools/cli/", "sim/trials/", "sim/regression/", "sim/result/", "sim/recording/", "sim/scenario/",
        "sim/files/", "CLI/", "fmt/", "nlohmann/", "fcntl.h", "signal.h", "spawn.h", "unistd.h", "sys/"}},
  };
  return all;
}

/// Names of the standard library (<vector>, <cmath>) have neither folders nor endings.
bool is_allowed(const Rule& rule, std::string_view included) {
  const bool is_standard = included.find_first_of("./") == included.npos;
  const bool listed = std::any_of(rule.may_include.begin(), rule.may_include.end(),
                                  [&](std::string_view prefix) { return included.starts_with(prefix); });
  return (listed || is_standard) && included.find("..") == included.npos;
}

/// The names of the #includes of a text; "?" for a macro.
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
      if (included == "?" || !is_allowed(rule, included)) found.push_back(file + ": " + included);
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

/// For each unit, a header X.h with its source X.cc, named "X": the units that it includes.
using IncludeGraph = std::map<std::string, std::set<std::string>>;

std::string unit_of(const fs::path& file) { return fs::path(file).replace_extension().generic_string(); }

void add_includes(IncludeGraph& graph, const fs::path& file, const std::string& text) {
  const std::string unit = unit_of(file);
  graph[unit];
  for (const std::string& included : includes(text))
    if (included.ends_with(".h") && unit_of(included) != unit) graph[unit].insert(unit_of(included));
}

std::set<std::string> reachable(const IncludeGraph& graph, const std::string& from) {
  std::set<std::string> reached;
  std::vector<std::string> open{from};
  while (!open.empty()) {
    const auto found = graph.find(open.back());
    open.pop_back();
    if (found == graph.end()) continue;
    for (const std::string& next : found->second)
      if (reached.insert(next).second) open.push_back(next);
  }
  return reached;
}

/// The units that need each other, as "a b c", one text for each group.
std::set<std::string> cycles(const IncludeGraph& graph) {
  std::map<std::string, std::set<std::string>> reached;
  for (const auto& [unit, included] : graph) reached[unit] = reachable(graph, unit);
  std::set<std::string> found;
  for (const auto& [unit, units] : reached) {
    if (!units.contains(unit)) continue;
    std::string group;
    for (const std::string& other : units)
      if (reached[other].contains(unit)) group += (group.empty() ? "" : " ") + other;
    found.insert(group);
  }
  return found;
}

TEST(IncludeRule, EachFolderSeesOnlyWhatItMay) {
  std::set<std::string_view> ruled;
  for (const Rule& rule : rules()) {
    ruled.insert(rule.files);
    const auto files = sources_below(kRoot / rule.files);
    EXPECT_GE(files.size(), 2u) << rule.files << ": too few files for a test that would notice";
    for (const fs::path& file : files)
      EXPECT_THAT(violations(fs::relative(file, kRoot), text_of(file)), IsEmpty());
  }
  for (const auto& entry : fs::directory_iterator(kRoot / "sim"))
    if (entry.is_directory()) {
      EXPECT_TRUE(ruled.contains("sim/" + entry.path().filename().string() + "/")) << entry.path();
    }
}

TEST(IncludeRule, OnlyTheLivePartOfTheProgramSeesTheSimulator) {
  for (const fs::path& file : sources_below(kRoot / "tools/cli")) {
    if (file.filename() == "live_world.cc") continue;
    for (const std::string& included : includes(text_of(file))) {
      EXPECT_FALSE(included.starts_with("mujoco/") || included.starts_with("sim/physics/") ||
                   included.starts_with("sim/camera/") || included.starts_with("sim/room/") ||
                   included.starts_with("sim/live/"))
          << file << ": " << included;
    }
  }
}

TEST(IncludeRule, PlantedViolationsAreFoundAndWhatIsAllowedIsNotReported) {
  const std::pair<const char*, const char*> planted[]{{"slam/filter.cc", "sim/physics/world.h"},
                                                      {"slam/filter.cc", "slam/../sim/physics/world.h"},
                                                      {"slam/filter.cc", "mujoco/mujoco.h"},
                                                      {"walking/plan.h", "slam/options.h"},
                                                      {"sim/files/csv.h", "slam/observation.h"},
                                                      {"sim/score/drift.cc", "walking/plan.h"},
                                                      {"sim/recording/recording.h", "sim/score/drift.h"},
                                                      {"sim/scenario/scenario.h", "sim/physics/world.h"},
                                                      {"tools/cli/jobs/slurm.cc", "sim/live/run.h"}};
  for (const auto& [file, included] : planted)
    for (const std::string line : {"#include <vector>\n#include \"@\"\n", "  #  include\t<@>  // why\n"})
      EXPECT_THAT(violations(file, std::string(line).replace(line.find('@'), 1, included)),
                  ElementsAre(std::string(file) + ": " + included));
  EXPECT_THAT(violations("slam/filter.cc", "#include HEADER\n"), ElementsAre("slam/filter.cc: ?"));
  EXPECT_THAT(
      violations("slam/filter.cc", "#include <cmath>\n#include <Eigen/Core>\n#include \"slam/kalman.h\"\n"),
      IsEmpty());
  EXPECT_THAT(violations("sim/scenario/scenario.h", "#include \"sim/physics/options.h\"\n"), IsEmpty());
}

TEST(IncludeRule, NoTwoFilesNeedEachOther) {
  IncludeGraph graph;
  for (const char* folder : {"walking", "slam", "sim", "tools"})
    for (const fs::path& file : sources_below(kRoot / folder))
      add_includes(graph, fs::relative(file, kRoot), text_of(file));
  EXPECT_GT(graph.size(), 200u) << "too few files for a test that would notice";
  EXPECT_THAT(cycles(graph), IsEmpty());
}

TEST(IncludeRule, FilesThatNeedEachOtherAreFound) {
  IncludeGraph graph;
  add_includes(graph, "a/shape.h", "#include \"a/point.h\"\n");
  add_includes(graph, "a/point.h", "#include <vector>\n");
  add_includes(graph, "a/point.cc", "#include \"a/point.h\"\n");
  add_includes(graph, "a/user.cc", "#include \"a/shape.h\"\n");
  EXPECT_THAT(cycles(graph), IsEmpty());
  add_includes(graph, "a/text.h", "#include \"a/shape.h\"\n");
  add_includes(graph, "a/point.cc", "#include \"a/text.h\"\n");
  EXPECT_THAT(cycles(graph), ElementsAre("a/point a/shape a/text"));
}

/// The text between the markers of a part of the page, or "marker missing".
std::string shown(const std::string& page, const std::string& part) {
  const std::string begin = "<!-- " + part + ": tools/figures/front_page.py -->\n",
                    end = "<!-- end of " + part + " -->\n";
  const std::size_t from = page.find(begin), to = page.find(end);
  if (from == page.npos || to == page.npos) return "marker missing";
  return page.substr(from + begin.size(), to - from - begin.size());
}

TEST(FrontPage, ShowsWhatItsScriptMeasuredLast) {
  const std::string page = text_of(kRoot / "README.md"),
                    stored = text_of(kRoot / "tools/figures/front_page.md");
  ASSERT_GT(stored.size(), 1000u);
  EXPECT_EQ(shown(page, "scores") + "\n" + shown(page, "first run"), stored);
}

TEST(FrontPage, IsOnePage) {
  const std::string page = text_of(kRoot / "README.md");
  EXPECT_LE(std::count(page.begin(), page.end(), '\n'), 150);
}

}  // namespace
