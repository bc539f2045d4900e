// The equidistant lens that is nearest to another one, for programs that do not know the other one.
#pragma once

#include "slam/options.h"

namespace sim::rig {

/// A camera that approximates another one; the distance of their pixels over the whole image.
struct FittedCamera {
  slam::CameraIntrinsics camera;
  double rms_px = 0, largest_px = 0;
};

/// The equidistant camera nearest to the given one: least squares in the two focal lengths and four
/// coefficients over a grid of pixels that includes the borders. The principal point is kept.
FittedCamera fit_equidistant(const slam::CameraIntrinsics& camera);

}  // namespace sim::rig
