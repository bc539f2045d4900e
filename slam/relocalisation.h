// A lost camera found again: the map's landmarks looked for in the whole image, and the pose that explains
// them.
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "slam/camera.h"
#include "slam/filter.h"
#include "slam/landmark.h"
#include "slam/state.h"

namespace slam {

/// A landmark's place in space and the unit vector in C along which it is thought to be seen.
struct Bearing {
  Eigen::Vector3d p_W, direction_C;
};

/// The camera poses whose tilt is that of R_WC and that see both landmarks along their bearings, at most two:
/// R_z(ψ)R_WC, with ψ from the two lines of sight having to meet, (p₂ − p₁)·R_z(ψ)(d₁ × d₂) = 0.
std::vector<Eigen::Isometry3d> poses_from_two(const Bearing& first, const Bearing& second,
                                              const Eigen::Matrix3d& R_WC);

/// Where the camera is: pose, its covariance (as Estimate's) and how many landmarks say so.
struct Relocation {
  Eigen::Isometry3d X_WC;
  Matrix6d covariance;
  int agreeing;
};

/// Looks for well-known landmarks all over the image and tries the pose of every two of them; the tilt is the
/// state's, which the gyro and gravity keep. Nothing where fewer than 6 agree on a pose within 4 px.
std::optional<Relocation> relocalise(const cv::Mat& image, const std::vector<Landmark>& landmarks,
                                     const State& state, const Camera& camera, double sigma_px);

}  // namespace slam
