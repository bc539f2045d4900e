// The project's own files: the front page shows the last measurements of tools/figures/front_page.py, and
// each folder has a rule about what its files may include. The linker cannot enforce it, since Debian's
// headers of MuJoCo, OpenGL and OpenCV are in the compiler's default path.
#include <cctype>
#include <map>
#include <set>
#include <sstream>

#include "sim/files/text.h"
#include "tests/tools/command_line.h"

namespace tests {
namespace {

using testing::ElementsAre;

/// Files with the prefix `files` may include headers with one of these prefixes, and the standard library.
struct Rule {
  std::string files, may_include;
};

/// The first rule that matches a file applies.
const std::vector<Rule>& rules() {
  static const std::vector<Rule> all{
      {"walking/", "walking/ Eigen/"},
      {"slam/", "slam/ Eigen/ opencv2/core opencv2/imgproc"},
      {"sim/files/", "sim/files/ Eigen/ fmt/ nlohmann/ sha2.h xxhash.h fcntl.h signal.h unistd.h sys/"},
      {"sim/score/", "sim/score/ sim/files/ Eigen/ boost/math/ fmt/"},
      {"sim/trajectory_score/", "sim/trajectory_score/ sim/score/ sim/files/ Eigen/ fmt/ nlohmann/"},
      {"sim/rig/", "sim/rig/ slam/camera.h slam/options.h Eigen/ fmt/"},
      {"sim/sensor_errors/",
       "sim/sensor_errors/ sim/rig/ slam/observation.h walking/keys.h Eigen/ opencv2/core "
       "opencv2/imgproc fmt/"},
      {"sim/recording/",
       "sim/recording/ sim/rig/ sim/score/types.h sim/files/ sim/sensor_errors/ slam/camera.h "
       "slam/observation.h "
       "slam/options.h Eigen/ opencv2/core opencv2/imgcodecs fmt/ yaml-cpp/ libdeflate.h nlohmann/ dlfcn.h "
       "fcntl.h unistd.h sys/"},
      {"sim/export/",
       "sim/export/ sim/recording/ sim/rig/ sim/files/ sim/sensor_errors/ slam/camera.h slam/observation.h "
       "slam/options.h Eigen/ opencv2/core fmt/ libdeflate.h"},
      {"sim/physics/", "sim/physics/ sim/rig/ walking/ Eigen/ fmt/ mujoco/ unistd.h"},
      {"sim/camera/",
       "sim/camera/ sim/physics/ sim/rig/ sim/room/ sim/score/types.h slam/observation.h walking/ Eigen/ "
       "fmt/ "
       "mujoco/ GL/ opencv2/core opencv2/imgproc dlfcn.h"},
      {"sim/room/", "sim/room/ opencv2/core opencv2/imgproc"},
      {"sim/estimators/",
       "sim/estimators/ sim/rig/ sim/files/hash.h slam/ Eigen/ opencv2/core fmt/ errno.h fcntl.h poll.h "
       "signal.h "
       "stddef.h stdint.h stdio.h stdlib.h string.h time.h unistd.h sys/"},
      {"sim/scenario/",
       "sim/scenario/ sim/estimators/ sim/rig/ sim/files/ sim/sensor_errors/ sim/score/metrics.h "
       "sim/physics/options.h sim/camera/options.h slam/observation.h slam/options.h walking/ Eigen/ fmt/ "
       "yaml-cpp/"},
      {"sim/tracking/",
       "sim/tracking/ sim/estimators/ sim/rig/ sim/scenario/ sim/sensor_errors/ slam/ Eigen/"},
      {"sim/result/",
       "sim/result/ sim/tracking/ sim/scenario/ sim/recording/ sim/score/ sim/files/ slam/ walking/ Eigen/ "
       "fmt/ nlohmann/ time.h"},
      {"sim/replay/",
       "sim/replay/ sim/result/ sim/tracking/ sim/scenario/ sim/recording/ sim/score/ sim/files/ slam/ "
       "Eigen/ fmt/ nlohmann/"},
      {"sim/regression/", "sim/regression/ sim/result/ sim/scenario/ sim/score/ sim/files/ fmt/ nlohmann/"},
      {"sim/pages/",
       "sim/pages/ sim/rig/ sim/regression/ sim/replay/ sim/result/ sim/tracking/ sim/scenario/ "
       "sim/recording/ "
       "sim/score/ sim/files/ slam/ Eigen/ fmt/ nlohmann/ opencv2/core opencv2/imgproc"},
      {"sim/view/live/",
       "sim/view/ sim/live/ sim/rig/ sim/physics/ sim/camera/ sim/export/ sim/recording/ sim/files/ "
       "walking/plan.h "
       "Eigen/ fmt/ nlohmann/ opencv2/ mujoco/"},
      {"sim/view/",
       "sim/view/ sim/pages/ sim/rig/ sim/export/ sim/result/ sim/tracking/ sim/scenario/ sim/recording/ "
       "sim/score/ "
       "sim/files/ slam/ walking/hrp2.h Eigen/ fmt/ nlohmann/ opencv2/ boost/asio/ boost/beast/ "
       "sys/random.h"},
      {"sim/trials/",
       "sim/trials/ sim/replay/ sim/result/ sim/tracking/ sim/scenario/ sim/recording/ "
       "sim/sensor_errors/random.h sim/score/ sim/files/ slam/ Eigen/ fmt/ nlohmann/ opencv2/core "
       "boost/random/ fcntl.h unistd.h sys/"},
      {"sim/live/",
       "sim/live/ sim/physics/ sim/camera/ sim/rig/ sim/result/ sim/tracking/ sim/scenario/ sim/recording/ "
       "sim/sensor_errors/random.h sim/sensor_errors/faults.h sim/score/ sim/files/ slam/ walking/ Eigen/ "
       "fmt/ nlohmann/ opencv2/core opencv2/imgproc"},
      {"tools/cli/jobs/",
       "tools/cli/ sim/trials/ sim/regression/ sim/result/ sim/recording/ sim/scenario/ sim/files/ CLI/ fmt/ "
       "nlohmann/ fcntl.h signal.h spawn.h unistd.h sys/"},
  };
  return all;
}

/// The names of the #includes of a text; "?" for a macro.
std::vector<std::string> includes(const std::string& text) {
  std::vector<std::string> names;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::erase_if(line, [](unsigned char c) { return std::isspace(c) != 0; });
    if (!line.starts_with("#include")) continue;
    const std::size_t begin = line.find_first_of("<\""), end = line.find_last_of(">\"");
    names.push_back(begin == line.npos || end <= begin ? "?" : line.substr(begin + 1, end - begin - 1));
  }
  return names;
}

/// Names of the standard library (<vector>, <cmath>) have neither folders nor endings.
bool is_allowed(const Rule& rule, const std::string& included) {
  if (included.find("..") != included.npos) return false;
  bool allowed = included.find_first_of("./?") == included.npos;
  std::istringstream prefixes(rule.may_include);
  for (std::string prefix; prefixes >> prefix;) allowed |= included.starts_with(prefix);
  return allowed;
}

/// "file: included" for each include that the file's rule forbids.
std::vector<std::string> violations(const std::string& file, const std::string& text) {
  std::vector<std::string> found;
  const auto rule = std::find_if(rules().begin(), rules().end(),
                                 [&](const Rule& each) { return file.starts_with(each.files); });
  for (const std::string& included : includes(text))
    if (rule != rules().end() && !is_allowed(*rule, included)) found.push_back(file + ": " + included);
  return found;
}

const fs::path kRoot = GAITSLAM_SOURCE_DIR;

/// Path below the root -> text of each source below a folder.
std::map<std::string, std::string> sources_below(const std::string& folder) {
  std::map<std::string, std::string> texts;
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder))
    if (const fs::path& file = entry.path(); file.extension() == ".h" || file.extension() == ".cc")
      texts[fs::relative(file, kRoot)] = sim::files::read_text(file);
  return texts;
}

