#include "sim/pages/leaderboard.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "sim/files/text.h"
#include "tests/sim/files/temporary_folder.h"

namespace {

using namespace sim::pages;
using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class LeaderboardTest : public testing::Test {
 protected:
  void add(const std::string& folder, const std::string& estimator, const json& values, int seed = 1,
           const std::string& alignment = "", const std::string& ending = "completed") {
    json metrics;
    for (const auto& [name, value] : values.items()) metrics[name] = {{"value", value}, {"unit", "m"}};
    write(folder + "/score.json", json{{"scenario", "walk"},
                                       {"estimator", estimator},
                                       {"seed", seed},
                                       {"ending", ending},
                                       {"metrics", metrics},
                                       {"limits", json::array()}}
                                      .dump());
    write(folder + "/about.json", json{{"alignment", alignment}}.dump());
  }
  void write(const std::string& name, const std::string& text) {
    const auto file = folder_.path() / name;
    std::filesystem::create_directories(file.parent_path());
    sim::files::write_text(file, text);
  }
  Leaderboard board() const { return leaderboard({folder_.path()}, {"rmse_m"}); }
  std::vector<std::string> order() const {
    std::vector<std::string> names;
    for (const LeaderboardRow& row : board().rows) names.push_back(row.estimator);
    return names;
  }
  const sim::files::TemporaryFolder folder_;
};

TEST_F(LeaderboardTest, CoverageComesBeforeTheError) {
  add("a/seed-1", "late", {{"rmse_m", 0.001}, {"poses_matched", 26}, {"true_poses", 86}});
  add("b/seed-1", "whole", {{"rmse_m", 0.1}, {"poses_matched", 86}, {"true_poses", 86}});
  add("c/seed-1", "often_lost", {{"rmse_m", 0.001}, {"poses_matched", 86}, {"tracked_fraction", 0.5}});
  add("d/seed-1", "fell", {{"rmse_m", 0.0001}, {"poses_matched", 8}, {"true_poses", 8}}, 1, "", "fell");
  EXPECT_THAT(order(), ElementsAre("whole", "often_lost", "late", "fell"));
}

TEST_F(LeaderboardTest, AlignedAndUnalignedErrorsHaveColumnsOfTheirOwn) {
  add("a/seed-1", "aligned", {{"rmse_m", 0.25}, {"poses_matched", 9}}, 1, "sim3");
  add("a/seed-2", "aligned", {{"rmse_m", 0.5}, {"poses_matched", 9}}, 2);
  const std::string csv = leaderboard_csv(board());
  EXPECT_THAT(csv, HasSubstr(",coverage,runs,completed,rmse_m,rmse_m_after_sim3,cpu_ms_mean,"));
  EXPECT_THAT(csv, HasSubstr("walk,aligned,1,1,1,0.5,,,,,,2,"));
  EXPECT_THAT(csv, HasSubstr("walk,aligned,1,1,1,,0.25,,,,sim3,1,"));
}

TEST_F(LeaderboardTest, ARowIsOfAllSeedsWithMeanMedianAndP99OfCpu) {
  for (const int seed : {1, 2}) {
    const std::string result = "a/seed-" + std::to_string(seed);
    add(result, "filter", {{"rmse_m", 0.1 * seed}, {"poses_matched", 9}}, seed);
    write(result + "/timing.json",
          R"({"frame_cpu_ms_mean": 3, "frame_cpu_ms_median": 2, "frame_cpu_ms_p99": 7})");
  }
  EXPECT_THAT(leaderboard_csv(board()), HasSubstr(",cpu_ms_mean,cpu_ms_median,cpu_ms_p99,alignment,seeds,"));
  EXPECT_THAT(leaderboard_csv(board()), testing::ContainsRegex("walk,filter,1,2,2,0.15[0-9]*,3,2,7,,1 2,"));
}

TEST_F(LeaderboardTest, RowsThatLookAlikeDifferInSeedsAndKeys) {
  for (const auto& [folder, height] : {std::pair<std::string, std::string>{"a", "0.05"}, {"b", "0.06"}}) {
    for (const int seed : {1, 2}) {
      add(folder + "/seed-" + std::to_string(seed), "filter", {{"rmse_m", 0.1}}, seed);
      write(folder + "/seed-" + std::to_string(seed) + "/scenario.yaml",
            "walk: {commands: [{stand: {duration_s: 1}}], step_height_m: " + height + "}\n");
    }
  }
  add("c/seed-1", "filter", {{"rmse_m", 0.1}});  // without a scenario: it neither has keys nor differs
  EXPECT_THAT(leaderboard_csv(board()), HasSubstr(",seeds,changed,folder\n"));
  for (const std::string key : {"walk.step_height_m=0.05", "walk.step_height_m=0.06"}) {
    EXPECT_THAT(leaderboard_csv(board()), HasSubstr(",1 2," + key + ","));
    EXPECT_THAT(leaderboard_table(board()), HasSubstr(key));
  }
  std::filesystem::remove_all(folder_ / "b");
  EXPECT_THAT(leaderboard_table(board()), Not(HasSubstr("changed")));
}

TEST_F(LeaderboardTest, OneBrokenResultDoesNotEndIt) {
  add("a/seed-1", "good", {{"rmse_m", 0.1}});
  add("b/seed-1", "bad", {{"rmse_m", 0.1}});
  write("b/seed-1/timing.json", "{");
  write("c/seed-1/score.json", "{\"seed\": 1");
  EXPECT_THAT(order(), ElementsAre("good"));
  EXPECT_EQ(board().left_out.size(), 2u);
  EXPECT_THAT(leaderboard_page(board()), HasSubstr("Left out: "));
  std::filesystem::remove_all(folder_ / "a");
  EXPECT_THROW(board(), sim::files::FileError);
}

TEST_F(LeaderboardTest, NamesAreNeutral) {
  add("a/seed-1", "=cmd|'/c calc'!A1", {{"rmse_m", 0.1}});
  add("b/seed-1", "evil\nrow\x1b[2J\xe2\x80\xae", {{"rmse_m", 0.1}}, 1, "x,\ny");
  for (const std::string& text :
       {leaderboard_table(board()), leaderboard_csv(board()), leaderboard_page(board())}) {
    EXPECT_THAT(text.substr(0, text.find("<script>")), Not(HasSubstr("\x1b")));
    EXPECT_THAT(text, Not(HasSubstr("\xe2\x80\xae")));
  }
  EXPECT_THAT(leaderboard_csv(board()), HasSubstr("walk,'=cmd|"));
  EXPECT_THAT(leaderboard_csv(board()), HasSubstr("walk,evil?row?[2J?,"));
  EXPECT_THAT(leaderboard_table(board()), HasSubstr("evil?row?[2J?"));
}

}  // namespace
