// The hash of the sources that shape recordings, as the build takes it: which changes make recordings stale.
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

TEST_F(RecordingSources, AreAllThatTheRunAndTheWriterIncludeButWhatIsNamedHere) {
  const std::set<std::string> others{"sim/bench/evidence.h",    "sim/bench/result.h",
                                     "sim/bench/scenario.h",    "sim/stream/durable_file.h",
                                     "sim/stream/file_error.h", "sim/stream/motion_clock.h"};
  const std::string list = source_text("tools/cli/recording_sources.cmake");
  const std::regex ours("#include \"(sim/(?:bench|stream)/(\\w+)\\.h)\"");
  for (const char* file : {"sim/bench/run.cc", "sim/bench/run.h", "sim/bench/draw.cc",
                           "sim/bench/planned_camera.cc", "sim/stream/recording_writer.cc"}) {
    const std::string text = source_text(file);
    for (std::sregex_iterator i(text.begin(), text.end(), ours), end; i != end; ++i)
      EXPECT_TRUE(std::regex_search(list, std::regex("\\b" + (*i)[2].str() + "\\b")) ||
                  others.contains((*i)[1]))
          << (*i)[1] << " is included by " << file << ": does it shape what is recorded?";
  }
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
