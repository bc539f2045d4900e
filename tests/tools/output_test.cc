// Output of run, replay and score: text, one JSON document, or nothing.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/tools/command_line.h"

namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;
using tests::Ran;

class OutputTest : public tests::CommandLine {
 protected:
  OutputTest() { write("walk.yaml", std::string(tests::kShortWalk) + "limits: {rmse_m: {at_most: 1}}\n"); }

  /// The JSON document that a command prints, after a check against its schema.
  json document_of(const std::string& arguments, const std::string& schema) const {
    const Ran ran = gaitslam(arguments);
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    EXPECT_EQ(ran.complaints(), "");
    write("printed.json", ran.out);
    const Ran found = checked(schema, "printed.json");
    EXPECT_EQ(found.exit_code, 0) << found.err;
    return json::parse(ran.out);
  }
  Ran checked(const std::string& schema, const std::string& file) const {
    return shell("/usr/bin/python3 '" GAITSLAM_SOURCE_DIR
                 "/tests/tools/check_schema.py' '" GAITSLAM_SOURCE_DIR "/sim/result/schemas/" +
                 schema + ".schema.json' " + file);
  }
  void expect_silence(const std::string& arguments, int exit_code) const {
    const Ran ran = gaitslam(arguments);
    EXPECT_EQ(ran.exit_code, exit_code) << arguments;
    EXPECT_EQ(ran.out + ran.err, "") << arguments;
  }
};

TEST_F(OutputTest, JsonIsOneDocumentAndFilesAreAsTheirSchemasSay) {
  const json run = document_of("run walk.yaml --out r --json", "outcome");
  EXPECT_EQ(run["folder"], "r/seed-1");
  EXPECT_EQ(run["ending"], "completed");
  EXPECT_EQ(run["score"], json::parse(text_of("r/seed-1/score.json")));
  const json replay = document_of("replay r/seed-1 --json", "outcome");
  EXPECT_EQ(replay["score"], run["score"]);
  const json score = document_of("score r/seed-1 --json", "trajectory");
  EXPECT_GT(score["errors"].size(), 2u);

  write("stand.yaml", tests::kStand);
  const json seeds = document_of("run stand.yaml estimator=plan_alone --seeds 1,2 --out s --json", "outcome");
  EXPECT_EQ(seeds["summary"], json::parse(text_of("s/summary.json")));
  for (const auto& [schema, file] : {std::pair{"score", "s/seed-1/score.json"},
                                     {"about", "s/seed-1/about.json"},
                                     {"summary", "s/summary.json"},
                                     {"score", "r/seed-1/score.json"}})
    EXPECT_EQ(checked(schema, file).exit_code, 0) << file;
  write("wrong.json", R"({"format_version": 1, "scenario": 7})");
  EXPECT_NE(checked("score", "wrong.json").exit_code, 0);
}

TEST_F(OutputTest, QuietLeavesTheExitCode) {
  expect_silence("run walk.yaml --out r -q", 0);
  expect_silence("replay r/seed-1 --quiet", 0);
  expect_silence("score r/seed-1 -q", 0);
  write("strict.yaml", "base: walk.yaml\nlimits: {rmse_m: {at_most: 0}}\n");
  expect_silence("run strict.yaml --seeds 1 --out s -q", 1);
  EXPECT_THAT(refusal("run none.yaml -q"), HasSubstr("none.yaml: cannot be read"));
  EXPECT_THAT(refusal("run walk.yaml -q --json"), HasSubstr("excludes"));
}

}  // namespace
