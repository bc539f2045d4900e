// Input of steering: the newest estimate of the robot's place that is old enough.
#pragma once

#include <Eigen/Geometry>
#include <deque>

#include "sim/sensor_errors/faults.h"
#include "slam/frame_report.h"
#include "walking/steering.h"

namespace sim::live {

/// The support sole that was planned at the estimate's stamp, as the estimated camera sees it: camera and
/// planned sole are taken as one rigid body, so that a body that tilts about its foot does not move the foot.
walking::PlaceEstimate place_estimate(const slam::Estimate& estimate, const slam::PlannedMotion& planned);

/// Buffers estimates until they are old enough for steering. Faults of the estimate (errors.faults:
/// estimate_...) are applied on the way.
class SteeringPoseBuffer {
 public:
  SteeringPoseBuffer(const walking::SteeringOptions& options, const std::vector<sensor_errors::Fault>& faults,
                     slam::Stamp exposure);
  /// The motion that was really planned at a frame's stamp.
  void add(slam::Stamp t, const slam::PlannedMotion& planned) { planned_.push_back({t, planned}); }
  /// The estimate after the frame of that stamp. tracks: neither lost nor diverged.
  void add(slam::Stamp frame, slam::Estimate estimate, bool tracks);
  /// Stamp of the last frame with an estimate that may be used now: as old as the latency, its image
  /// complete.
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
