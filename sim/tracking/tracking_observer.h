// Who looks on while observations are tracked, without any part in what comes of it.
#pragma once

#include <functional>

#include "sim/tracking/tracking.h"

namespace sim::tracking {

/// Called for each observation, in their order. Whoever does not look on leaves them empty.
struct TrackingObserver {
  /// Before the observation is given to the filter: whether its report is to be shown.
  std::function<bool(const slam::Observation& ideal)> wants = {};
  /// After it, where wanted. tracking: null where no filter runs.
  std::function<void(const slam::Observation& ideal, const Tracking* tracking)> tracked = {};
};

/// Gives an observation to the filter, if there is one, and shows it to the observer.
template <class Take>
void take_observed(slam::Observation ideal, const Tracking* tracking, const TrackingObserver& observer,
                   const Take& take) {
  if (!observer.wants || !observer.wants(ideal)) return take(std::move(ideal));
  slam::Observation shown = ideal;
  shown.image = ideal.image.clone();  // sensor errors may be applied in place
  take(std::move(ideal));
  observer.tracked(shown, tracking);
}

}  // namespace sim::tracking
