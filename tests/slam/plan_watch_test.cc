#include "slam/plan_watch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace slam {
namespace {

/// What a plan whose distances are wrong by the relative error δ leaves, known with standard deviation sigma.
ScaleEvidence evidence(double delta, double sigma) {
  return {delta / (sigma * sigma), 1 / (sigma * sigma)};
}

std::string suspect_after(double delta, double sigma, const Options& options = {}) {
  PlanWatch watch(options);
  for (int k = 0; k < 100; ++k) watch.take(evidence(delta, 10 * sigma));  // together as sure as one of sigma
  return watch.suspect();
}

TEST(PlanWatch, NamesAPlanThatIsSurelyTooLongOrTooShort) {
  EXPECT_EQ(suspect_after(1 - 1 / 1.2, 0.01), "plan: its distances are about 20 % too long by the other sensors");
  EXPECT_EQ(suspect_after(1 - 1 / 0.8, 0.01), "plan: its distances are about 20 % too short by the other sensors");
}

TEST(PlanWatch, IsSilentAboutASmallErrorAndAboutOneThatIsNotSure) {
  EXPECT_EQ(PlanWatch(Options{}).suspect(), "");
  EXPECT_EQ(suspect_after(1 - 1 / 1.05, 0.001), "");
  EXPECT_EQ(suspect_after(1 - 1 / 1.2, 0.1), "");
}

TEST(PlanWatch, TheLeastErrorIsAnOption) {
  Options options;
  options.tracking.plan_error = 0.03;
  EXPECT_NE(suspect_after(1 - 1 / 1.05, 0.001, options), "");
}

TEST(PlanWatch, IsSilentWhereNoOtherSensorKnowsTheMetre) {
  Options options;
  options.accelerometer.enabled = false;
  EXPECT_EQ(suspect_after(1 - 1 / 1.2, 0.01, options), "");
}

TEST(PlanWatch, EstimatesTheErrorFromAllEvidenceAndForgetsItWhenReset) {
  PlanWatch watch{Options{}};
  watch.take(evidence(0.1, 0.02));
  watch.take(evidence(0.3, 0.02));
  EXPECT_NEAR(watch.error(), 0.2, 1e-12);
  EXPECT_NEAR(watch.sigma(), 0.02 / std::sqrt(2), 1e-12);
  watch.reset();
  EXPECT_EQ(watch.error(), 0);
}

}  // namespace
}  // namespace slam
