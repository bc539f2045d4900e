// Values to try and plans of sweeps, both right and wrong.
#include "sim/trials/sweep.h"

#include "sim/replay/replay.h"
#include "sim/trials/trial.h"
#include "sim/trials/values.h"
#include "tests/sim/files/temporary_folder.h"
#include "tests/sim/result/result_folder.h"
#include "tests/sim/trials/synthetic_result.h"

namespace sim::trials {
namespace {

using testing::ElementsAre, testing::EndsWith, testing::HasSubstr;

/// The values of slam.vision.sigma_px in YAML.
Values values(const std::string& text, const std::string& key = "slam.vision.sigma_px") {
  const scenario::Yaml map = scenario::parse_yaml(key + ": " + text, {"spec.yaml"});
  return read_values(map.keys[0], map.items[0]);
}

std::string error_of(const std::string& text, const std::string& key = "slam.vision.sigma_px") {
  return files::error_of([&] { values(text, key); });
}

std::vector<std::string> grid(const std::string& text) {
  std::vector<std::string> texts;
  for (const double value : std::get<Range>(values(text)).grid())
    texts.push_back(number_node(value, {}, true).text);
  return texts;
}

TEST(Values, MayBeAListASingleValueOrARange) {
  EXPECT_EQ(std::get<0>(values("0.50"))[0].text, "0.50");
  EXPECT_EQ(std::get<0>(values("[1, 2, 3]")).size(), 3u);
  const Range range =
      std::get<Range>(values("{from: 1, to: 4, start: 3, scale: linear, also: [slam.height.sigma_m]}"));
  EXPECT_FALSE(range.logarithmic);
  EXPECT_EQ(range.start, 3);
  EXPECT_THAT(range.also, ElementsAre("slam.height.sigma_m"));
  EXPECT_EQ(std::get<Range>(values("[{from: 1, to: 2}]")).high, 2);
}

TEST(Values, OnAGridHaveEqualDistancesOrFactors) {
  EXPECT_THAT(grid("{from: 1, to: 2, points: 5, scale: linear}"),
              ElementsAre("1", "1.25", "1.5", "1.75", "2"));
  EXPECT_THAT(grid("{from: 0.01, to: 10, points: 4}"), ElementsAre("0.01", "0.1", "1", "10"));
}

TEST(Values, ErrorsNameThePlace) {
  for (const auto& [text, error] : std::vector<std::pair<std::string, std::string>>{
           {"{from: 1, too: 2}", "spec.yaml:1:33: too: unknown key; did you mean 'to'?"},
           {"{from: 1}", "expected both from and to"},
           {"{from: 2, to: 1}", "expected an increasing range"},
           {"{from: 1, to: abc}", "spec.yaml:1:37: slam.vision.sigma_px: "},
           {"{from: -1, to: 1}", "spec.yaml:1:30: slam.vision.sigma_px: "},
           {"{from: 1, to: 2, points: 1}", "points: is '1', expected a whole number"},
           {"{from: 1, to: 2, start: 3}", "start 3 is outside 1 to 2"},
           {"{from: 1, to: 2, also: [slam.visio.sigma_px]}", "did you mean"},
           {"[]", "has no values"}})
    EXPECT_THAT(error_of(text), HasSubstr(error)) << text;
  EXPECT_THAT(error_of("{from: 0, to: 1}", "slam.depth.linearity"), HasSubstr("must start above 0"));
  EXPECT_THAT(error_of("{from: 1, to: 2}", "slam.gyro.enabled"),
              HasSubstr("expected a key whose value is a number"));
}

TEST(Sobol, FirstPointsMatchJoeAndKuo) {
  const auto points = sobol_points(7, 3);  // the worked example published with their direction numbers
  EXPECT_THAT(points, ElementsAre(ElementsAre(0.5, 0.5, 0.5), ElementsAre(0.75, 0.25, 0.25),
                                  ElementsAre(0.25, 0.75, 0.75), ElementsAre(0.375, 0.375, 0.625),
                                  ElementsAre(0.875, 0.875, 0.125), ElementsAre(0.625, 0.125, 0.875),
                                  ElementsAre(0.125, 0.625, 0.375)));
}

class Sweep : public testing::Test {
 protected:
  Sweep() {
    write("walk.yaml", "walk: {commands: [{stand: {duration_s: 1}}]}\ncamera: {}\nslam: {}\n");
    write("blind.yaml", "walk: {commands: [{stand: {duration_s: 1}}]}\n");
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }

