// The orientation of a landmark's surface, estimated from how its patch changes with the view.
#pragma once

#include <opencv2/core.hpp>

#include "slam/camera.h"
#include "slam/landmark.h"

namespace slam {

/// One step of a local search for the normal of a locally planar patch (Molton, Davison, Reid 2004, follow
/// the gradient instead): returns the landmark's tilt, or the neighbouring tilt whose template correlates
/// better with the image at `pixel`, where the landmark was found. While the view has hardly changed, all
/// tilts correlate alike and the tilt stays.
Eigen::Vector2d refined_tilt(const cv::Mat& image, const Landmark& landmark, const Eigen::Vector2d& pixel,
                             const Camera& camera, const State& state);

}  // namespace slam
