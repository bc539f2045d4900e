#include "sim/sensor_errors/motion_clock.h"

#include <gtest/gtest.h>

namespace sim::sensor_errors {
namespace {

using slam::Observation, slam::Stamp;

constexpr std::int64_t kMs = 1'000'000;

// Frame k at 30 k ms; the readings of every 5 ms say when they were taken, and so does the plan.
Observation observed(int k) {
  Observation o;
  o.t = Stamp(30 * kMs * k);
  for (int i = 6 * (k - 1); k > 0 && i < 6 * k; ++i)
    o.gyro.push_back({Stamp(5 * kMs * i), Stamp(5 * kMs * (i + 1)), Eigen::Vector3d::Constant(5 * i + 2.5)});
  o.accelerometer = o.gyro;
  o.plan.emplace();
  o.plan->X_PC.translation().x() = 30 * k;
  o.plan->X_PC.linear() = Eigen::AngleAxisd(0.03 * k, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  o.plan->v_PC_C.y() = 30 * k;
  o.plan->legs.emplace();
  o.plan->legs->X_OC.translation().y() = 30 * k;
  o.plan->legs->p_CS.z() = 30 * k;
  return o;
}

std::vector<Observation> through(Stamp offset, int frames) {
  MotionClock clock(offset);
  std::vector<Observation> all;
  for (int k = 0; k < frames; ++k)
    for (Observation& o : clock.process(observed(k))) all.push_back(std::move(o));
  for (Observation& o : clock.flush()) all.push_back(std::move(o));
  return all;
}

// Readings lie within their frame, leave no gap and are what was felt `offset` before their stamps.
void expect_stamped_late_by(double offset_ms, const Observation& o) {
  ASSERT_FALSE(o.gyro.empty());
  EXPECT_EQ(o.gyro.front().begin, o.t - Stamp(30 * kMs));
  EXPECT_EQ(o.gyro.back().end, o.t);
  for (std::size_t i = 0; i < o.gyro.size(); ++i) {
    if (i > 0) {
      EXPECT_EQ(o.gyro[i].begin, o.gyro[i - 1].end);
    }
    const double middle_ms = 1e3 * slam::seconds(o.gyro[i].begin + o.gyro[i].end) / 2;
    EXPECT_NEAR(o.gyro[i].value.x(), middle_ms - offset_ms, 2.5);  // half a reading, if it was split
  }
  EXPECT_EQ(o.accelerometer.size(), o.gyro.size());
}

TEST(MotionClock, ThatIsRightChangesNothing) {
  const auto all = through(Stamp(0), 5);
  ASSERT_EQ(all.size(), 5u);
  for (int k = 0; k < 5; ++k) {
    const Observation &o = all[static_cast<std::size_t>(k)], ideal = observed(k);
    ASSERT_EQ(o.gyro.size(), ideal.gyro.size());
    for (std::size_t i = 0; i < o.gyro.size(); ++i) EXPECT_EQ(o.gyro[i].value, ideal.gyro[i].value);
    EXPECT_EQ(o.plan->X_PC.matrix(), ideal.plan->X_PC.matrix());
  }
}

TEST(MotionClock, ThatIsAheadOrBehindGivesEachFrameTheMotionOfAnotherTime) {
  for (const double offset_ms : {7.0, -7.0, 40.0, -40.0}) {
    const auto all = through(Stamp(static_cast<std::int64_t>(offset_ms * 1e6)), 8);
    ASSERT_EQ(all.size(), 8u);
    for (std::size_t k = 3; k < 6; ++k) {  // the first and last lack what was before and comes after
      EXPECT_EQ(all[k].t, observed(static_cast<int>(k)).t);
      expect_stamped_late_by(offset_ms, all[k]);
      const double planned_ms = 30.0 * static_cast<double>(k) - offset_ms;
      EXPECT_NEAR(all[k].plan->X_PC.translation().x(), planned_ms, 1e-9);
      EXPECT_NEAR(all[k].plan->v_PC_C.y(), planned_ms, 1e-9);
      EXPECT_NEAR(all[k].plan->legs->X_OC.translation().y(), planned_ms, 1e-9);
      EXPECT_NEAR(all[k].plan->legs->p_CS.z(), planned_ms, 1e-9);
      EXPECT_NEAR(Eigen::AngleAxisd(all[k].plan->X_PC.linear()).angle(), 1e-3 * planned_ms, 1e-9);
    }
  }
}

TEST(MotionClock, GivesNoPlanWhereOneOfTheTwoThatSurroundItIsMissing) {
  MotionClock clock(Stamp(7 * kMs));
  std::vector<Observation> all;
  for (int k = 0; k < 6; ++k) {
    Observation o = observed(k);
    if (k == 3) o.plan.reset();
    for (Observation& assembled : clock.process(o)) all.push_back(std::move(assembled));
  }
  EXPECT_TRUE(all[2].plan && !all[3].plan && !all[4].plan && all[5].plan);
}

}  // namespace
}  // namespace sim::sensor_errors
