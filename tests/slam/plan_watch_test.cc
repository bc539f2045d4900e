#include "slam/plan_watch.h"

#include <gtest/gtest.h>

#include <string>

namespace slam {
namespace {

/// What a plan whose distances are wrong by the relative error δ leaves, known with standard deviation sigma.
ScaleEvidence evidence(double delta, double sigma) { return {delta / (sigma * sigma), 1 / (sigma * sigma)}; }

PlanWatch watch_after(double delta, double sigma, const Options& options = {}) {
  PlanWatch watch(options);
  for (int k = 0; k < 100; ++k) watch.take(evidence(delta, 10 * sigma));  // together as sure as one of sigma
  return watch;
}

TEST(PlanWatch, NamesAPlanThatTheInnovationsContradictByMoreThanTheBound) {
  EXPECT_EQ(watch_after(0.09, 0.01).suspect(),
            "plan: its distances are too long by 9 standard deviations of the innovations");
  EXPECT_EQ(watch_after(-0.06, 0.01).suspect(),
            "plan: its distances are too short by 6 standard deviations of the innovations");
}

TEST(PlanWatch, IsSilentBelowItAndWithoutEvidence) {
  EXPECT_EQ(PlanWatch(Options{}).suspect(), "");
  EXPECT_EQ(watch_after(0.049, 0.01).suspect(), "");
  EXPECT_EQ(watch_after(-0.4, 0.1).suspect(), "");
}

TEST(PlanWatch, TheBoundIsAnOption) {
  Options options;
  options.tracking.plan_bound = 3;
  EXPECT_NE(watch_after(0.04, 0.01, options).suspect(), "");
}

TEST(PlanWatch, IsSilentWhereNoOtherSensorKnowsTheMetre) {
  Options options;
  options.accelerometer.enabled = false;
  EXPECT_EQ(watch_after(0.2, 0.01, options).suspect(), "");
}

TEST(PlanWatch, AddsUpAllEvidenceAndForgetsItWhenReset) {
  PlanWatch watch{Options{}};
  watch.take(evidence(0.1, 0.02));
  watch.take(evidence(0.3, 0.02));
  EXPECT_NEAR(watch.sigmas(), 0.2 / (0.02 / 1.4142135623730951), 1e-12);
  watch.reset();
  EXPECT_EQ(watch.sigmas(), 0);
}

}  // namespace
}  // namespace slam