  SweepPlan plan(const std::string& file, const std::vector<std::string>& arguments,
                 std::optional<int> samples = {}, const std::vector<std::uint64_t>& seeds = {1, 2}) const {
    return plan_sweep(read_sweep(folder_ / file, arguments, samples), seeds, {});
  }
  std::string complaint(const std::string& file, const std::vector<std::string>& arguments,
                        std::size_t seeds = 2) const {
    const std::string folder = folder_.path().string() + "/",
                      text = files::error_of(
                          [&] { plan(file, arguments, {}, std::vector<std::uint64_t>(seeds)); });
    return text.starts_with(folder) ? text.substr(folder.size()) : text;
  }
  std::string complaint_of_file(const std::string& text, std::size_t seeds = 2) const {
    write("spec.yaml", text);
    return complaint("spec.yaml", {}, seeds);
  }

  static std::vector<std::vector<std::string>> values(const SweepPlan& plan) {
    std::vector<std::vector<std::string>> all;
    for (const Configuration& configuration : plan.configurations) all.push_back(configuration.values);
    return all;
  }

  files::TemporaryFolder folder_;
};

TEST_F(Sweep, TriesEveryCombinationWithTheLastKeyVaryingFastest) {
  const SweepPlan grid = plan("walk.yaml", {"slam.vision.sigma_px=1,2",
                                            "slam.gyro.sigma_rad_s={from: 0.01, to: 0.03, points: 3, "
                                            "scale: linear, also: [slam.height.sigma_m]}"});
  EXPECT_THAT(grid.keys, ElementsAre("slam.vision.sigma_px", "slam.gyro.sigma_rad_s", "slam.height.sigma_m"));
  EXPECT_THAT(values(grid), ElementsAre(ElementsAre("1", "0.01", "0.01"), ElementsAre("1", "0.02", "0.02"),
                                        ElementsAre("1", "0.03", "0.03"), ElementsAre("2", "0.01", "0.01"),
                                        ElementsAre("2", "0.02", "0.02"), ElementsAre("2", "0.03", "0.03")));
  EXPECT_EQ(grid.trials(), 12u);
  EXPECT_EQ(grid.scenario(11).scenario.slam->vision.sigma_px, 2);
  EXPECT_EQ(grid.scenario(11).scenario.seed, 2u);
  EXPECT_EQ(plan("walk.yaml", {}).trials(), 2u) << "the scenario alone, on each seed";
}

TEST_F(Sweep, BracketsOnTheCommandLineAreAListOfValuesUnlessTheValueIsAList) {
  for (const char* text : {"1,1.5,2", "[1, 1.5, 2]", "[1,1.5,2]"})
    EXPECT_THAT(values(plan("walk.yaml", {std::string("slam.vision.sigma_px=") + text})),
                ElementsAre(ElementsAre("1"), ElementsAre("1.5"), ElementsAre("2")));
  EXPECT_THAT(values(plan("walk.yaml", {"estimator=[filter, odometry]"})),
              ElementsAre(ElementsAre("filter"), ElementsAre("odometry")));
  EXPECT_THAT(
      values(plan("walk.yaml", {"walk.commands=[{stand: {duration_s: 1}}, {stand: {duration_s: 2}}]"})),
      testing::SizeIs(1));
}

TEST_F(Sweep, EstimatorsAndControllersAreLabeledByTheirNamesIfTheyDiffer) {
  const auto labels = [&](const std::string& programs) {
    std::vector<std::string> all;
    for (const Configuration& one : plan("walk.yaml", {programs}).configurations)
      all.push_back(one.labels[0]);
    return all;
  };
  for (const std::string key : {"estimator=filter", "walk.controller=plan"})
    EXPECT_THAT(labels(key + ",{program: [./a, b]},{program: ./a, name: c}"),
                ElementsAre(key.substr(key.find('=') + 1), "a", "c"));
  EXPECT_THAT(labels("estimator={program: [./a, b]},{program: [./a, c]}")[0], HasSubstr("[\"./a\", b]"));
}

TEST_F(Sweep, RangesWithoutPointsAreSampledTogether) {
  const std::vector<std::string> keys{"slam.vision.sigma_px={from: 0.1, to: 10}",
                                      "errors.gyro.sigma_rad_s={from: 0, to: 1, scale: linear}"};
  EXPECT_THAT(values(plan("walk.yaml", keys, 3)),
              ElementsAre(ElementsAre("1", "0.5"), ElementsAre("3.16227766017", "0.25"),
                          ElementsAre("0.316227766017", "0.75")));
  EXPECT_EQ(plan("walk.yaml", keys).configurations.size(), 16u);
}

TEST_F(Sweep, AFileSaysTheSameAsTheCommandLine) {
  write("spec.yaml", R"yaml(
scenarios: [walk.yaml]
seeds: 1..5
parameters:
  slam.vision.sigma_px: {from: 1, to: 100, points: 3}
  slam.vision.sub_pixel: [true, false]
  walk.commands: [[{stand: {duration_s: 1}}], [{stand: {duration_s: 2}}]]
  slam.depth.inverse_1_m: {from: 0.1, to: 1}
samples: 4
)yaml");
  const SweepSpec spec = read_sweep(folder_ / "spec.yaml", {"world.seed=5,6"});
  EXPECT_THAT(spec.seeds, ElementsAre(1, 2, 3, 4, 5));
  const SweepPlan all = plan_sweep(spec, {1}, {});
  EXPECT_EQ(all.configurations.size(), 3u * 2 * 2 * 4 * 2);
  EXPECT_THAT(all.configurations.back().values,
              ElementsAre("100", "false", "[{stand: {duration_s: 2}}]", "6", testing::_));
  EXPECT_THAT(
      values(plan("walk.yaml", {"walk.commands=[{stand: {duration_s: 1}}],[{stand: {duration_s: 2}}]"})),
      ElementsAre(ElementsAre("[{stand: {duration_s: 1}}]"), ElementsAre("[{stand: {duration_s: 2}}]")));
}

TEST_F(Sweep, AValueChangesTheDefaultsThatFollowFromIt) {
  const SweepPlan all = plan("walk.yaml", {"world.robot=hrp2,g1", "walk.single_support_s=0.5,0.9"});
  ASSERT_EQ(all.configurations.size(), 4u);
  for (const Configuration& one : all.configurations) {
    const scenario::Scenario& scenario = one.read.scenario;
    EXPECT_EQ(scenario.walk.com_height_m, scenario.world.robot == "g1" ? 0 : 0.814);
    EXPECT_NEAR(scenario.slam->plan_velocity.sway_period_s,
                2 * (scenario.walk.single_support_s + scenario.walk.double_support_s), 1e-12);
  }
}

TEST_F(Sweep, TheStudysSweepWalksTwoRobotsPerEstimator) {
  const SweepSpec spec = read_sweep(GAITSLAM_SOURCE_DIR "/scenarios/studies/step_length.yaml", {});
  const SweepPlan study = plan_sweep(spec, spec.seeds, {});
  EXPECT_EQ(study.trials(), 2u * 3 * 2 * 3 * 10);
  EXPECT_THAT(study.configurations.back().labels, ElementsAre("g1", "0.18", "0.7", "visual_odometry"));
  for (const Configuration& one : study.configurations) EXPECT_TRUE(one.read.scenario.slam);
}

TEST_F(Sweep, ErrorsOnTheCommandLineAreReportedWithTheirPlace) {
  EXPECT_EQ(complaint("walk.yaml", {"slam.vision.sigma=1,2"}),
            "<argument>:1:1: slam.vision.sigma: unknown key; did you mean 'slam.vision.sigma_px'?");
  for (const auto& [arguments, text] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"world.seed=1", "slam.vision.sigma_px=1,x"},
            "<argument>:2:24: slam.vision.sigma_px: is 'x', expected a number"},
           {{"slam.vision.sigma_px"}, "expected KEY=VALUE,VALUE; quote values with spaces"},
           {{"slam.vision.sigma_px=1", "slam.vision.sigma_px=2"},
            "<argument>:2:1: slam.vision.sigma_px: has values twice"},
           {{"limits.rmse_m=1"}, "does not affect runs"}})
    EXPECT_THAT(complaint("walk.yaml", arguments), HasSubstr(text));
  EXPECT_THAT(complaint("blind.yaml", {"slam.vision.sigma_px=1"}), HasSubstr("blind has no such section"));
  EXPECT_THAT(complaint("none.yaml", {}), HasSubstr("cannot be read"));
}

