#include "sim/recording/filter_input.h"

#include <utility>

namespace sim::recording {

std::optional<slam::Observation> FilterInput::next() {
  while (arrived_.empty() && !ended_) {
    std::optional<slam::Observation> ideal = reader_.next();
    ended_ = !ideal;
    for (slam::Observation& o : ideal ? errors_.take(std::move(*ideal)) : errors_.flush())
      arrived_.push_back(std::move(o));
  }
  if (arrived_.empty()) return std::nullopt;
  slam::Observation next = std::move(arrived_.front());
  arrived_.pop_front();
  return next;
}

std::optional<slam::Observation> FilterInput::next_in_order() {
  std::optional<slam::Observation> observation = next();
  while (observation && last_ && observation->t <= *last_) observation = next();
  if (observation) last_ = observation->t;
  return observation;
}

}  // namespace sim::recording
