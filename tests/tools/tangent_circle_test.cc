// The paper's first experiment through the program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "tests/sim/result/result_folder.h"

namespace {

namespace fs = std::filesystem;
using testing::Each;

constexpr int kSeeds = 3;  // those of scenarios/suites/ci.yaml

class TangentCircle : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    exit_code_ = gaitslam("run " + std::string(GAITSLAM_SOURCE_DIR) +
                          "/scenarios/tangent_circle.yaml --seeds 1..3 --jobs 2 --out two_jobs");
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  static int gaitslam(const std::string& arguments) {
    const int status = std::system(
        ("cd '" + folder_.string() + "' && '" GAITSLAM_PROGRAM "' " + arguments + " > /dev/null").c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  }
  static std::string seed(int n) { return "seed-" + std::to_string(n); }

  // Replays all seeds, two at a time, into folders named `out` + seed; returns the exit codes.
  static std::vector<int> replay_all(const std::string& changes, const std::string& out) {
    std::vector<int> exit_codes(kSeeds);
    std::atomic<int> next = 1;
    const auto work = [&] {
      for (int n = next++; n <= kSeeds; n = next++)
        exit_codes[static_cast<size_t>(n - 1)] =
            gaitslam("replay two_jobs/" + seed(n) + " " + changes + " --force --out '" + out + seed(n) + "'");
    };
    std::thread other(work);
    work();
    other.join();
    return exit_codes;
  }

  // Medians over the seeds of two metrics, replayed with changes.
  static std::map<std::string, double> medians(const std::string& changes) {
    std::map<std::string, std::vector<double>> values;
    replay_all(changes, "replayed ");
    for (int n = 1; n <= kSeeds; ++n) {
      const std::string out = "replayed " + seed(n);
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

TEST_F(TangentCircle, IsTrackedWorseWithoutVisionAndWithoutThePlan) {
  const auto with_all = medians("");
  for (const char* changes :
       {"slam.vision.enabled=false", "slam.plan_velocity.enabled=false slam.height.enabled=false"})
    for (const auto& [name, without] : medians(changes))
      EXPECT_GT(without, with_all.at(name)) << name << " with " << changes;
}

// The limits ask for what only images give.
TEST_F(TangentCircle, WithoutImagesMissesItsLimitsOnEverySeed) {
  EXPECT_THAT(replay_all("estimator=odometry", "blind "), Each(1));
  for (int n = 1; n <= kSeeds; ++n)
    EXPECT_GT(tests::metric(folder_ / ("blind " + seed(n)), "ate_se3_rmse_m"), 0.004);
}

TEST_F(TangentCircle, APlanThatIsAFifthTooLongOrTooShortIsSuspectOnEverySeed) {
  for (const auto& [factor, said] : {std::pair{"1.2", "too long"}, {"0.8", "too short"}}) {
    const std::string fault =
        std::string("'errors.faults=[{plan_scaled: {duration_s: 100, factor: ") + factor + "}}]'";
    EXPECT_THAT(replay_all(fault, "wrong "), Each(1));
    for (int n = 1; n <= kSeeds; ++n) {
      const fs::path wrong = folder_ / ("wrong " + seed(n));
      const auto suspect = tests::json_of(wrong / "score.json")["tracking"]["suspect"];
      ASSERT_FALSE(suspect.empty()) << factor << ' ' << n;
      EXPECT_NE(suspect.back()["cause"].get<std::string>().find(said), std::string::npos) << suspect;
      EXPECT_TRUE(suspect.back()["to_s"].is_null());
      EXPECT_GT(tests::metric(wrong, "fault_flag_fraction"), 0.3);
    }
  }
}

}  // namespace