TEST_F(Sweep, ErrorsInAFileAreReportedWithTheirPlace) {
  for (const auto& [text, what] : std::vector<std::pair<std::string, std::string>>{
           {"scenario: walk.yaml\nsede: 1\n", "spec.yaml:2:1: sede: unknown key; did you mean 'seeds'?"},
           {"scenario: walk.yaml\nparameters:\n  slam.vision.sigma_px: [1, -2]\n",
            "spec.yaml:3:29: slam.vision.sigma_px: is '-2', expected a number"},
           {"scenario: walk.yaml\nsamples: 1000000\n",
            "spec.yaml:2:10: samples: is '1000000', expected a whole number from 1 to 100000"},
           {"scenario: walk.yaml\nsamples: 4\n", "samples: no parameter is a range without points"},
           {"scenarios: [walk.yaml, walk.yaml]\n", "a sweep needs different names"}})
    EXPECT_THAT(complaint_of_file(text), HasSubstr(what)) << text;
}

TEST_F(Sweep, TooManyTrialsAreRejectedAtTheKeyThatRequestsThem) {
  const std::string thousand = "{from: 1, to: 1000, points: 1000, scale: linear}";
  EXPECT_EQ(complaint_of_file("scenario: walk.yaml\nparameters:\n  world.seed: " + thousand +
                              "\n  slam.vision.sigma_px: {from: 1, to: 2, points: 101}\n"),
            "spec.yaml:4:3: slam.vision.sigma_px: makes 202000 trials of 101000 combinations, 1 scenarios "
            "and 2 seeds, "
            "expected at most 100000");
  EXPECT_THAT(complaint_of_file(
                  "scenarios: [walk.yaml, blind.yaml]\nparameters: {world.seed: " + thousand + "}\n", 51),
              EndsWith("world.seed: makes 102000 trials of 1000 combinations, 2 scenarios and 51 seeds, "
                       "expected at most 100000"));
}

