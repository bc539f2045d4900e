// Which changes of sources make recordings stale, by the hash that the build computes.
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "tests/tools/command_line.h"

namespace {

std::string source_text(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(GAITSLAM_SOURCE_DIR "/" + file).rdbuf();
  EXPECT_FALSE(text.str().empty()) << file;
  return text.str();
}

class RecordingSources : public tests::CommandLine {
 protected:
  RecordingSources() {
    shell("mkdir -p copy/sim && cd '" GAITSLAM_SOURCE_DIR "' && cp -r README.md walking slam '" +
          (folder_ / "copy").string() +
          "' && cp -r sim/physics sim/camera sim/room sim/files sim/recording sim/sensor_errors sim/score "
          "sim/live "
          "sim/scenario "
          "sim/regression '" +
          (folder_ / "copy/sim").string() + "'");
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
  const std::string line = hash(), digits = line.substr(line.find('"') + 1, 16);
  EXPECT_EQ(digits.find_first_not_of("0123456789abcdef"), std::string::npos) << line;
  EXPECT_EQ(hash(), line);
  for (const char* file :
       {"walking/footsteps.cc", "walking/stabilizer.h", "walking/new.cc", "sim/physics/world.cc",
        "sim/camera/scene.cc", "sim/room/canvas.cc", "sim/live/run.cc", "sim/recording/recording_writer.cc",
        "sim/sensor_errors/random.cc"})
    EXPECT_TRUE(is_shaped_by(file)) << file;
  for (const char* file :
       {"README.md", "slam/filter.cc", "sim/regression/verdict.cc", "sim/sensor_errors/image_errors.cc"})
    EXPECT_FALSE(is_shaped_by(file)) << file;
}

// Headers of the run and the writer shape recordings, except those listed here.
TEST_F(RecordingSources, AreAllThatTheRunAndTheWriterIncludeButWhatIsNamedHere) {
  const std::set<std::string> others{
      "sim/result/score_input.h",  "sim/result/result.h", "sim/scenario/scenario.h",
      "sim/files/atomic_file.h",   "sim/files/text.h",    "sim/sensor_errors/motion_clock.h",
      "sim/live/room_check.h",     "sim/result/timing.h", "sim/tracking/tracking.h",
      "sim/sensor_errors/faults.h"};  // its keys are in the cache's key
  const std::regex ours("#include \"(sim/[\\w/]+\\.h)\"");
  std::set<std::string> included;
  for (const char* file :
       {"sim/live/run.cc", "sim/live/run.h", "sim/live/self_check.h", "sim/live/frame_pipeline.h",
        "sim/live/frame_pipeline.cc", "sim/live/steering_pose_buffer.h", "sim/live/steering_pose_buffer.cc",
        "sim/live/recorded.h", "sim/live/recorded.cc", "sim/recording/recording_writer.cc"}) {
    const std::string text = source_text(file);
    for (std::sregex_iterator i(text.begin(), text.end(), ours), end; i != end; ++i) included.insert((*i)[1]);
  }
  EXPECT_GT(included.size(), 10u);
  for (const std::string& header : included)
    EXPECT_TRUE(others.contains(header) || is_shaped_by(header))
        << header << ": a change leaves stale recordings";
}

TEST_F(RecordingSources, OneThatIsGoneIsAnErrorOfTheBuild) {
  shell("rm copy/sim/live/recorded.cc");
  EXPECT_EQ(hash(), "");
}

}  // namespace
