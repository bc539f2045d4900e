// Which way the surface of a landmark is turned, learned from how its patch changes with the view.
#pragma once

#include <opencv2/core.hpp>

#include "slam/camera.h"
#include "slam/landmark.h"

namespace slam {

/// The landmark's tilt, or the one a step away from it whose template correlates better with the image at
/// `pixel`, where the landmark was found: a search for the normal of a locally planar patch, one step a call
/// (after Molton, Davison, Reid 2004, who follow the gradient). While the view has hardly changed all tilts
/// fit alike, and it stays.
Eigen::Vector2d better_tilt(const cv::Mat& image, const Landmark& landmark, const Eigen::Vector2d& pixel,
                            const Camera& camera, const State& state);

}  // namespace slam
