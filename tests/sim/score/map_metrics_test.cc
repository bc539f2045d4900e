#include "tests/sim/score/score_fixtures.h"

namespace sim::score {
namespace {

/// 10 s of standing still in 101 frames, localized after 2 s.
class MapMetrics : public RunTest {
 protected:
  MapMetrics() {
    run.estimate.emplace();
    for (int i = 0; i <= 100; ++i) {
      const Stamp t = std::chrono::milliseconds(100 * i);
      for (Trajectory* all : {&run.truth_camera, &run.truth_waist, &run.plan_waist})
        all->push_back({t, looking(0)});
      run.health.push_back({t, i >= 20, false});
      if (i >= 20) run.estimate->push_back({{t, looking(0)}, Matrix6d::Identity()});
    }
    run.loaded_map = {false, 50, 40};
  }
};

TEST_F(MapMetrics, ACorrectFirstPoseScoresByItsTime) {
  EXPECT_DOUBLE_EQ(value("time_to_localize_s"), 2);
  EXPECT_EQ(value("first_pose_correct"), 1);
  EXPECT_DOUBLE_EQ(value("reloc_score"), std::exp(-2.0 / 60));
  EXPECT_EQ(value("false_localizations"), 0);
  EXPECT_DOUBLE_EQ(value("correct_fraction"), 81.0 / 101);
  EXPECT_EQ(value("wrong_fraction"), 0);
  EXPECT_EQ(value("rmse_in_map_m"), 0);
  EXPECT_DOUBLE_EQ(value("map_reused_fraction"), 0.8);
  EXPECT_EQ(value("refused_wrong_map"), 0);
  EXPECT_EQ(reason("memory_bytes"), "no map was saved");
}

TEST_F(MapMetrics, WrongPosesCountOnceForEachLocalization) {
  for (std::size_t i = 0; i < 10; ++i) (*run.estimate)[i].X.translation().x() += 0.11;
  for (std::size_t i = 40; i < 45; ++i) (*run.estimate)[i].X.linear() = looking(0.06).linear();
  run.health[59].tracks = false;  // tracking resumes at frame 60, with the 41st estimate
  EXPECT_EQ(value("first_pose_correct"), 0);
  EXPECT_EQ(value("reloc_score"), 0);
  EXPECT_EQ(value("false_localizations"), 2);
  EXPECT_DOUBLE_EQ(value("wrong_fraction"), 15.0 / 101);
  EXPECT_DOUBLE_EQ(value("correct_fraction"), 66.0 / 101);
  EXPECT_NEAR(value("rmse_in_map_m"), 0.11 * std::sqrt(10.0 / 81), 1e-12);
}

TEST_F(MapMetrics, ARefusedMapWasNotLocalizedInAndWithoutOneThereIsNothingToScore) {
  run.loaded_map->refused = true;
  EXPECT_EQ(value("refused_wrong_map"), 1);
  EXPECT_EQ(value("reloc_score"), 0);
  EXPECT_EQ(reason("time_to_localize_s"), "the estimator did not localize in the map");
  run.loaded_map.reset();
  EXPECT_EQ(reason("reloc_score"), "no map of an earlier session was loaded");
}

}  // namespace
}  // namespace sim::score
