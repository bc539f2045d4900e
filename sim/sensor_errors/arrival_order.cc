#include "sim/sensor_errors/arrival_order.h"

#include <algorithm>
#include <utility>

#include "sim/sensor_errors/random.h"

namespace sim::sensor_errors {
namespace {

template <class Faults>
bool applies(const Faults& faults, std::uint64_t seed, const char* stream, slam::Stamp t) {
  const double drawn = Random(seed, stream, static_cast<std::uint64_t>(t.count())).uniform();
  return std::any_of(faults.begin(), faults.end(),
                     [&](const auto& fault) { return fault.holds(t) && drawn < fault.fraction; });
}

}  // namespace

ArrivalOrder::ArrivalOrder(std::uint64_t seed, const std::vector<Fault>& faults)
    : seed_(seed),
      doubled_(faults_of<FramesDoubled>(faults)),
      reordered_(faults_of<FramesReordered>(faults)) {}

bool ArrivalOrder::doubled(slam::Stamp t) const { return applies(doubled_, seed_, "frame doubled", t); }
bool ArrivalOrder::late(slam::Stamp t) const { return applies(reordered_, seed_, "frame reordered", t); }

std::vector<slam::Observation> ArrivalOrder::take(slam::Observation observation) {
  if (!late_ && late(observation.t)) {
    late_ = std::move(observation);
    return {};
  }
  std::vector<slam::Observation> arrived(doubled(observation.t) ? 2 : 1, observation);
  if (late_) arrived.push_back(*std::exchange(late_, {}));
  return arrived;
}

std::vector<slam::Observation> ArrivalOrder::flush() {
  if (!late_) return {};
  return {*std::exchange(late_, {})};
}

}  // namespace sim::sensor_errors
