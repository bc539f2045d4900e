// What a landmark looks like: the image around its first sight, and the 11x11 template it makes for another
// view.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <opencv2/core.hpp>
#include <optional>

#include "slam/camera.h"

namespace slam {

inline constexpr int kPatchHalf = 5;  ///< px: templates are 11 x 11, as MonoSLAM's
inline constexpr int kPatchSide = 2 * kPatchHalf + 1;
inline constexpr int kSourceHalf = 12;  ///< px: what is kept around the first sight, for warping
inline constexpr int kSourceSide = 2 * kSourceHalf + 1;
inline constexpr double kFlatContrast = 6;  ///< grey levels: a patch with less σ matches nothing

/// The image around the first sight, row by row.
struct SourcePatch {
  std::array<float, kSourceSide * kSourceSide> grey{};
};

/// A template of zero mean and unit length, with its gradient per pixel; row by row.
struct Template {
  static constexpr int kPixels = kPatchSide * kPatchSide;
  Eigen::Matrix<float, kPixels, 1> grey;
  Eigen::Matrix<float, kPixels, 2> gradient;
};

/// Cuts the surroundings of a pixel out of an image; the pixel lies at least kSourceHalf inside.
SourcePatch cut_patch(const cv::Mat& image, const Eigen::Vector2i& pixel);
/// Likewise around a place between pixels, interpolated.
SourcePatch cut_patch_between(const cv::Mat& image, const Eigen::Vector2d& pixel);

/// Unit normal in W of the surface at p_W: towards the camera that saw it first, but for its tilt, the
/// tangents of the angles by which it is turned to that camera's right and down.
Eigen::Vector3d surface_normal(const Eigen::Isometry3d& X_WC_first, const Eigen::Vector3d& p_W,
                               const Eigen::Vector2d& tilt);

/// How pixels around `pixel_now` of the present view lie around the first sight's pixel, to first order, when
/// the surface at p_W is a plane of that normal: ∂pixel_first/∂pixel_now. Nothing where the surface is seen
/// too obliquely (over 65°) or outside a view.
std::optional<Eigen::Matrix2d> view_change(const Camera& camera, const Eigen::Isometry3d& X_WC_first,
                                           const Eigen::Isometry3d& X_WC_now, const Eigen::Vector3d& p_W,
                                           const Eigen::Vector3d& normal_W, const Eigen::Vector2d& pixel_now);

/// The template that the patch makes under the view change A; nothing where A reaches outside the patch or
/// the template is flat.
std::optional<Template> warp(const SourcePatch& patch, const Eigen::Matrix2d& A);

/// A match in an image: where, and the normalised cross-correlation there, in [-1, 1].
struct Match {
  Eigen::Vector2d pixel;
  double correlation;
};

/// Refines a match below the pixel by Gauss-Newton on the normalised grey values (Lucas & Kanade 1981, gain
/// and offset free). Nothing where it leaves the pixel it started from by more than 1.5 px.
std::optional<Match> refine(const cv::Mat& image, const Template& patch, const Eigen::Vector2d& start);

}  // namespace slam
