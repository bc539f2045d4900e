#include "walking/timeline.h"

#include <gmock/gmock.h>

#include <map>
#include <numeric>

#include "tests/walking/walks.h"

namespace walking {
namespace {

Timeline timeline_of(std::vector<Command> commands) {
  return {walk_of(std::move(commands)), {}, Eigen::Vector2d::Zero()};
}

TEST(Timeline, AlternatesDoubleAndSingleSupportOfTheGivenTimes) {
  const auto timeline = timeline_of({Stand{2}, TangentArc{}, Stand{3}});
  const auto& phases = timeline.phases();
  ASSERT_EQ(phases.size(), 2u + 2 * 9);
  EXPECT_EQ(phases.front().ticks, 400);
  for (std::size_t i = 1; i + 1 < phases.size(); i += 2) {
    EXPECT_EQ(phases[i].support, Support::both);
    EXPECT_EQ(phases[i].ticks, 4);
    EXPECT_EQ(phases[i + 1].support, (i / 2) % 2 == 0 ? Support::left : Support::right);
    EXPECT_EQ(phases[i + 1].ticks, 156);
  }
  EXPECT_EQ(phases.back().ticks, 600);
  EXPECT_EQ(timeline.ticks(), 400u + 9 * 160 + 600);
}

TEST(Timeline, EveryPhaseBeginsWhereTheOneBeforeEndedAndOnlyTheFootInTheAirMoves) {
  const auto timeline = timeline_of({Straight{1, -0.5}, Stand{1}, TangentArc{}, PerpendicularArc{0.75, -1}});
  const auto& phases = timeline.phases();
  for (std::size_t i = 0; i < phases.size(); ++i) {
    const Phase &phase = phases[i], &before = phases[i == 0 ? 0 : i - 1];
    for (const Side side : {Side::left, Side::right}) {
      const bool in_the_air = phase.support == (side == Side::left ? Support::right : Support::left);
      EXPECT_EQ(phase.from.of(side).position != phase.to.of(side).position, in_the_air);
      if (i == 0) continue;
      EXPECT_EQ(phase.from.of(side).position, before.to.of(side).position);
      EXPECT_EQ(phase.from.of(side).yaw, before.to.of(side).yaw);
    }
    if (i == 0) continue;
    EXPECT_EQ(phase.waist_yaw_from, before.waist_yaw_to);
    EXPECT_EQ(phase.zmp_from, before.zmp_to);
  }
}

TEST(Timeline, ShortStandingAtBothEndsIsLengthenedToWhatThePlanNeeds) {
  const auto without = timeline_of({Straight{0.15, 0}});
  const auto with = timeline_of({Stand{0.1}, Straight{0.15, 0}, Stand{0.1}});
  EXPECT_EQ(without.ticks(), with.ticks());
  EXPECT_EQ(with.phases().front().ticks, 330);  // the preview and the smoothing window
  EXPECT_EQ(with.phases().back().ticks, 400);
  EXPECT_EQ(timeline_of({Stand{5}, Straight{0.15, 0}, Stand{5}}).ticks(), 1000u + 320 + 1000);
}

TEST(Timeline, AMomentBeforeOrAfterTheWalkIsItsFirstOrLast) {
  const auto timeline = timeline_of({Stand{2}, Straight{0.15, 0}, Stand{2}});
  EXPECT_EQ(timeline.at(-5).tick, 0);
  EXPECT_EQ(&timeline.at(-5).phase, &timeline.phases().front());
  EXPECT_EQ(timeline.at(1000000).tick, 399);
  EXPECT_EQ(&timeline.at(1000000).phase, &timeline.phases().back());
  EXPECT_EQ(timeline.at(400).tick, 0);
  EXPECT_EQ(&timeline.at(400).phase, &timeline.phases()[1]);
}

TEST(Timeline, RepeatCarriesTheLastCommandsOutAgainAndKnowsTheLaps) {
  const auto repeated = timeline_of({Stand{2}, Straight{0.3, 0}, Turn{}, Stand{1}, Repeat{3, 1}, Stand{2}});
  const auto written = timeline_of(
      {Stand{2}, Straight{0.3, 0}, Turn{}, Stand{1}, Straight{0.3, 0}, Turn{}, Stand{1}, Stand{2}});
  EXPECT_EQ(repeated.ticks(), written.ticks());
  EXPECT_EQ(written.ticks(), 400u + 2 * (3 * 160 + 10 * 160 + 200) + 400);
  ASSERT_EQ(repeated.laps().size(), 2u);
  EXPECT_EQ(repeated.laps()[0].begin, 400u);
  EXPECT_EQ(repeated.laps()[0].end, repeated.laps()[1].begin);
  EXPECT_EQ(repeated.laps()[1].end - repeated.laps()[1].begin, repeated.laps()[0].end - 400);
  EXPECT_EQ(repeated.laps()[1].end, repeated.ticks() - 400);
  EXPECT_TRUE(written.laps().empty());
}

TEST(Timeline, ImpossibleOptionsAreRefusedByName) {
  const std::vector<std::pair<void (*)(WalkOptions&), const char*>> cases{
      {[](auto& o) { o.single_support_s = 0; }, "walk.single_support_s"},
      {[](auto& o) { o.step_height_m = NAN; }, "walk.step_height_m"},
      {[](auto& o) { o.preview_s = INFINITY; }, "walk.preview_s"},
      {[](auto& o) { o.commands.clear(); }, "walk.commands"},
      {[](auto& o) { o.commands[0] = Stand{-1}; }, "walk.commands[0]"},
      {[](auto& o) {
         o.commands[1] = TangentArc{0, 1};
       },
       "walk.commands[1].tangent_arc"},
      {[](auto& o) { o.commands[1] = Turn{0}; }, "walk.commands[1].turn"},
      {[](auto& o) {
         o.commands[1] = GoTo{NAN, 0, 0};
       },
       "walk.commands[1].go_to"},
      {[](auto& o) {
         o.commands[1] = Repeat{2, 1};
       },
       "walk.commands[1].repeat.last: 2 commands"},
      {[](auto& o) {
         o.commands[1] = Repeat{1, 0};
       },
       "walk.commands[1].repeat.times"},
      {[](auto& o) {
         o.commands = {Stand{1}, Repeat{1, 1}, Repeat{1, 1}};
       },
       "one is a repeat itself"},
      {[](auto& o) { o.steering.gain = 2; }, "walk.steering.gain"}};
  for (const auto& [spoil, named] : cases) {
    WalkOptions options = walk_of({Stand{1}, TangentArc{}});
    spoil(options);
    EXPECT_THAT([&] { Timeline(options, {}, Eigen::Vector2d::Zero()); },
                testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr(named)));
  }
}

TEST(SmoothingWeights, AreTheReferenceOnes) {
  const auto w = smoothing_weights();
  const std::array<double, 11> expected{0,        .0190983, .0690983, .1309017, .1809017, .2,
                                        .1809017, .1309017, .0690983, .0190983, 0};
  for (int i = 0; i <= 10; ++i) EXPECT_NEAR(w[i], expected[i], 5e-8);  // seven decimals
  EXPECT_NEAR(std::accumulate(w.begin(), w.end(), 0.0), 1, 1e-15);
}

TEST(ZmpReference, GoesLinearlyToTheFootInDoubleSupportAndEndsInTheMiddleOfTheFeet) {
  const Timeline timeline = timeline_of({Stand{3}, Straight{0.15, 0}, Stand{3}});
  const int end = 600 + 320;
  // The left foot is the first to carry the robot; a double support has 4 ticks, the last one half of them.
  const std::map<int, Eigen::Vector2d> expected{
      {600, {0, 0}},        {602, {0, .0475}},   {604, {0, .095}},
      {759, {0, .095}},     {762, {.075, 0}},    {764, {.15, -.095}},
      {end, {.15, -.0475}}, {end + 1, {.15, 0}}, {end + 100000, {.15, 0}}};
  for (const auto& [tick, zmp] : expected)
    EXPECT_LT((zmp_reference(timeline, tick) - zmp).norm(), 1e-15) << tick;
}

TEST(ZmpReference, LiesUnderTheChosenPointOfTheFoot) {
  const Timeline timeline(walk_of({Stand{3}, Straight{0.15, 0}}), {{0, 0}, 90 * kDegree}, {0.004, 0});
  EXPECT_LT((zmp_reference(timeline, 0) - Eigen::Vector2d(0, 0.004)).norm(), 1e-15);
  EXPECT_LT((zmp_reference(timeline, 700) - Eigen::Vector2d(-0.095, 0.004)).norm(), 1e-15);
}

TEST(ZmpReference, SmoothingKeepsWhatIsConstantAndSpreadsAStepOverNineTicks) {
  const Timeline timeline = timeline_of({Stand{3}, Straight{0.15, 0}, Stand{3}});
  const auto smoothed = [&](int tick) { return smoothed_zmp(timeline, tick); };
  EXPECT_EQ(smoothed(500), zmp_reference(timeline, 500));
  for (int k = 599; k < 615; ++k) EXPECT_GE(smoothed(k + 1).y(), smoothed(k).y());
  EXPECT_EQ(smoothed(599).y(), 0);  // 601 is the first on its way; the window looks one tick ahead
  EXPECT_GT(smoothed(600).y(), 0);
  EXPECT_LT(smoothed(610).y(), 0.095);
  EXPECT_NEAR(smoothed(611).y(), 0.095, 1e-15);
}

}  // namespace
}  // namespace walking
