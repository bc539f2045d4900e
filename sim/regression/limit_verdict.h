// The limits of a scenario, judged on all its seeds: they must be met whatever the baseline says.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sim/result/limits.h"

namespace sim::regression {

/// A limit on each seed, or on a value over all seeds.
struct LimitVerdict {
  std::string what;      ///< "ate_se3_rmse_m <= 0.1", "loop_closed.mean >= 1", "ending completed"
  std::string observed;  ///< "9/10": seeds that meet it; or the value over seeds
  bool passed = true;
  bool run_failed = false;  ///< a run ended in a way that is not allowed
  std::uint64_t worst_seed = 0;
};
/// "ok", "MISSED" or "RUN FAILED".
std::string_view word(const LimitVerdict& verdict);

/// First the allowed endings, then the limits on each seed, then those over seeds. A limit that is not judged
/// on any seed, since no filter was to run, is left out.
std::vector<LimitVerdict> judge_limits(const scenario::Scenario& scenario,
                                       const std::vector<result::SeedScore>& seeds);

}  // namespace sim::regression
