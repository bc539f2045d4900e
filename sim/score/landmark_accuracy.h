// Errors of the map's landmarks against the surfaces of the room.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/score/loop_closure.h"

namespace sim::score {

/// A landmark of the filter's final map.
struct MappedPoint {
  int id = 0;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();         ///< m
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m², axes W
};

/// A landmark's error against the surface point at which the ray through its first pixel, from the true
/// camera, meets the room.
struct LandmarkError {
  int id = 0;
  double distance = 0;         ///< m
  std::optional<double> nees;  ///< 3 is expected; nothing when the covariance is not positive definite
  /// The least NEES against the points of that ray that are as far away as the surfaces which the template
  /// shows, each taken where it is nearest to the first pixel: across the edge of a near surface the
  /// template shows two surfaces, and the landmark may be a point of either.
  std::optional<double> nees_of_template;
};

/// Of the landmarks that have a history and a surface point; the others are left out. template_half_px: a
/// template has 2 template_half_px + 1 rows and columns around the first pixel.
std::vector<LandmarkError> landmark_errors(const std::vector<MappedPoint>& map,
                                           const std::vector<LandmarkHistory>& histories,
                                           const Trajectory& truth_X_WC, const std::vector<Surface>& surfaces,
                                           const TrueCamera& camera, int template_half_px = 0);

}  // namespace sim::score
