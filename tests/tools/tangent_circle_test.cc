// The paper's first experiment as a user runs it: five seeds walked, seen, tracked and scored.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tests/sim/result/result_folder.h"

namespace {

namespace fs = std::filesystem;
using testing::IsEmpty;

constexpr int kSeeds = 5;

class TangentCircle : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    exit_code_ = gaitslam("run " + std::string(GAITSLAM_SOURCE_DIR) +
                          "/scenarios/tangent_circle.yaml --seeds 1..5 --jobs 2 --out two_jobs");
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  static int gaitslam(const std::string& arguments) {
    const int status = std::system(
        ("cd '" + folder_.string() + "' && '" GAITSLAM_PROGRAM "' " + arguments + " > out.txt").c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  }
  static std::string seed(int n) { return "seed-" + std::to_string(n); }

  // Medians over the seeds of two metrics of the runs replayed with something set otherwise.
  static std::map<std::string, double> medians(const std::string& changes) {
    std::map<std::string, std::vector<double>> values;
    for (int n = 1; n <= kSeeds; ++n) {
      const std::string out = "replayed " + seed(n);
      gaitslam("replay two_jobs/" + seed(n) + " " + changes + " --force --out '" + out + "'");
      for (const char* name : {"ate_se3_rmse_m", "rmse_m"}) {
        const double value = tests::metric(folder_ / out, name);
        values[name].push_back(std::isnan(value) ? 1e9 : value);  // diverged: worse than any number
      }
    }
    std::map<std::string, double> medians;
    for (auto& [name, of_seeds] : values) {
      std::sort(of_seeds.begin(), of_seeds.end());
      medians[name] = of_seeds[kSeeds / 2];
    }
    return medians;
  }

  static inline const fs::path folder_ =
      fs::temp_directory_path() / ("gaitslam tangent circle " + std::to_string(getpid()));
  static inline int exit_code_ = -1;
};

TEST_F(TangentCircle, IsWalkedWithoutAFallAndWithinItsLimitsByAllSeeds) {
  EXPECT_EQ(exit_code_, 0);
  for (int n = 1; n <= kSeeds; ++n)
    EXPECT_EQ(tests::json_of(folder_ / "two_jobs" / seed(n) / "score.json")["ending"], "completed");
  EXPECT_EQ(tests::json_of(folder_ / "two_jobs/summary.json")["metrics"]["ate_se3_rmse_m"]["n"], kSeeds);
}

TEST_F(TangentCircle, GivesTheSameBytesWithOneJobAsWithTwo) {
  ASSERT_EQ(gaitslam("run " + std::string(GAITSLAM_SOURCE_DIR) +
                     "/scenarios/tangent_circle.yaml --seeds 1,2 --jobs 1 --out one_job"),
            0);
  for (int n : {1, 2})
    EXPECT_THAT(tests::differences(tests::files(folder_ / "one_job" / seed(n)),
                                   tests::files(folder_ / "two_jobs" / seed(n))),
                IsEmpty());
}

TEST_F(TangentCircle, IsReplayedBitForBit) {
  ASSERT_EQ(gaitslam("replay two_jobs/seed-1 --out same"), 0);
  EXPECT_THAT(tests::differences(tests::files(folder_ / "same"),
                                 tests::files(folder_ / "two_jobs/seed-1", "recording/")),
              IsEmpty());
}

TEST_F(TangentCircle, IsTrackedWorseWithoutVisionAndWithoutThePlan) {
  const auto with_all = medians("");
  for (const char* changes :
       {"slam.vision.enabled=false", "slam.plan_velocity.enabled=false slam.height.enabled=false"})
    for (const auto& [name, without] : medians(changes))
      EXPECT_GT(without, with_all.at(name)) << name << " with " << changes;
}

TEST_F(TangentCircle, APlanThatIsAFifthTooLongOrTooShortIsSuspectOnEverySeed) {
  for (const auto& [factor, said] : {std::pair{"1.2", "too long"}, {"0.8", "too short"}})
    for (int n = 1; n <= kSeeds; ++n) {
      const std::string fault = std::string("'errors.faults=[{plan_scaled: {duration_s: 100, factor: ") + factor + "}}]'";
      EXPECT_EQ(gaitslam("replay two_jobs/" + seed(n) + " " + fault + " --force --out wrong"), 1);
      const auto suspect = tests::json_of(folder_ / "wrong/score.json")["tracking"]["suspect"];
      ASSERT_FALSE(suspect.empty()) << factor << ' ' << n;
      EXPECT_NE(suspect.back()["cause"].get<std::string>().find(said), std::string::npos) << suspect;
      EXPECT_TRUE(suspect.back()["to_s"].is_null());
      EXPECT_GT(tests::metric(folder_ / "wrong", "suspect_share"), 0.3);
    }
}

}  // namespace
