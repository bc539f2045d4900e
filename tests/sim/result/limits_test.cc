#include "sim/result/limits.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace sim::result {
namespace {

const scenario::MetricLimit kError{"rmse_m", "", scenario::Bound::at_most, 0.1},
    kLandmarks{"loop_landmarks", "", scenario::Bound::at_least, 3},
    kMedian{"rmse_m", "median", scenario::Bound::at_most, 0.1};

scenario::Scenario scenario_with(std::vector<scenario::MetricLimit> limits, bool filter = true) {
  scenario::Scenario scenario;
  if (filter) scenario.slam.emplace();
  scenario.limits.metrics = std::move(limits);
  scenario.limits.ending = {"completed", "diverged"};
  return scenario;
}

int code(const scenario::Scenario& scenario, std::optional<double> value,
         scenario::Ending ending = scenario::Ending::completed) {
  return exit_code(scenario, ending, judge_run(scenario, [&](const std::string&) { return value; }));
}

TEST(Limits, AMissedLimitIsExitCodeOneAndAForbiddenEndingThree) {
  EXPECT_EQ(code(scenario_with({kError}), 0.1), 0);
  EXPECT_EQ(code(scenario_with({kError}), 0.2), 1);
  EXPECT_EQ(code(scenario_with({kLandmarks}), 3), 0);
  EXPECT_EQ(code(scenario_with({kLandmarks}), 2), 1);
  EXPECT_EQ(code(scenario_with({kError}), 0.2, scenario::Ending::diverged), 1);
  EXPECT_EQ(code(scenario_with({kError}), 0.1, scenario::Ending::fell), 3);
}

TEST(Limits, OfARunAreThoseWithoutAnAggregate) { EXPECT_EQ(code(scenario_with({kMedian}), 0.2), 0); }

TEST(Limits, AnAbsentValueMissesItsLimitUnlessNoFilterWasToRun) {
  EXPECT_EQ(code(scenario_with({kError}), {}), 1);
  EXPECT_EQ(code(scenario_with({kError}, false), {}), 0);
  EXPECT_EQ(code(scenario_with({kError}, false), 0.2), 1);  // a value of the walk itself is judged
}

TEST(Limits, AreWrittenWithTheirValues) {
  const auto json = to_json(judge(scenario_with({}), kMedian, 0.2));
  EXPECT_EQ(json.dump(), R"({"metric":"rmse_m.median","at_most":0.1,"value":0.2,"passed":false})");
  EXPECT_TRUE(to_json(judge(scenario_with({}, false), kMedian, {})).at("passed").is_null());
}

}  // namespace
}  // namespace sim::result
