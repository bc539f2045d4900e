// Failures ranked, hopeless settings given up, fronts.
#include "sim/tune/study.h"

#include <gtest/gtest.h>

#include "sim/tune/optimise.h"

namespace sim::tune {
namespace {

TrialRecord success(double nll) {
  return {"k", 1, "completed", "", {{"pose_nll", nll}, {"lasted_fraction", 1}}};
}
TrialRecord failure(double lasted) { return {"k", 1, "diverged", "lost", {{"lasted_fraction", lasted}}}; }
double value(const TrialRecord& record) { return value_of(record, Objective::pose_nll); }

TEST(Failure, IsWorseThanAnySuccessAndTheWorseTheEarlier) {
  EXPECT_LT(value(success(-20)), value(success(1e5)));
  EXPECT_LT(value(success(1e300)), value(failure(1)));
  EXPECT_LT(value(failure(0.9)), value(failure(0.1)));
  EXPECT_TRUE(std::isfinite(value(failure(0))));
}

TEST(Failure, OfOneRunIsBetterThanOfTwo) {
  const TrialRecord good = success(-5), late = failure(0.99), early = failure(0.01);
  const auto mean = [](std::vector<const TrialRecord*> records) {
    return mean_value(records, {0, 1}, Objective::pose_nll);
  };
  EXPECT_LT(mean({&good, &early}), mean({&late, &late}));
}

TEST(Front, HoldsWhatNothingIsBetterThanInBoth) {
  const TrialRecord record = success(0);
  std::vector<Candidate> all;
  for (const auto& values : std::vector<std::vector<double>>{{1, 9}, {2, 4}, {3, 5}, {4, 1}, {9, 1}, {2, 4}})
    all.push_back({"global", {0}, {&record}, values});
  all.push_back({"global", {0}, {nullptr}, {0, 0}});  // given up
  std::vector<std::vector<double>> front;
  for (const Candidate* c : pareto_front(all)) front.push_back(c->values);
  EXPECT_EQ(front, (std::vector<std::vector<double>>{{1, 9}, {2, 4}, {4, 1}}));
  EXPECT_EQ(compromise(pareto_front(all)).values, (std::vector<double>{2, 4}));
}

}  // namespace
}  // namespace sim::tune
