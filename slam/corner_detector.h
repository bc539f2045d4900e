// Where a new landmark is worth beginning: the strongest Shi-Tomasi corner of a part of the image.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

namespace slam {

/// A corner and the smaller eigenvalue of Σ[gx² gxgy; gxgy gy²] over the 11x11 pixels around it (grey levels
/// squared).
struct Corner {
  Eigen::Vector2i pixel;
  double strength;
};

/// The strongest corner whose centre lies in `region` (Shi & Tomasi 1994; gradients are central differences,
/// halved). Pixels too close to the image's border for gradients are left out. Nothing where none is stronger
/// than `threshold`; 20 000 is MonoSLAM's.
std::optional<Corner> strongest_corner(const cv::Mat& image, const cv::Rect& region, double threshold);

}  // namespace slam
