// The paper's first experiment through the program. .ci/run shares its walks with the regression.
#include "tests/tools/command_line.h"

namespace tests {
namespace {

using Folders = std::vector<fs::path>;

// All tests of the process share one batch of seeds of scenarios/suites/ci.yaml.
class TangentCircle : public CommandLine {
 protected:
  TangentCircle() {
    if (const char* const shared = std::getenv("GAITSLAM_SHARED_CACHE"))
      ::setenv("GAITSLAM_CACHE", shared, 1);
    if (!fs::exists(walks_))
      ok("run '" GAITSLAM_SOURCE_DIR
         "/scenarios/tangent_circle.yaml' --seeds 1..3 --cached --jobs 2 --out '" +
         walks_.string() + "'");
  }
  static void TearDownTestSuite() { fs::remove_all(walks_); }

  /// Replays all seeds at once with changes and returns their folders. exit_codes: of all three
  /// replays.
  Folders replay_all(const std::string& changes, const std::string& exit_codes) const {
    Folders folders;
    std::string all;
    for (const std::string seed : {"1", "2", "3"}) {
      folders.push_back(folder_ / ("out-" + seed));
      all += "(" GAITSLAM_PROGRAM " replay '" + walks_.string() + "/seed-" + seed + "' " + changes +
             " --force --out out-" + seed + " >/dev/null; echo $? >code-" + seed + ") & ";
    }
    const Ran ran = shell(all + "wait; cat code-* | tr -d '\\n'");
    EXPECT_THAT(ran.out, MatchesRegex(exit_codes)) << ran.err;
    return folders;
  }
  /// The median over the seeds. A run that diverged counts as worse than any number.
  static double median(const Folders& seeds, const std::string& metric) {
    std::vector<double> values;
    for (const fs::path& seed : seeds) {
      const double value = tests::metric(seed, metric);
      values.push_back(std::isnan(value) ? 1e9 : value);
    }
    std::ranges::sort(values);
    return values.at(1);
  }

  static inline const fs::path walks_ =
      fs::temp_directory_path() / ("gaitslam tangent circle " + std::to_string(getpid()));
};

// The limits can only be met with images. The regression tests whether the walks meet them.
TEST_F(TangentCircle, IsTrackedWorseWithoutVisionOrWithoutThePlanAndMissesItsLimitsWithoutImages) {
  const Folders whole{walks_ / "seed-1", walks_ / "seed-2", walks_ / "seed-3"};
  const auto sum = [&](const std::string& name) {
    return metric(whole[0], name) + metric(whole[1], name) + metric(whole[2], name);
  };
  EXPECT_LT(sum("smoothed_ate_se3_rmse_m"), 0.95 * sum("ate_se3_rmse_m"));
  for (const char* changes :
       {"slam.vision.enabled=false", "slam.plan_velocity.enabled=false slam.height.enabled=false"}) {
    const Folders without = replay_all(changes, "[013]+");
    for (const char* metric : {"ate_se3_rmse_m", "rmse_m"})
      EXPECT_GT(median(without, metric), median(whole, metric)) << metric << " with " << changes;
  }
  EXPECT_GT(median(replay_all("estimator=odometry", "111"), "ate_se3_rmse_m"),
            median(whole, "ate_se3_rmse_m"));
}

TEST_F(TangentCircle, APlanAFifthTooLongOrTooShortIsSuspectOnEverySeed) {
  for (const auto& [factor, said] :
       {std::pair<std::string, std::string>{"1.2", "too long"}, {"0.8", "too short"}})
    for (const fs::path& wrong :
         replay_all("'errors.faults=[{plan_scaled: {duration_s: 100, factor: " + factor + "}}]'", "111")) {
      const auto suspect = json_of(wrong / "score.json")["tracking"]["suspect"];
      ASSERT_FALSE(suspect.empty()) << factor << wrong;
      EXPECT_THAT(suspect.back()["cause"].get<std::string>(), Has(said));
      EXPECT_TRUE(suspect.back()["to_s"].is_null());
      EXPECT_GT(metric(wrong, "fault_flag_fraction"), 0.3);
    }
}

}  // namespace
}  // namespace tests