std::string unit_of(const std::string& file) { return file.substr(0, file.rfind('.')); }

/// The units, each a header X.h with its source X.cc, that need each other.
std::set<std::string> cycles(const std::map<std::string, std::string>& texts) {
  std::map<std::string, std::set<std::string>> included;
  for (const auto& [file, text] : texts)
    for (const std::string& name : includes(text))
      if (name.ends_with(".h") && unit_of(name) != unit_of(file))
        included[unit_of(file)].insert(unit_of(name));
  std::set<std::string> found;
  for (const auto& [unit, units] : included) {
    std::set<std::string> reached;
    for (std::vector<std::string> open(units.begin(), units.end()); !open.empty();) {
      const std::string next = open.back();
      open.pop_back();
      if (reached.insert(next).second && included.contains(next))
        open.insert(open.end(), included[next].begin(), included[next].end());
    }
    if (reached.contains(unit)) found.insert(unit);
  }
  return found;
}

TEST(IncludeRule, EachFolderSeesOnlyWhatItMay) {
  std::set<std::string> ruled;
  for (const Rule& rule : rules()) {
    ruled.insert(rule.files);
    const auto sources = sources_below(rule.files);
    EXPECT_GE(sources.size(), 1u) << rule.files << ": too few files for a test that would notice";
    for (const auto& [file, text] : sources) EXPECT_THAT(violations(file, text), IsEmpty());
  }
  for (const auto& entry : fs::directory_iterator(kRoot / "sim"))
    EXPECT_TRUE(!entry.is_directory() || ruled.contains("sim/" + entry.path().filename().string() + "/"))
        << entry.path();
}

