// The losses of trials that failed.
#include "sim/tune/study.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sim::tune {
namespace {

TrialRecord success(double nll) {
  return {"k", 1, "completed", "", {{"pose_nll", nll}, {"lasted_fraction", 1}}};
}
TrialRecord failure(double lasted) { return {"k", 1, "diverged", "lost", {{"lasted_fraction", lasted}}}; }
double loss(const TrialRecord& record) { return loss_of(record, Objective::pose_nll); }

TEST(Failure, IsWorseThanAnySuccessAndTheWorseTheEarlier) {
  EXPECT_LT(loss(success(-20)), loss(success(1e5)));
  EXPECT_LT(loss(success(1e300)), loss(failure(1)));
  EXPECT_LT(loss(failure(0.9)), loss(failure(0.1)));
  EXPECT_TRUE(std::isfinite(loss(failure(0))));
}

TEST(Failure, OfOneRunIsBetterThanOfTwo) {
  const TrialRecord good = success(-5), late = failure(0.99), early = failure(0.01);
  const auto mean = [](std::vector<const TrialRecord*> records) {
    return mean_loss(records, Objective::pose_nll);
  };
  EXPECT_LT(mean({&good, &early}), mean({&late, &late}));
}

}  // namespace
}  // namespace sim::tune
