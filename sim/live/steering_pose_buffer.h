// The input of steering: the newest estimate of the robot's place that is old enough.
#pragma once

#include <Eigen/Geometry>
#include <deque>

#include "sim/sensor_errors/faults.h"
#include "slam/frame_report.h"
#include "walking/steering.h"

namespace sim::live {

/// Returns the support sole planned at the estimate's stamp, as seen from the estimated camera. Camera and
/// planned sole are treated as one rigid body, so that a body that tilts about its foot does not move the
/// foot.
walking::PlaceEstimate place_estimate(const slam::Estimate& estimate, const slam::PlannedMotion& planned);

/// Buffers estimates until they are old enough for steering. Also applies faults of the estimate
/// (errors.faults: estimate_...).
class SteeringPoseBuffer {
 public:
  SteeringPoseBuffer(const walking::SteeringOptions& options, const std::vector<sensor_errors::Fault>& faults,
                     slam::Stamp exposure);
  /// Adds the motion that was actually planned at a frame's stamp.
  void add(slam::Stamp t, const slam::PlannedMotion& planned) { planned_.push_back({t, planned}); }
  /// Adds the estimate for the frame with that stamp. tracks: neither lost nor diverged.
  void add(slam::Stamp frame, slam::Estimate estimate, bool tracks);
  /// Returns the stamp of the last frame whose estimate may be used now: as old as the latency, with its
  /// image complete.
  slam::Stamp usable_until(slam::Stamp now) const { return now - delay_; }
  /// Returns the newest estimate of a frame up to that stamp, or nothing before the first.
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
