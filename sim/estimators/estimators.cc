#include "sim/estimators/estimators.h"

#include <array>

namespace sim::estimators {
namespace {

/// The camera is where the walking plan has it.
Estimator plan_alone(const slam::Calibration&, const Eigen::Isometry3d& X_WC_start) {
  slam::Estimate believed;
  believed.X_WC = X_WC_start;
  return [believed](const slam::Observation& observation) mutable {
    believed.t = observation.t;
    if (observation.plan) believed.X_WC = observation.plan->X_PC;
    return believed;
  };
}

constexpr std::array kEstimators{NamedEstimator{"plan_alone", plan_alone}};

}  // namespace

std::span<const NamedEstimator> estimators() { return kEstimators; }

std::span<const std::string_view> estimator_names() {
  static constexpr auto kNames = [] {
    std::array<std::string_view, kEstimators.size() + 1> names{"filter"};
    for (std::size_t i = 0; i < kEstimators.size(); ++i) names[i + 1] = kEstimators[i].name;
    return names;
  }();
  return kNames;
}

}  // namespace sim::estimators
