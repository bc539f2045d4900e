#include "walking/landing_adjustment.h"

#include "tests/walking/walks.h"

namespace walking {
namespace {

using Eigen::Vector2d;
using Options = StabilizerOptions::LandingAdjustment;

class LandingAdjustmentTest : public testing::Test {
 protected:
  /// Plays the plan while the center of mass is off by `error` during the swing of the left foot. The foot in
  /// the air carries `load_n` once the fraction `loaded` of its swing is over.
  void walk(const Vector2d& error, const Options& options, double load_n = 0, double loaded = 2) {
    LandingAdjustment adjustment(kRobot, options);
    for (const Reference& planned : kPlan) {
      StabilizerState state;
      SensorReadings readings;
      readings.q = kRobot.posture;
      const bool left_swings = planned.support == Support::right;
      if (left_swings) state.com_error = error;
      if (left_swings && planned.swing.elapsed >= loaded) readings.left.force.z() = load_n;
      ticks_.push_back(adjustment.adjust(planned, state, readings));
    }
  }

  Vector2d landed(std::size_t tick) const {
    return (ticks_[tick].X_PL.translation() - kPlan[tick].X_PL.translation()).head<2>();
  }
  Vector2d end() const { return landed(ticks_.size() - 1); }

  static inline const std::vector<Reference> kPlan =
      walking::planned(walk_of({Steps{{{0, 0.19, 0}, {0, -0.19, 0}}}}));
  std::vector<Reference> ticks_;
};

constexpr Options kOn{.enabled = true};

TEST_F(LandingAdjustmentTest, MovesNothingIfDisabledOrIfTheErrorIsSmall) {
  const double growth = std::exp(kOn.growth_fraction * std::sqrt(kGravity / kRobot.com_height()) *
                                 WalkOptions{}.single_support_s);
  for (const auto& [options, error] : {std::pair(Options{}, 0.05), {kOn, 0.9 * kOn.dead_zone_m / growth}}) {
    ticks_.clear();
    walk({error, error}, options);
    for (std::size_t k = 0; k < ticks_.size(); ++k) {
      ASSERT_TRUE(ticks_[k].X_PL.matrix() == kPlan[k].X_PL.matrix()) << k;
      ASSERT_TRUE(ticks_[k].com == kPlan[k].com) << k;
    }
  }
}

// At touch-down the error no longer grows: the foothold has moved by the error minus the dead zone.
TEST_F(LandingAdjustmentTest, MovesTheFootholdByTheErrorAtTouchDown) {
  walk({0.05, 0.04}, {.enabled = true, .growth_fraction = 0});
  EXPECT_LT((end() - Vector2d(0.03, 0.02)).norm(), 1e-9);
}

TEST_F(LandingAdjustmentTest, ThePlanFollowsTheFootholdWithoutAJump) {
  walk({0.05, 0.04}, kOn);
  const Reference &last = ticks_.back(), &planned = kPlan.back();
  EXPECT_GT(end().norm(), 0.03);
  EXPECT_LT(((last.com - planned.com).head<2>() - end()).norm(), 1e-12);
  EXPECT_LT((last.frame_shift - end()).norm(), 1e-12);
  // The right foot has followed, too: the feet are as far apart as planned.
  EXPECT_LT(((last.X_PL.translation() - last.X_PR.translation()) -
             (planned.X_PL.translation() - planned.X_PR.translation()))
                .norm(),
            1e-9);
  // The foothold reaches its place while the foot swings, the frame within 0.08 s.
  for (std::size_t k = 1; k < ticks_.size(); ++k) {
    ASSERT_LT((landed(k) - landed(k - 1)).norm() / kPeriod, 0.95)
        << k;  // the limit of planned feet in walks.h
    ASSERT_LT((ticks_[k].frame_shift - ticks_[k - 1].frame_shift).norm() / kPeriod,
              1.51 * end().norm() / kOn.shift_s);
  }
}

TEST_F(LandingAdjustmentTest, StaysWithinItsLimitsAndTheAreaOfSteps) {
  const double spacing = kRobot.foot_spacing;
  // On the inside, the soles (0.138 m wide at a spacing of 0.19 m) stay at least 0.01 m apart.
  for (const auto& [error, least, most] : std::vector<std::tuple<Vector2d, Vector2d, Vector2d>>{
           {{0.5, 0}, {0.1199, -1e-9}, {0.1201, 1e-9}},
           {{-0.5, 0}, {-0.1201, -1e-9}, {-0.1199, 1e-9}},
           {{0, -0.5}, {-1e-9, -kOn.largest_inwards_m - 1e-9}, {1e-9, -0.02}},
           {{0, 0.5}, {-1e-9, 0.05}, {1e-9, 0.36 - spacing + 1e-9}}}) {
    ticks_.clear();
    walk(error, {.enabled = true, .growth_fraction = 0});
    EXPECT_TRUE((end().array() >= least.array()).all() && (end().array() <= most.array()).all())
        << error.transpose() << " -> " << end().transpose();
  }
}

TEST_F(LandingAdjustmentTest, AFootThatTouchesDownEarlyStays) {
  walk({0.05, 0.04}, kOn, 100, 0.7);
  Vector2d at_contact = Vector2d::Zero();
  for (std::size_t k = 0; k < ticks_.size(); ++k)
    if (kPlan[k].support == Support::right && kPlan[k].swing.elapsed < 0.7) at_contact = landed(k);
  EXPECT_EQ(end(), at_contact);
  EXPECT_GT(at_contact.norm(), 0.01);
  ticks_.clear();
  walk({0.05, 0.04}, kOn, 20, 0.7);  // a swinging foot may measure this much
  EXPECT_GT((end() - at_contact).norm(), 0.005);
}

}  // namespace
}  // namespace walking
