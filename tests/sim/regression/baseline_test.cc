#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/files/text.h"
#include "sim/regression/results.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::regression {
namespace {

using testing::HasSubstr;

Baseline example() {
  Baseline baseline;
  baseline.history = {{"abc", "a \"first\" one", "some processor"}, {"def", "better", "another"}};
  ScenarioResults walk{"walk", {{"walk.step_length_m", "0.1"}, {"walk.commands", "\n  - stand: {}"}}, {}};
  walk.seeds.push_back(
      {1, scenario::Ending::completed, 0, {{"rmse_m", "m", 0.1}, {"loop_closed", "1", {}}}, "aa"});
  walk.seeds.push_back(
      {7, scenario::Ending::fell, 3, {{"rmse_m", "m", 1.0 / 3}, {"loop_closed", "1", 1.0}}, "bb"});
  baseline.scenarios.push_back(walk);
  return baseline;
}

class BaselineTest : public testing::Test {
 protected:
  BaselineTest() { write_baseline(file_, example()); }
  std::string text() const { return files::read_text(file_); }
  void expect_refused(const std::string& text, const std::string& why) const {
    files::write_text(file_, text);
    try {
      read_baseline(file_);
      ADD_FAILURE() << why;
    } catch (const files::FileError& e) {
      EXPECT_THAT(e.what(), HasSubstr(why));
      EXPECT_THAT(e.what(), HasSubstr("ci.json"));
    }
  }
  const files::TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_ / "ci.json";
};

TEST_F(BaselineTest, ReadsBackWhatWasWrittenToTheBit) {
  EXPECT_THAT(text(), HasSubstr("\n\"rmse_m\": [0.1,0.3333333333333333],\n")) << "a metric is a line";
  const Baseline read = read_baseline(file_);
  ASSERT_EQ(read.history.size(), 2u);
  EXPECT_EQ(read.history[0].reason, "a \"first\" one");
  EXPECT_EQ(read.history[1].processor, "another");
  ASSERT_NE(read.find("walk"), nullptr);
  EXPECT_EQ(read.find("run"), nullptr);
  const ScenarioResults& walk = *read.find("walk");
  EXPECT_EQ(walk.config, example().scenarios[0].config);
  ASSERT_EQ(walk.seeds.size(), 2u);
  EXPECT_EQ(walk.seeds[1].seed, 7u);
  EXPECT_EQ(walk.seeds[1].ending, scenario::Ending::fell);
  EXPECT_EQ(walk.seeds[1].exit_code, 3);
  EXPECT_EQ(walk.seeds[1].recording, "bb");
  EXPECT_EQ(walk.seeds[1].metrics[0].value, 1.0 / 3);
  EXPECT_FALSE(walk.seeds[0].metrics[1].value);
  EXPECT_EQ(walk.seeds[0].metrics[0].unit, "m");
}

TEST_F(BaselineTest, AnyChangedByteIsFound) {
  const std::string whole = text();
  for (std::size_t at = 0; at < whole.size(); at += 7) {
    std::string changed = whole;
    changed[at] ^= 1;
    files::write_text(file_, changed);
    EXPECT_THROW(read_baseline(file_), files::FileError) << at;
  }
  std::string edited = whole;
  edited.replace(edited.find("0.1,"), 3, "0.2");
  expect_refused(edited, "was edited after it was written");
  expect_refused(whole.substr(0, whole.size() / 2), "not a baseline file, or truncated");
  expect_refused("", "not a baseline");
  expect_refused(whole + " ", "was edited");
}

TEST_F(BaselineTest, OneThatIsNotThereSaysHowToMakeIt) {
  try {
    read_baseline(folder_ / "none.json");
    FAIL();
  } catch (const files::FileError& e) {
    EXPECT_THAT(e.what(),
                HasSubstr("none.json: does not exist; 'gaitslam baseline update' makes a baseline"));
  }
}

TEST_F(BaselineTest, ItsConfigurationsHashIsOfKeysAndValues) {
  EXPECT_EQ(config_hash({{"a", "1"}}), config_hash({{"a", "1"}}));
  EXPECT_NE(config_hash({{"a", "1"}}), config_hash({{"a", "2"}}));
  EXPECT_NE(config_hash({{"a", "1"}}), config_hash({{"a", "1"}, {"b", ""}}));
}

}  // namespace
}  // namespace sim::regression
