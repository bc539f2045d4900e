#include "sim/recording/clock_offset.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "tests/sim/recording/random_readings.h"

namespace sim::recording {
namespace {

using Rate = std::function<Eigen::Vector3d(double)>;

/// Compares 40 s of a gyro at 200 Hz with late stamps and a truth at 100 Hz.
std::optional<ClockOffset> offset_of(const Rate& rate, double late_s, double noise_rad_s) {
  std::vector<TimedRotation> gyro;
  std::vector<files::TumRow> truth;
  sensor_errors::Random random(1, "gyro");
  const auto stamp = [](double t) { return slam::Stamp(std::llround(1e9 * t)); };
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  for (std::uint64_t i = 0; i < 8000; ++i) {
    const double t = 0.005 * static_cast<double>(i);
    const Eigen::Vector3d w = rate(t);
    gyro.push_back({stamp(t + late_s), w + noise_rad_s * tests::random_vector(random)});
    files::TumRow row;
    row.t = stamp(t);
    row.X.linear() = q.toRotationMatrix();
    if (i % 2 == 0) truth.push_back(row);
    q = (q * Eigen::Quaterniond(Eigen::AngleAxisd(0.005 * w.norm(), w.stableNormalized()))).normalized();
  }
  return clock_offset(gyro, truth);
}

constexpr double kStep = 2 * std::numbers::pi / 0.8;  // rad/s: steps of 0.8 s

Eigen::Vector3d walk(double t) {
  return {0.1 * std::sin(kStep * t), 0.05 * std::cos(2 * kStep * t), 0.2 * std::sin(0.3 * t)};
}
Eigen::Vector3d even_walk(double t) { return {0.1 * std::sin(kStep * t), 0.05 * std::cos(kStep * t), 0.3}; }

TEST(ClockOffset, IsMeasuredBySpeedsOfRotation) {
  for (const double late_s : {-2.0, -0.3, 0.06, 0.3, 0.8, 1.5, 2.0, 7.0})
    for (const double noise : {0.0, 0.05}) {
      const auto offset = offset_of(walk, late_s, noise);
      ASSERT_TRUE(offset) << late_s << " " << noise;
      EXPECT_NEAR(offset->late_s, late_s, 0.021);  // the step of the grid
      EXPECT_GT(offset->correlation, offset->as_stamped);
      EXPECT_NEAR(offset->gain, 1, 0.1);
    }
}

TEST(ClockOffset, IsAbsentOnOneClockAndWithoutEvidence) {
  for (const double noise : {0.0, 0.05, 1.0}) {
    for (const Rate& rate : {Rate(walk), Rate(even_walk)})
      for (const double late_s : {0.0, 0.004}) {
        const auto offset = offset_of(rate, late_s, noise);
        EXPECT_LE(offset ? std::abs(offset->late_s) : 0, 0.02) << noise << " " << late_s;
      }
    EXPECT_FALSE(offset_of([](double) -> Eigen::Vector3d { return Eigen::Vector3d::Zero(); }, 1, noise));
    EXPECT_FALSE(offset_of([](double) -> Eigen::Vector3d { return {0, 0, 0.3}; }, 1, noise));
  }
  EXPECT_FALSE(offset_of(walk, 1, 5.0)) << "noise hides the motion";
  EXPECT_FALSE(offset_of(walk, 100, 0)) << "the spans are disjoint";
}

}  // namespace
}  // namespace sim::recording