TEST(IncludeRule, OnlyTheLivePartOfTheProgramSeesTheSimulator) {
  for (const auto& [file, text] : sources_below("tools/cli"))
    for (const std::string& included : includes(text))
      for (const char* const simulator : {"mujoco/", "sim/physics/", "sim/camera/", "sim/room/", "sim/live/"})
        EXPECT_TRUE(file.ends_with("/live_world.cc") || !included.starts_with(simulator))
            << file << ": " << included;
}

TEST(IncludeRule, PlantedViolationsAreFound) {
  for (const auto& [file, included] :
       {std::pair<std::string, std::string>{"slam/filter.cc", "sim/physics/world.h"},
        {"slam/filter.cc", "slam/../sim/physics/world.h"},
        {"walking/plan.h", "mujoco/mujoco.h"},
        {"sim/scenario/scenario.h", "sim/physics/world.h"},
        {"tools/cli/jobs/slurm.cc", "sim/live/run.h"}})
    EXPECT_THAT(violations(file, "  #  include\t<" + included + ">  // why\n"),
                ElementsAre(file + ": " + included));
  EXPECT_THAT(violations("slam/filter.cc", "#include HEADER\n"), ElementsAre("slam/filter.cc: ?"));
}

TEST(IncludeRule, NoTwoFilesNeedEachOther) {
  std::map<std::string, std::string> sources;
  for (const char* folder : {"walking", "slam", "sim", "tools"}) sources.merge(sources_below(folder));
  EXPECT_GT(sources.size(), 200u) << "too few files for a test that would notice";
  EXPECT_THAT(cycles(sources), IsEmpty());
  EXPECT_THAT(cycles({{"a/shape.h", "#include \"a/point.h\"\n"},
                      {"a/point.cc", "#include \"a/text.h\"\n"},
                      {"a/text.h", "#include \"a/shape.h\"\n"},
                      {"a/user.cc", "#include \"a/shape.h\"\n"}}),
              ElementsAre("a/point", "a/shape", "a/text"));
}

TEST(FrontPage, IsOnePageAndShowsWhatItsScriptMeasuredLast) {
  const std::string page = sim::files::read_text(kRoot / "README.md"),
                    stored = sim::files::read_text(kRoot / "tools/figures/front_page.md");
  EXPECT_LE(std::count(page.begin(), page.end(), '\n'), 150);
  const auto shown = [&](const std::string& part) {
    const std::string begin = "<!-- " + part + ": tools/figures/front_page.py -->\n";
    const std::size_t from = page.find(begin) + begin.size();
    return page.substr(from, page.find("<!-- end of " + part + " -->\n") - from);
  };
  ASSERT_GT(stored.size(), 1000u);
  EXPECT_EQ(shown("scores") + "\n" + shown("first run"), stored);
}

