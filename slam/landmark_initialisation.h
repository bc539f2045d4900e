// Landmark initialisation: a new landmark's parameters, covariance and appearance.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "slam/camera.h"
#include "slam/kalman.h"
#include "slam/landmark.h"
#include "slam/options.h"

namespace slam {

/// Adds a landmark seen at a pixel of the image to the state, by inverse depth or as a line with depth
/// particles. Nothing, and the state is unchanged, where the pixel has no ray. The id is left 0.
std::optional<Landmark> initialise_landmark(const cv::Mat& image, Stamp t, const Eigen::Vector2i& pixel,
                                            const Camera& camera, const Options& options, Kalman& kalman);

/// Adds a landmark of known position to the state, if the image shows a corner within 3 sigma of its
/// predicted pixel. Nothing, and the state is unchanged, if it does not. The id is left 0.
std::optional<Landmark> initialise_known_landmark(const cv::Mat& image, Stamp t, const Eigen::Vector3d& p_W,
                                                  const Camera& camera, const Options& options,
                                                  Kalman& kalman);

}  // namespace slam
