// From a landmark's line to the image: each depth's ellipse is searched, and found or not makes the depth
// likelier or less likely (Fig. 3(b) and (c) of Stasse et al. 2006).
#pragma once

#include <opencv2/core.hpp>

#include "slam/camera.h"
#include "slam/kalman.h"
#include "slam/landmark.h"
#include "slam/options.h"

namespace slam {

/// Looks for a line's landmark at each of its depths and reweighs them by |S|^(-1/2) exp(−νᵀS⁻¹ν/2); a depth
/// without a match goes. `landmark` is a SemiInfiniteLine; the state is only read.
void search_along(const cv::Mat& image, const Kalman& kalman, const Camera& camera, const Options& options,
                  Landmark& landmark);

}  // namespace slam