// The position's x is correlated with the rotation about x.
TEST(PoseNll, FollowsFromTheDensityOfTheErrorIncludingCorrelations) {
  score::Matrix6d P = score::Matrix6d::Identity() * 1e-4;
  P(0, 3) = P(3, 0) = 0.6e-4;  // |P| = 1e-24 (1 − 0.36)
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  truth.translation().x() = 0.03;                                               // 3 σ
  truth.linear() = Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitY()).matrix();  // 2 σ
  const double expected = (9 / 0.64 + 4 + std::log(0.64e-24) + 6 * std::log(2 * std::numbers::pi)) / 2;
  EXPECT_NEAR(pose_nll(truth, Eigen::Isometry3d::Identity(), P).value(), expected, 1e-9);
}

TEST(PoseNll, HasNoValueWhereACovarianceIsNotPositiveDefinite) {
  score::Matrix6d P = score::Matrix6d::Identity();
  P(2, 2) = -1;
  EXPECT_FALSE(pose_nll(Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity(), P));
}

/// The innovations of a Kalman filter for a random walk that assumes some standard deviation of its
/// measurements. The standard deviation of the steps is 0.1 and known; the measurements' is 0.2.
tracking::Tracked random_walk(double assumed_sigma) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  tracking::Tracked tracked;
  double x = 0, estimate = 0, P = 0;
  for (int k = 0; k < 2000; ++k) {
    x += 0.1 * normal(random);
    P += 0.01;
    const double nu = x + 0.2 * normal(random) - estimate, S = P + assumed_sigma * assumed_sigma;
    tracked.frames.emplace_back().report.innovations = {{"height", {nu * nu / S, 1, std::log(S)}}};
    estimate += P / S * nu;
    P -= P * P / S;
  }
  return tracked;
}

TEST(InnovationNll, IsLeastForTheTrueNoise) {
  const double true_noise = innovation_nll(random_walk(0.2), 1).value();
  for (const double wrong : {0.1, 0.14, 0.28, 0.4})
    EXPECT_GT(innovation_nll(random_walk(wrong), 1).value(), true_noise + 0.01) << wrong;
}

