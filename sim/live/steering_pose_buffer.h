// What steering is told: the newest estimate of the robot's place that is old enough to be used.
#pragma once

#include <Eigen/Geometry>
#include <deque>
#include <optional>
#include <vector>

#include "sim/sensor_errors/faults.h"
#include "slam/frame_report.h"
#include "walking/steering.h"

namespace sim::live {

/// The support sole that was planned at the estimate's stamp, as the estimated camera sees it: camera and
/// planned sole are taken as one rigid body, so that a body that tilts about its foot does not move the foot.
walking::PlaceEstimate place_estimate(const slam::Estimate& estimate, const slam::PlannedMotion& planned);

/// Estimates from the frame on which they were made until one may be used that is newer. Faults of the
/// estimate (errors.faults: estimate_...) are applied on the way.
class SteeringPoseBuffer {
 public:
  SteeringPoseBuffer(const walking::SteeringOptions& options, const std::vector<sensor_errors::Fault>& faults,
                     slam::Stamp exposure);

  /// The motion that was really planned at a frame's stamp.
  void add(slam::Stamp t, const slam::PlannedMotion& planned);
  /// What was estimated once the frame of that stamp, and no later one, was taken. tracks: neither lost nor
  /// diverged.
  void add(slam::Stamp frame, slam::Estimate estimate, bool tracks);

  /// The last frame whose estimate may be used now: it is as old as the latency, and its image complete.
  slam::Stamp usable_until(slam::Stamp now) const { return now - delay_; }
  /// The newest estimate of a frame up to that stamp; nothing before the first.
  std::optional<walking::PlaceEstimate> newest(slam::Stamp until);

 private:
  struct Planned {
    slam::Stamp t{0};
    slam::PlannedMotion motion;
  };
  struct Place {
    slam::Stamp frame{0};
    walking::PlaceEstimate estimate;
  };

  slam::Stamp delay_;
  std::vector<sensor_errors::EstimateJump> jumps_;
  std::vector<sensor_errors::EstimateFrozen> frozen_;
  std::vector<sensor_errors::EstimateLost> lost_;
  std::optional<slam::Estimate> last_unfrozen_;
  std::deque<Planned> planned_;
  std::deque<Place> places_;
  std::optional<walking::PlaceEstimate> newest_;
};

}  // namespace sim::live
