// The specification of a tuning: parameters, objective and recordings, from one YAML file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/scenario/scenario.h"
#include "sim/trials/values.h"

namespace sim::trials {

/// A recording, and the scenario to replay it with.
struct SpecRun {
  std::string name;             ///< "tangent_circle/seed-1"
  scenario::ReadScenario read;  ///< with the seed of the recording, unless the entry sets another
  std::uint64_t recorded_seed = 0;
  std::filesystem::path folder{};  ///< the result folder; empty: it is in the cache
};

/// The loss that a tuning minimizes: see Trial, or the metric.
enum class Objective { pose_nll, innovation_nll, rmse_m };
/// Returns the objective's name in a spec and in a trial's record.
std::string_view name(Objective objective);

struct Spec {
  std::string name;               ///< the stem of the file's name
  std::vector<Range> parameters;  ///< each with a start
  std::vector<SpecRun> training, holdout;
  Objective objective = Objective::pose_nll;
  int trials = 200;     ///< settings tried by the search
  int population = 10;  ///< of a generation of CMA-ES
  std::uint64_t seed = 1;
};

/// Reads a spec; its paths are relative to its folder. Throws ConfigError ("file:line:column: key: ...") at
/// the first fault, among them a hold-out with a walk of the training.
Spec read_spec(const std::filesystem::path& file);

}  // namespace sim::trials
