// The hash of the sources that shape recordings, as the build takes it: which changes make recordings stale.
#include "tests/tools/command_line.h"

namespace {

class RecordingSources : public tests::CommandLine {
 protected:
  RecordingSources() {
    shell("mkdir -p copy/sim && cd '" GAITSLAM_SOURCE_DIR "' && cp -r README.md walking slam '" +
          (folder_ / "copy").string() + "' && cp -r sim/world sim/stream sim/bench '" +
          (folder_ / "copy/sim").string() + "'");
  }
  /// The generated source's line of the hash.
  std::string hash() const {
    const tests::Ran ran = shell(
        "'" GAITSLAM_CMAKE "' -DSOURCE=\"$PWD/copy\" -DOUTPUT=\"$PWD/revision.cc\" -P '" GAITSLAM_SOURCE_DIR
        "/tools/cli/revision.cmake' && grep kRecordingSources revision.cc");
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    return ran.out;
  }
  bool is_shaped_by(const std::string& file) const {
    const std::string before = hash();
    shell("echo '// changed' >> copy/" + file);
    return hash() != before;
  }
};

TEST_F(RecordingSources, HaveAHash) {
  const std::string line = hash(), digits = line.substr(line.find('"') + 1, 16);
  EXPECT_EQ(digits.find_first_not_of("0123456789abcdef"), std::string::npos) << line;
  EXPECT_EQ(hash(), line);
}

TEST_F(RecordingSources, AreThoseOfWalkWorldAndRecording) {
  for (const char* file : {"walking/footsteps.cc", "walking/stabilizer.h", "sim/world/world.cc",
                           "sim/bench/run.cc", "sim/stream/recording_writer.cc", "sim/stream/random.cc"})
    EXPECT_TRUE(is_shaped_by(file)) << file;
  EXPECT_TRUE(is_shaped_by("walking/new.cc")) << "a new file";
}

TEST_F(RecordingSources, AreNotThoseOfFilterScoresAndPages) {
  for (const char* file :
       {"README.md", "slam/filter.cc", "sim/bench/verdict.cc", "sim/stream/image_errors.cc"})
    EXPECT_FALSE(is_shaped_by(file)) << file;
}

TEST_F(RecordingSources, OneThatIsGoneIsAnErrorOfTheBuild) {
  shell("rm copy/sim/bench/draw.cc");
  EXPECT_NE(shell("'" GAITSLAM_CMAKE
                  "' -DSOURCE=\"$PWD/copy\" -DOUTPUT=\"$PWD/revision.cc\" -P '" GAITSLAM_SOURCE_DIR
                  "/tools/cli/revision.cmake'")
                .exit_code,
            0);
}

}  // namespace
