// A filter that cannot see reports it, consistently in every file, in the table and by the exit code.
#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/tools/command_line.h"

namespace {

using testing::HasSubstr;
using tests::Ran;

// Times that suit a walk of 3 s.
constexpr const char* kShortTimes = R"(
slam.tracking: {lost_after_s: 0.4, give_up_s: 0.6}
limits: {ending: [completed], tracked_fraction: {at_least: 0.99}}
)";

class Health : public tests::CommandLine {
 protected:
  Health() {
    short_walks("r");
    write("times.yaml", kShortTimes);
  }

  Ran replay(const std::string& changes) const {
    return gaitslam("replay r/seed-1 --with times.yaml --out out --force " + changes);
  }
  nlohmann::json score() const { return nlohmann::json::parse(text_of("out/score.json")); }
  // The fields of frames.csv from `health` on, one row each.
  std::vector<std::string> health_rows() const {
    std::istringstream file(text_of("out/frames.csv"));
    std::vector<std::string> rows;
    for (std::string line; std::getline(file, line);) {
      const auto at = std::min({line.find(",ok,"), line.find(",lost,"), line.find(",diverged,")});
      if (at != line.npos) rows.push_back(line.substr(at + 1));
    }
    return rows;
  }
};

TEST_F(Health, AFilterThatSeesTracksAllTheTime) {
  EXPECT_EQ(replay("").exit_code, 0);
  EXPECT_EQ(score()["metrics"]["tracked_fraction"]["value"], 1);
  EXPECT_TRUE(score()["tracking"]["lost"].empty() && score()["tracking"]["suspect"].empty());
  EXPECT_THAT(health_rows(), testing::Each(testing::StartsWith("ok,,")));
}

TEST_F(Health, AFilterThatNeverSeesAnythingNewDivergesAndEveryFileSaysSo) {
  for (const auto& [change, cause] :
       {std::pair<std::string, std::string>{"'errors.faults=[{frames_lost: {duration_s: 100}}]'",
                                            "no image arrives"},
        {"errors.image.gain=0", "the image is flat"},
        {"'errors.faults=[{frames_frozen: {from_s: 0.4, duration_s: 100}}]'",
         "the image is the last one again"}}) {
    const Ran ran = replay(change);
    const std::string whole = "tracking lost: " + cause + "; the map was not found again";
    EXPECT_EQ(ran.exit_code, 3) << change << ran.out << ran.err;
    EXPECT_THAT(ran.out, HasSubstr("diverged"));
    EXPECT_THAT(ran.out, HasSubstr("to the end: " + whole));
    const nlohmann::json scored = score();
    EXPECT_EQ(scored["ending"], "diverged");
    ASSERT_EQ(scored["tracking"]["lost"].size(), 1U);
    EXPECT_EQ(scored["tracking"]["lost"][0]["cause"], whole);
    EXPECT_TRUE(scored["tracking"]["lost"][0]["to_s"].is_null());
    EXPECT_LT(scored["metrics"]["tracked_fraction"]["value"], 0.5);
    const auto rows = health_rows();
    ASSERT_FALSE(rows.empty());
    EXPECT_THAT(rows.back(), HasSubstr("diverged," + whole + ","));
    const std::string lost = "lost,tracking lost: " + cause + ",";
    EXPECT_TRUE(std::any_of(rows.begin(), rows.end(), [&](const std::string& row) {
      return row.starts_with(lost);
    })) << cause;
  }
}

TEST_F(Health, AFilterThatSeesAgainTracksAgainAndALimitOnTheShareOfTimeIsMissed) {
  const Ran ran = replay("'errors.faults=[{frames_lost: {from_s: 0.5, duration_s: 0.6}}]'");
  EXPECT_EQ(ran.exit_code, 1) << ran.out << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("lost from "));
  EXPECT_THAT(ran.out, HasSubstr(">= 0.9900  MISSED"));
  EXPECT_EQ(score()["ending"], "completed");
  ASSERT_EQ(score()["tracking"]["lost"].size(), 1U);
  const auto loss = score()["tracking"]["lost"][0];
  EXPECT_NEAR(loss["from_s"], 0.9, 0.04);  // 0.4 s after the last image, within a frame
  EXPECT_NEAR(loss["to_s"], 1.1, 0.04);
  EXPECT_THAT(health_rows().back(), testing::StartsWith("ok,,"));
}

}  // namespace
