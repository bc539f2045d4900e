// Which changes of sources make recordings stale, by the hash that the build computes.
#include <gmock/gmock.h>

#include <regex>
#include <set>

#include "sim/files/text.h"
#include "tests/tools/command_line.h"

namespace {

class RecordingSources : public tests::CommandLine {
 protected:
  RecordingSources() {
    shell("mkdir -p copy/sim && to=$PWD/copy && cd '" GAITSLAM_SOURCE_DIR
          "' && cp -r README.md walking slam \"$to\" && cp -r sim/physics sim/camera sim/room sim/files "
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
  EXPECT_THAT(hash(), testing::ContainsRegex("\"[0-9a-f]{16}"));
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
        "sim/live/frame_pipeline.cc", "sim/live/steering_pose_buffer.h", "sim/live/steering_pose_buffer.cc",
        "sim/live/recorded.h", "sim/live/recorded.cc", "sim/recording/recording_writer.cc"}) {
    const std::string text = sim::files::read_text(std::string(GAITSLAM_SOURCE_DIR "/") + file);
    for (std::sregex_iterator i(text.begin(), text.end(), ours), end; i != end; ++i) included.insert((*i)[1]);
  }
  EXPECT_GT(included.size(), 10u);
  for (const std::string& header : included)
    EXPECT_TRUE(others.contains(header) || is_shaped_by(header))
        << header << ": a change leaves stale recordings";
}

}  // namespace
