#include "sim/estimators/estimators.h"

#include <array>
#include <stdexcept>
#include <string>

#include "sim/estimators/library_estimator.h"
#include "sim/estimators/program_estimator.h"

namespace sim::estimators {
namespace {

/// The camera is where the walking plan has it.
Step plan_alone(const Start& start) {
  PoseEstimate believed;
  believed.X_WC = start.X_WC;
  return [believed](const slam::Observation& observation) mutable {
    believed.t = observation.t;
    if (observation.plan) believed.X_WC = observation.plan->X_PC;
    Answer answer;
    answer.estimate = believed;
    return answer;
  };
}

constexpr std::array kEstimators{NamedEstimator{"plan_alone", plan_alone}};

Step built_in(const std::string& name, const Start& start) {
  for (const NamedEstimator& estimator : kEstimators)
    if (estimator.name == name) return estimator.make(start);
  return {};
}

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

Estimator make_estimator(const EstimatorChoice& choice, const Start& start) {
  switch (choice.source) {
    case Source::built_in:
      return {.step = built_in(choice.name, start)};
    case Source::program:
      return program_estimator(choice, start);
    case Source::library:
      return library_estimator(choice, start);
    case Source::command:
      break;
  }
  throw std::invalid_argument(
      "estimator: was a command on an exported recording, which gaitslam evaluate runs; expected another "
      "estimator");
}

}  // namespace sim::estimators