/// Which changes of sources make recordings stale, by the hash that the build computes.
class RecordingSources : public CommandLine {
 protected:
  RecordingSources() {
    shell("mkdir -p copy/sim && to=$PWD/copy && cd '" GAITSLAM_SOURCE_DIR
          "' && cp -r README.md walking slam \"$to\" && cp -r sim/physics sim/camera sim/rig sim/room "
          "sim/files "
          "sim/recording sim/sensor_errors sim/score sim/live sim/scenario sim/regression \"$to/sim\"");
  }
  /// The generated source's line of the hash; empty if the build step fails.
  std::string hash() const {
    return shell("'" GAITSLAM_CMAKE
                 "' -DSOURCE=\"$PWD/copy\" -DOUTPUT=\"$PWD/revision.cc\" -P '" GAITSLAM_SOURCE_DIR
                 "/tools/cli/revision.cmake' && grep kRecordingSources revision.cc")
        .out;
  }
  bool is_shaped_by(const std::string& file) const {
    const std::string before = hash();
    shell("echo '// changed' >> copy/" + file);
    return hash() != before;
  }
};

TEST_F(RecordingSources, AreThoseOfWalkWorldAndRecordingAndNotThoseOfFilterScoresAndPages) {
  EXPECT_THAT(hash(), ContainsRegex("\"[0-9a-f]{16}"));
  EXPECT_EQ(hash(), hash());
  for (const char* file : {"walking/footsteps.cc", "walking/new.cc", "sim/physics/world.cc",
                           "sim/camera/scene.cc", "sim/room/paint.cc", "sim/live/run.cc",
                           "sim/recording/recording_writer.cc", "sim/sensor_errors/random.cc"})
    EXPECT_TRUE(is_shaped_by(file)) << file;
  for (const char* file :
       {"README.md", "slam/filter.cc", "sim/regression/verdict.cc", "sim/sensor_errors/image_errors.cc"})
    EXPECT_FALSE(is_shaped_by(file)) << file;
  shell("rm copy/sim/live/recorded.cc");
  EXPECT_EQ(hash(), "") << "a missing source is an error of the build";
}

// Headers of the run and the writer shape recordings, except those listed here.
TEST_F(RecordingSources, AreAllThatTheRunAndTheWriterIncludeButWhatIsNamedHere) {
  const std::set<std::string> others{
      "sim/result/result.h",     "sim/scenario/scenario.h",   "sim/files/atomic_file.h",
      "sim/files/text.h",        "sim/result/limits.h",       "sim/result/timing.h",
      "sim/tracking/tracking.h", "sim/sensor_errors/faults.h"};  // its keys are in the cache's key
  const std::regex ours("#include \"(sim/[\\w/]+\\.h)\"");
  std::set<std::string> included;
  for (const char* file :
       {"sim/live/run.cc", "sim/live/run.h", "sim/live/self_check.h", "sim/live/frame_pipeline.h",
        "sim/live/frame_pipeline.cc", "sim/live/rig_readings.h", "sim/live/rig_readings.cc",
        "sim/live/steering_pose_buffer.h", "sim/live/steering_pose_buffer.cc", "sim/live/recorded.h",
        "sim/live/recorded.cc", "sim/recording/recording_writer.cc"}) {
    const std::string text = sim::files::read_text(std::string(GAITSLAM_SOURCE_DIR "/") + file);
    for (std::sregex_iterator i(text.begin(), text.end(), ours), end; i != end; ++i) included.insert((*i)[1]);
  }
  EXPECT_GT(included.size(), 10u);
  for (const std::string& header : included)
    EXPECT_TRUE(others.contains(header) || is_shaped_by(header))
        << header << ": a change leaves stale recordings";
}

}  // namespace
}  // namespace tests