/// A frame with `used` matches among the landmarks searched for, each with a NIS of 2 and S = 0.01 px² I.
tracking::TrackedFrame searched(std::size_t used, std::size_t landmarks) {
  tracking::TrackedFrame frame;
  frame.report.searched.resize(landmarks);
  const int count = int(used);
  if (used > 0) frame.report.innovations = {{"vision", {2.0 * count, 2 * count, count * std::log(1e-4)}}};
  return frame;
}

TEST(InnovationNll, DependsOnTheFractionOfLandmarksFoundNotOnTheirNumber) {
  const double found = 2 + std::log(1e-4) + 2 * std::log(2 * std::numbers::pi), missed = 2 * std::log(76800);
  const std::vector<std::pair<std::vector<tracking::TrackedFrame>, double>> cases{
      {{searched(4, 4)}, found / 4},
      {{searched(6, 6), searched(12, 12)}, found / 4},
      {{searched(9, 12)}, (3 * found + missed) / 16},
      {{searched(6, 8), searched(0, 0), searched(3, 4)}, (3 * found + missed) / 16},
      {{searched(0, 8)}, missed / 4}};
  for (const auto& [frames, expected] : cases) {
    tracking::Tracked tracked;
    tracked.frames = frames;
    EXPECT_NEAR(innovation_nll(tracked, 76800).value(), expected, 1e-12);
  }
}

TEST(InnovationNll, IsTheSumOfTheSensorsMeans) {
  tracking::Tracked both = random_walk(0.2);
  for (tracking::TrackedFrame& frame : both.frames)
    frame.report.innovations.push_back({"gyro", {3, 3, -3 * std::log(2 * std::numbers::pi)}});
  EXPECT_NEAR(innovation_nll(both, 1).value(), innovation_nll(random_walk(0.2), 1).value() + 0.5, 1e-12);
}

TEST(InnovationNll, HasNoValueWithoutInnovationsOrWhereACovarianceIsNotPositiveDefinite) {
  EXPECT_FALSE(innovation_nll({}, 1));
  tracking::Tracked tracked = random_walk(0.2);
  tracked.frames.back().report.innovations.front().nis.value = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(innovation_nll(tracked, 1));
}

TEST(Trial, WithSessionsHasTheMetricsOfItsReplay) {
  const files::TemporaryFolder folder;
  const fs::path result = folder / "seed-1";
  for (const fs::path& walked : {result, result / "session-1"})
    tests::write_result(walked, tests::short_walk(40));
  const auto read = scenario::read_scenario(
      result / "scenario.yaml", {{"slam.map.start=unknown", "sessions=[{session: {set: []}}]"}, {}});
  sim::replay::replay(read, result / "recording", sim::replay::read_walk_end(result),
                      {folder / "replay", "", "1", "test", {}}, [](double) {});
  std::vector<std::string> asked;
  const JobRecord trial =
      run_task({"key", 1, scenario::to_yaml(read.scenario)}, [&](const auto&, const std::string& session) {
        asked.push_back(session);
        return std::make_shared<const Recording>(load(result / session));
      });
  EXPECT_THAT(asked, testing::ElementsAre("session-1", ""));
  for (const char* const name : {"map_reused_fraction", "time_to_localize_s", "rmse_m"})
    EXPECT_EQ(trial.value(name), tests::metric(folder / "replay", name)) << name;
  EXPECT_TRUE(fs::exists(folder / "replay" / "session-1" / "map.bin"));
}

// No landmark is ever found again if a correlation of 1 is required.
TEST(Trial, AFailingFilterHasNoLikelihoodButReportsHowLongItLasted) {
  const files::TemporaryFolder folder;
  tests::write_result(folder.path(), tests::short_walk(40));
  const auto failing = scenario::read_scenario(
      folder / "scenario.yaml",
      {{"slam.vision.minimum_correlation=1", "slam.tracking.lost_after_s=0.3", "slam.tracking.give_up_s=0.3"},
       {}});
  const JobRecord trial = run_trial(load(folder.path()), failing);
  EXPECT_EQ(trial.ending, "diverged");
  EXPECT_FALSE(trial.value("pose_nll"));
  EXPECT_FALSE(trial.value("innovation_nll"));
  EXPECT_GT(trial.value("lasted_fraction"), 0);
  EXPECT_LT(trial.value("lasted_fraction"), 1);
}

}  // namespace
}  // namespace sim::trials
