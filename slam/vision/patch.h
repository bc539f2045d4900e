// The appearance of a landmark: the image around it when first seen, its 11x11 template for another view, and
// the search for it in an image.
#pragma once

#include <opencv2/core.hpp>

#include "slam/camera.h"

namespace slam {

inline constexpr int kPatchHalf = 5;  ///< px; templates are 11 x 11 as in MonoSLAM
inline constexpr int kPatchSide = 2 * kPatchHalf + 1;
inline constexpr int kSourceHalf = 12;  ///< px; half the size of the image kept for warping
inline constexpr int kSourceSide = 2 * kSourceHalf + 1;
inline constexpr double kFlatContrast =
    6;  ///< gray levels; a patch with a smaller standard deviation is not matched

/// The image around a landmark when first seen, row by row.
struct SourcePatch {
  std::array<float, kSourceSide * kSourceSide> gray{};
};

/// A template of zero mean and unit norm with its gradient per pixel, row by row.
struct Template {
  static constexpr int kPixels = kPatchSide * kPatchSide;
  Eigen::Matrix<float, kPixels, 1> gray;
  Eigen::Matrix<float, kPixels, 2> gradient;
};

/// The image around a pixel, which must lie at least kSourceHalf inside the image.
SourcePatch cut_patch(const cv::Mat& image, const Eigen::Vector2i& pixel);
/// The image around a sub-pixel position, interpolated.
SourcePatch cut_patch_between(const cv::Mat& image, const Eigen::Vector2d& pixel);

/// The unit normal in W of the surface at p_W. If the tilt is zero, it points toward the camera that first
/// saw the landmark. The tilt consists of the tangents of the normal's angles toward that camera's right and
/// down.
Eigen::Vector3d surface_normal(const Eigen::Isometry3d& X_WC_first, const Eigen::Vector3d& p_W,
                               const Eigen::Vector2d& tilt);

/// ∂pixel_first/∂pixel_now: the affine map from the surroundings of `pixel_now` to the surroundings of the
/// landmark's pixel in the first view, if the surface at p_W is a plane with that normal. Returns nothing if
/// the surface is seen too obliquely (more than 65°) or lies outside a view.
std::optional<Eigen::Matrix2d> view_change(const Camera& camera, const Eigen::Isometry3d& X_WC_first,
                                           const Eigen::Isometry3d& X_WC_now, const Eigen::Vector3d& p_W,
                                           const Eigen::Vector3d& normal_W, const Eigen::Vector2d& pixel_now);

/// The template of the patch under the view change A. Returns nothing if A reaches outside the patch or the
/// template is flat.
std::optional<Template> warp(const SourcePatch& patch, const Eigen::Matrix2d& A);

/// A match in an image: its place and the normalized cross-correlation there, in [-1, 1].
struct Match {
  Eigen::Vector2d pixel;
  double correlation;
};

/// Refines a match to sub-pixel accuracy by Gauss-Newton on the normalized gray values, which makes it
/// independent of gain and offset (Lucas & Kanade 1981). Returns nothing if the match moves by more than 1.5
/// px.
std::optional<Match> refine(const cv::Mat& image, const Template& patch, const Eigen::Vector2d& start);

/// Searches the ellipse νᵀS⁻¹ν < sigmas² around `center` (px), pixel by pixel, for the highest normalized
/// cross-correlation. The half-axes are limited to kLargestSearch, which bounds the cost. Returns nothing if
/// the patches of all its pixels are flat or reach outside the image.
std::optional<Match> search_ellipse(const cv::Mat& image, const Template& patch,
                                    const Eigen::Vector2d& center, const Eigen::Matrix2d& S, double sigmas);

inline constexpr int kLargestSearch = 40;  ///< px

/// The number of pixels in the box around that ellipse, which bounds the cost of a search.
int searched_pixels(const Eigen::Matrix2d& S, double sigmas);

}  // namespace slam
