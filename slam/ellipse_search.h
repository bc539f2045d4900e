// The best match of a template inside the ellipse in which its landmark must lie.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "slam/patch.h"

namespace slam {

/// Searches the ellipse νᵀS⁻¹ν < sigmas² around `centre` (px), pixel by pixel, for the highest normalised
/// cross-correlation. The half-axes are cut at kLargestSearch, so that the cost is bounded however uncertain
/// the landmark is. Nothing where the ellipse contains no pixel whose patch lies in the image and is not
/// flat.
std::optional<Match> search_ellipse(const cv::Mat& image, const Template& patch,
                                    const Eigen::Vector2d& centre, const Eigen::Matrix2d& S, double sigmas);

inline constexpr int kLargestSearch = 40;  ///< px

/// The number of pixels of the box around that ellipse, which is what a search costs at most.
int searched_pixels(const Eigen::Matrix2d& S, double sigmas);

}  // namespace slam
