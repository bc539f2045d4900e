// Corners for new landmarks: the strongest Shi-Tomasi corner of a region, and its choice.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <random>
#include <vector>

#include "slam/options.h"

namespace slam {

/// A corner and the smaller eigenvalue of Σ[gx² gxgy; gxgy gy²] over the 11x11 pixels around it (gray levels
/// squared).
struct Corner {
  Eigen::Vector2i pixel;
  double strength;
};

/// The strongest corner in `region` (Shi & Tomasi 1994); gradients are central differences. Pixels too close
/// to the image's border for their gradients are left out. Nothing if no corner is stronger than `threshold`;
/// MonoSLAM uses 20 000.
std::optional<Corner> strongest_corner(const cv::Mat& image, const cv::Rect& region, double threshold);

/// The strongest corner in a box at a random place, which leaves room for the patch. Nothing if the box
/// contains an occupied pixel, or its corner is too weak or too close to an occupied pixel.
std::optional<Eigen::Vector2i> propose_corner(const cv::Mat& image,
                                              const std::vector<Eigen::Vector2d>& occupied,
                                              const Options::Vision& options, std::mt19937_64& random);

/// The sub-pixel corner near the predicted pixel by its gradients. Nothing if it lies outside the 3-sigma
/// ellipse of the innovation covariance S, px².
std::optional<Eigen::Vector2d> corner_near(const cv::Mat& image, const Eigen::Vector2d& predicted,
                                           const Eigen::Matrix2d& S);

}  // namespace slam
