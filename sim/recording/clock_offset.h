// Offset between the clocks of a gyro and of a truth, measured by their speeds of rotation.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "sim/files/trajectory_file.h"
#include "slam/observation.h"

namespace sim::recording {

/// A reading of a gyro.
struct TimedRotation {
  slam::Stamp t{0};
  Eigen::Vector3d value;  ///< rad/s
};

struct ClockOffset {
  double late_s;                   ///< stamps of the gyro minus those of the truth; 0 without evidence
  double correlation, as_stamped;  ///< of the speeds of rotation, at this offset and at none
  double gain;                     ///< the gyro's speeds relative to those of the truth
};

/// Returns nothing unless the speeds of rotation in the first hour correlate by at least 0.6 at an offset of
/// at most 10 s. That is evidence if it explains them decisively better than none: by a log-likelihood ratio
/// of the two linear relations of at least 15, if speeds over 0.1 s are independent. The axes of the two
/// bodies and a bias do not matter.
std::optional<ClockOffset> clock_offset(const std::vector<TimedRotation>& gyro,
                                        const std::vector<files::TumRow>& truth);

}  // namespace sim::recording
