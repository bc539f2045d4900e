// Landmarks against the true room: early ones that were found again (loop closure), and the errors of the
// map.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <vector>

#include "sim/score/surfaces.h"
#include "sim/score/trajectory.h"

namespace sim::score {

/// The pixel of a landmark in one image.
struct StampedPixel {
  Stamp t{0};
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

/// A landmark from its initialization on.
struct LandmarkHistory {
  int id = 0;
  StampedPixel first_seen;
  std::vector<StampedPixel> accepted;  ///< matches that entered an update, in order of time
};

/// The true camera.
struct TrueCamera {
  /// The pixel of a point in W; nothing if it is behind the camera or outside the image.
  std::function<std::optional<Eigen::Vector2d>(const Eigen::Isometry3d& X_WC, const Eigen::Vector3d& p_W)>
      project;
  /// The unit vector in C along which a pixel looks.
  std::function<Eigen::Vector3d(const Eigen::Vector2d& pixel)> bearing;
};

/// Returns the pose of exactly that time, or null.
const TimedPose* pose_at(const Trajectory& trajectory, Stamp t);

/// Returns the first point of the room on the ray through a pixel, from the true camera at that time.
std::optional<Eigen::Vector3d> surface_point(const StampedPixel& seen, const Trajectory& truth_X_WC,
                                             const std::vector<Surface>& surfaces, const TrueCamera& camera);

/// The times after a quarter and after three quarters of the plan's total turn.
struct TurnMarks {
  Stamp quarter{0}, three_quarters{0};
};

/// Returns nothing unless the plan turns by at least 350° about z from its first to its last pose, whole
/// turns counted.
std::optional<TurnMarks> turn_marks(const Trajectory& plan_waist);

/// An early landmark that was found again.
struct LoopLandmark {
  int id = 0;
  Stamp found{0};       ///< its first match that counts, anywhere on the path
  bool closes = false;  ///< also matched after three quarters of the turn
};

/// Returns the landmarks that were found again, in the order of `landmarks`. Each was first seen in the first
/// quarter of the turn. Its surface_point() was then outside the camera's field of view (occlusion does not
/// matter) in all frames over at least 5 s in one stretch, and a later match was accepted within 3 px of its
/// true projection. truth_X_WC: at the frames.
std::vector<LoopLandmark> loop_landmarks(const std::vector<LandmarkHistory>& landmarks,
                                         const TurnMarks& marks, const Trajectory& truth_X_WC,
                                         const std::vector<Surface>& surfaces, const TrueCamera& camera);

/// A landmark of the filter's final map.
struct MappedPoint {
  int id = 0;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();         ///< m
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m², axes W
};

/// The distance of a landmark from its surface_point().
struct LandmarkError {
  int id = 0;
  double distance = 0;         ///< m
  std::optional<double> nees;  ///< 3 is expected; absent if the covariance is not positive definite
  /// The least NEES over the surfaces that the template shows: against the point of the ray at the distance
  /// of each surface nearest to the first pixel. Across the edge of a near surface the landmark may be on
  /// either.
  std::optional<double> nees_of_template;
};

/// Returns the errors of the landmarks with a history and a surface point. template_half_px: a template has
/// 2 template_half_px + 1 rows and columns around the first pixel.
std::vector<LandmarkError> landmark_errors(const std::vector<MappedPoint>& map,
                                           const std::vector<LandmarkHistory>& histories,
                                           const Trajectory& truth_X_WC, const std::vector<Surface>& surfaces,
                                           const TrueCamera& camera, int template_half_px = 0);

}  // namespace sim::score
