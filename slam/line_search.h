// The search for a landmark that is still a line: a match, or its absence, at each of its depths changes the
// probabilities of the depths (Stasse et al. 2006, Fig. 3(b) and (c)).
#pragma once

#include <opencv2/core.hpp>

#include "slam/camera.h"
#include "slam/kalman.h"
#include "slam/landmark.h"
#include "slam/options.h"

namespace slam {

/// Searches the image for the landmark, which is a SemiInfiniteLine, at each of its depths and multiplies
/// their probabilities by |S|^(-1/2) exp(−νᵀS⁻¹ν/2); depths without a match are removed. The state is only
/// read.
void search_line(const cv::Mat& image, const Kalman& kalman, const Camera& camera,
                 const Options::Vision& options, Landmark& landmark);

}  // namespace slam
