#include "sim/stream/arrival.h"

#include <algorithm>
#include <utility>

#include "sim/stream/random.h"

namespace sim::stream {
namespace {

template <class Faults>
bool strikes(const Faults& faults, std::uint64_t seed, const char* stream, slam::Stamp t) {
  const double drawn = Random(seed, stream, static_cast<std::uint64_t>(t.count())).uniform();
  return std::any_of(faults.begin(), faults.end(),
                     [&](const auto& fault) { return fault.holds(t) && drawn < fault.fraction; });
}

}  // namespace

Arrival::Arrival(std::uint64_t seed, const std::vector<Fault>& faults)
    : seed_(seed),
      doubled_(faults_of<FramesDoubled>(faults)),
      reordered_(faults_of<FramesReordered>(faults)) {}

bool Arrival::doubled(slam::Stamp t) const { return strikes(doubled_, seed_, "frame doubled", t); }
bool Arrival::late(slam::Stamp t) const { return strikes(reordered_, seed_, "frame reordered", t); }

std::vector<slam::Observation> Arrival::take(slam::Observation observation) {
  if (!late_ && late(observation.t)) {
    late_ = std::move(observation);
    return {};
  }
  std::vector<slam::Observation> arrived(doubled(observation.t) ? 2 : 1, observation);
  if (late_) arrived.push_back(*std::exchange(late_, {}));
  return arrived;
}

std::vector<slam::Observation> Arrival::rest() {
  if (!late_) return {};
  return {*std::exchange(late_, {})};
}

}  // namespace sim::stream
