#include "sim/sensor_errors/motion_errors.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sim::sensor_errors {
namespace {

slam::Stamp frame(int k) { return slam::Stamp(k * 33'333'333LL); }

/// The position of a camera that moves 0.01 m a frame along x, from 5 m on.
Eigen::Vector3d position(LegErrors& errors, int k) {
  slam::LegMotion legs;
  legs.X_OC.translation().x() = 5 + 0.01 * k;
  errors.apply(legs, frame(k));
  return legs.X_OC.translation();
}

// Variance and correlation within four standard deviations of those of so many numbers.
TEST(LegErrors, TheNoiseOfThePositionIsWhiteOfThatSizeAndOfSeedAndStamp) {
  constexpr double n = 4000, variance = 1e-8;
  LegErrors errors(1e-4, 0, 1);
  Eigen::Array3d square = Eigen::Array3d::Zero(), neighbors = square, before = square;
  for (int k = 0; k < n; ++k) {
    const Eigen::Array3d error = position(errors, k) - Eigen::Vector3d(5 + 0.01 * k, 0, 0);
    square += error.square() / n;
    neighbors += error * std::exchange(before, error) / n;
  }
  EXPECT_TRUE(((square - variance).abs() < 4 * variance * std::sqrt(2 / n)).all()) << square.transpose();
  EXPECT_TRUE((neighbors.abs() < 4 * variance / std::sqrt(n)).all()) << neighbors.transpose();
  LegErrors one(1e-4, 0, 1), same(1e-4, 0, 1), other(1e-4, 0, 2);
  position(same, 3);
  EXPECT_EQ(position(one, 7), position(same, 7));
  EXPECT_NE(position(one, 7), position(other, 7));
}

TEST(LegErrors, DistancesFromTheFirstPositionOnAreScaledAndErrorsOfZeroChangeNoBit) {
  LegErrors errors(0, 0.2, 1), none(0, 0, 1);
  EXPECT_EQ(position(errors, 0).x(), 5);
  EXPECT_NEAR(position(errors, 50).x(), 5.6, 1e-12);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(position(none, k), Eigen::Vector3d(5 + 0.01 * k, 0, 0));
}

using slam::Observation, slam::Stamp;

constexpr std::int64_t kMs = 1'000'000;

// Frame k at 30 k ms; the readings of every 5 ms say when they were taken, and so does the plan.
Observation observed(int k) {
  Observation o;
  o.t = Stamp(30 * kMs * k);
  for (int i = 6 * (k - 1); k > 0 && i < 6 * k; ++i)
    o.gyro.push_back({Stamp(5 * kMs * i), Stamp(5 * kMs * (i + 1)), Eigen::Vector3d::Constant(5 * i + 2.5)});
  o.accelerometer = o.gyro;
  for (const slam::InertialSample& reading : o.gyro)
    o.body.push_back(
        {reading.begin, Eigen::VectorXd::Constant(1, 1e3 * slam::seconds(reading.begin)), {}, {}});
  o.plan.emplace();
  o.plan->X_PC.translation().x() = 30 * k;
  o.plan->X_PC.linear() = Eigen::AngleAxisd(0.03 * k, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  o.plan->v_PC_C.y() = 30 * k;
  o.plan->legs.emplace();
  o.plan->legs->X_OC.translation().y() = 30 * k;
  o.plan->legs->p_CS.z() = 30 * k;
  return o;
}

/// All frames by a clock with that offset; the one without a plan: lost on the way to it.
std::vector<Observation> through(Stamp offset, int frames, int without_plan = -1) {
  MotionClock clock(offset);
  std::vector<Observation> all;
  for (int k = 0; k < frames; ++k) {
    Observation ideal = observed(k);
    if (k == without_plan) ideal.plan.reset();
    for (Observation& o : clock.process(std::move(ideal))) all.push_back(std::move(o));
  }
  for (Observation& o : clock.flush()) all.push_back(std::move(o));
  return all;
}

// Readings lie within their frame, leave no gap, and they and the plan are of `offset` before their stamps.
TEST(MotionClock, ThatIsAheadOrBehindGivesEachFrameTheMotionOfAnotherTime) {
  for (const double offset_ms : {7.0, -7.0, 40.0, -40.0}) {
    const auto all = through(Stamp(static_cast<std::int64_t>(offset_ms * 1e6)), 8);
    ASSERT_EQ(all.size(), 8u);
    for (int k = 3; k < 6; ++k) {  // the first and last lack what was before and comes after
      const Observation& o = all[static_cast<std::size_t>(k)];
      ASSERT_EQ(o.t, observed(k).t);
      Stamp begin = o.t - Stamp(30 * kMs);
      for (const slam::InertialSample& reading : o.gyro) {
        EXPECT_EQ(reading.begin, std::exchange(begin, reading.end));
        const double middle_ms = 1e3 * slam::seconds(reading.begin + reading.end) / 2;
        EXPECT_NEAR(reading.value.x(), middle_ms - offset_ms, 2.5);  // half a reading, if it was split
      }
      EXPECT_EQ(begin, o.t);
      EXPECT_EQ(o.accelerometer.size(), o.gyro.size());
      ASSERT_EQ(o.body.size(), 6u);
      for (const slam::BodyReading& reading : o.body) {
        EXPECT_TRUE(reading.t >= o.t - Stamp(30 * kMs) && reading.t < o.t);
        EXPECT_NEAR(1e3 * slam::seconds(reading.t) - offset_ms, reading.q[0], 1e-6);
      }
      const double planned_ms = 30.0 * k - offset_ms;
      const slam::PlannedMotion& plan = *o.plan;
      for (const double ms : {plan.X_PC.translation().x(), plan.v_PC_C.y(), plan.legs->X_OC.translation().y(),
                              plan.legs->p_CS.z(), 1e3 * Eigen::AngleAxisd(plan.X_PC.linear()).angle()})
        EXPECT_NEAR(ms, planned_ms, 1e-6);
    }
  }
}

TEST(MotionClock, GivesNoPlanWhereOneOfTheTwoThatSurroundItIsMissing) {
  const auto all = through(Stamp(7 * kMs), 6, 3);
  EXPECT_TRUE(all[2].plan && !all[3].plan && !all[4].plan && all[5].plan);
}

}  // namespace
}  // namespace sim::sensor_errors
