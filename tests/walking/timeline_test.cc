#include "walking/timeline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numeric>
#include <stdexcept>
#include <string>

namespace walking {
namespace {

Timeline timeline_of(const WalkOptions& options) { return {options, {}, Eigen::Vector2d::Zero()}; }

WalkOptions walk(std::vector<Command> commands) {
  WalkOptions options;
  options.commands = std::move(commands);
  return options;
}

TEST(Timeline, AlternatesDoubleAndSingleSupportOfTheGivenTimes) {
  const auto timeline = timeline_of(walk({Stand{2}, TangentArc{}, Stand{3}}));
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

TEST(Timeline, EveryPhaseBeginsWhereTheOneBeforeEnded) {
  const auto timeline =
      timeline_of(walk({Straight{1, -0.5}, Stand{1}, TangentArc{}, PerpendicularArc{0.75, -1}}));
  const Phase* before = nullptr;
  for (const Phase& phase : timeline.phases()) {
    if (before != nullptr) {
      for (const Side side : {Side::left, Side::right}) {
        EXPECT_EQ(phase.from.of(side).position, before->to.of(side).position);
        EXPECT_EQ(phase.from.of(side).yaw, before->to.of(side).yaw);
      }
      EXPECT_EQ(phase.waist_yaw_from, before->waist_yaw_to);
      EXPECT_EQ(phase.zmp_from, before->zmp_to);
    }
    before = &phase;
  }
}

TEST(Timeline, OnlyTheFootInTheAirMoves) {
  const auto timeline = timeline_of(walk({Straight{1, -0.5}, TangentArc{}}));
  for (const Phase& phase : timeline.phases()) {
    const bool left_stays = phase.from.left.position == phase.to.left.position;
    const bool right_stays = phase.from.right.position == phase.to.right.position;
    EXPECT_EQ(left_stays, phase.support != Support::right);
    EXPECT_EQ(right_stays, phase.support != Support::left);
  }
}

TEST(Timeline, ShortStandingAtBothEndsIsLengthenedToWhatThePlanNeeds) {
  const auto without = timeline_of(walk({Straight{0.15, 0}}));
  const auto with = timeline_of(walk({Stand{0.1}, Straight{0.15, 0}, Stand{0.1}}));
  EXPECT_EQ(without.ticks(), with.ticks());
  EXPECT_EQ(with.phases().front().ticks, 330);  // the preview and the smoothing window
  EXPECT_EQ(with.phases().back().ticks, 400);
  EXPECT_EQ(timeline_of(walk({Stand{5}, Straight{0.15, 0}, Stand{5}})).ticks(), 1000u + 320 + 1000);
}

TEST(Timeline, PausesInBetweenLastAsLongAsCommanded) {
  const auto timeline =
      timeline_of(walk({Stand{2}, Straight{0.15, 0}, Stand{1}, Straight{0.15, 0}, Stand{2}}));
  EXPECT_EQ(timeline.phases()[5].ticks, 200);
  EXPECT_EQ(timeline.phases()[5].command, 2);
}

TEST(Timeline, AMomentBeforeOrAfterTheWalkIsItsFirstOrLast) {
  const auto timeline = timeline_of(walk({Stand{2}, Straight{0.15, 0}, Stand{2}}));
  EXPECT_EQ(timeline.at(-5).tick, 0);
  EXPECT_EQ(&timeline.at(-5).phase, &timeline.phases().front());
  EXPECT_EQ(timeline.at(1000000).tick, 399);
  EXPECT_EQ(&timeline.at(1000000).phase, &timeline.phases().back());
  EXPECT_EQ(timeline.at(400).tick, 0);
  EXPECT_EQ(&timeline.at(400).phase, &timeline.phases()[1]);
}

TEST(Timeline, RepeatCarriesTheLastCommandsOutAgainAndKnowsTheLaps) {
  const auto lap = walk({Stand{2}, Straight{0.3, 0}, Turn{}, Stand{1}, Straight{0.3, 0}, Turn{}, Stand{1}});
  const auto repeated =
      timeline_of(walk({Stand{2}, Straight{0.3, 0}, Turn{}, Stand{1}, Repeat{3, 1}, Stand{2}}));
  auto written = lap;
  written.commands.back() = Stand{1};
  written.commands.emplace_back(Stand{2});
  EXPECT_EQ(repeated.ticks(), timeline_of(written).ticks());
  ASSERT_EQ(repeated.laps().size(), 2u);
  EXPECT_EQ(repeated.laps()[0].begin, 400u);
  EXPECT_EQ(repeated.laps()[0].end, repeated.laps()[1].begin);
  EXPECT_EQ(repeated.laps()[1].end - repeated.laps()[1].begin, repeated.laps()[0].end - 400);
  EXPECT_EQ(repeated.laps()[1].end, repeated.ticks() - 400);
  EXPECT_TRUE(timeline_of(lap).laps().empty());
}

void expect_complaint(const std::string& about, const std::function<void(WalkOptions&)>& spoil) {
  WalkOptions options = walk({Stand{1}, TangentArc{}});
  spoil(options);
  try {
    timeline_of(options);
    ADD_FAILURE() << "no complaint about " << about;
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find(about), std::string::npos) << e.what();
  }
}

TEST(Timeline, ImpossibleOptionsAreRefusedByName) {
  expect_complaint("walk.single_support_s", [](auto& o) { o.single_support_s = 0; });
  expect_complaint("walk.double_support_s", [](auto& o) { o.double_support_s = -0.02; });
  expect_complaint("walk.step_height_m", [](auto& o) { o.step_height_m = NAN; });
  expect_complaint("walk.step_length_m", [](auto& o) { o.step_length_m = 0; });
  expect_complaint("walk.preview_s", [](auto& o) { o.preview_s = INFINITY; });
  expect_complaint("walk.com_height_m", [](auto& o) { o.com_height_m = -0.8; });
  expect_complaint("walk.commands", [](auto& o) { o.commands.clear(); });
  expect_complaint("walk.commands[0]", [](auto& o) { o.commands[0] = Stand{-1}; });
  expect_complaint("walk.commands[1]", [](auto& o) { o.commands[1] = TangentArc{0, 1}; });
  expect_complaint("walk.commands[1].turn", [](auto& o) { o.commands[1] = Turn{0}; });
  expect_complaint("walk.commands[1].go_to", [](auto& o) { o.commands[1] = GoTo{NAN, 0, 0}; });
  expect_complaint("walk.commands[1].repeat.last: 2 commands", [](auto& o) { o.commands[1] = Repeat{2, 1}; });
  expect_complaint("walk.commands[1].repeat.times", [](auto& o) { o.commands[1] = Repeat{1, 0}; });
  expect_complaint("one is a repeat itself", [](auto& o) {
    o.commands = {Stand{1}, Repeat{1, 1}, Repeat{1, 1}};
  });
  expect_complaint("walk.steering.gain", [](auto& o) { o.steering.gain = 2; });
}

WalkOptions one_step_each() {
  WalkOptions options;
  options.commands = {Stand{3.0}, Straight{0.15, 0}, Stand{3.0}};
  return options;
}

TEST(SmoothingWeights, AreTheReferenceOnes) {
  const auto w = smoothing_weights();
  const std::array<double, 11> expected{0,        .0190983, .0690983, .1309017, .1809017, .2,
                                        .1809017, .1309017, .0690983, .0190983, 0};
  for (int i = 0; i <= 10; ++i) EXPECT_NEAR(w[i], expected[i], 5e-8);  // seven decimals
  EXPECT_NEAR(std::accumulate(w.begin(), w.end(), 0.0), 1, 1e-15);
}

TEST(ZmpReference, GoesLinearlyToTheFootInDoubleSupportAndStaysThere) {
  const Timeline timeline(one_step_each(), {}, Eigen::Vector2d::Zero());
  const ZmpReference reference(timeline);
  const double y[] = {0, 0, .25, .5, .75, 1, 1};  // of the left foot, the first to carry the robot; 4 ticks
  for (int i = 0; i < 7; ++i) EXPECT_NEAR(reference.raw(600 - 1 + i).y(), 0.095 * y[i], 1e-15);
  EXPECT_NEAR(reference.raw(600 + 159).y(), 0.095, 1e-15);
  EXPECT_NEAR(reference.raw(600 + 160 + 2).y(), 0, 1e-15);  // half way to the right foot
  EXPECT_NEAR(reference.raw(600 + 160 + 2).x(), 0.075, 1e-15);
  EXPECT_NEAR(reference.raw(600 + 160 + 4).y(), -0.095, 1e-15);
}

TEST(ZmpReference, EndsInTheMiddleOfTheFeetAfterHalfADoubleSupport) {
  const Timeline timeline(one_step_each(), {}, Eigen::Vector2d::Zero());
  const ZmpReference reference(timeline);
  const int end = 600 + 320;
  EXPECT_NEAR(reference.raw(end - 1).y(), -0.095, 1e-15);
  EXPECT_NEAR(reference.raw(end).y(), -0.0475, 1e-15);
  EXPECT_NEAR(reference.raw(end + 1).y(), 0, 1e-15);
  EXPECT_NEAR(reference.raw(end + 1).x(), 0.15, 1e-15);
  EXPECT_EQ(reference.raw(end + 100000), reference.raw(static_cast<std::ptrdiff_t>(timeline.ticks()) - 1));
}

TEST(ZmpReference, LiesUnderTheChosenPointOfTheFoot) {
  const Timeline timeline(one_step_each(), {{0, 0}, std::numbers::pi / 2}, {0.004, 0});
  const ZmpReference reference(timeline);
  EXPECT_LT((reference.raw(0) - Eigen::Vector2d(0, 0.004)).norm(), 1e-15);
  EXPECT_LT((reference.raw(700) - Eigen::Vector2d(-0.095, 0.004)).norm(), 1e-15);
}

TEST(ZmpReference, SmoothingKeepsWhatIsConstantAndSpreadsAStepOverNineTicks) {
  const Timeline timeline(one_step_each(), {}, Eigen::Vector2d::Zero());
  const ZmpReference reference(timeline);
  EXPECT_EQ(reference.smoothed(500), reference.raw(500));
  EXPECT_NEAR(reference.smoothed(700).y(), 0.095, 1e-15);
  for (int k = 599; k < 615; ++k) EXPECT_GE(reference.smoothed(k + 1).y(), reference.smoothed(k).y());
  EXPECT_EQ(reference.smoothed(599).y(), 0);  // 601 is the first on its way; the window looks one tick ahead
  EXPECT_GT(reference.smoothed(600).y(), 0);
  EXPECT_LT(reference.smoothed(610).y(), 0.095);
  EXPECT_NEAR(reference.smoothed(611).y(), 0.095, 1e-15);
}

}  // namespace

}  // namespace walking
