// Who looks on while the robot walks, without any part in what comes of it.
#pragma once

#include <functional>

#include "sim/physics/world.h"
#include "sim/recording/recording.h"
#include "sim/tracking/tracking.h"
#include "walking/plan.h"
#include "walking/stabilizer.h"

namespace sim::live {

/// Robot and plan when a frame is stamped.
struct StampedState {
  slam::Stamp t{0};
  const physics::World& world;
  const walking::Reference& plan;
  Eigen::Isometry3d X_PC;               ///< planned camera
  const recording::TrueFeet& feet;      ///< of the last tick
  const walking::Wrench &left, &right;  ///< of the ground on the feet, at this tick
};

/// Of a run. Whoever does not look on leaves them empty.
struct RunObserver {
  std::function<void(const recording::RecordingSetup&)> begins = {};
  /// At the end of each tick of 5 ms; returns when the walk may go on.
  std::function<void(slam::Stamp)> ticked = {};
  std::function<void(const StampedState&)> stamped = {};
  tracking::TrackingObserver tracking = {};  ///< some frames later, with the image
};

}  // namespace sim::live
