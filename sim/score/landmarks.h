// Landmarks against the true room: early ones that were found again (loop closure), and the errors of the
// map.
#pragma once

#include <optional>
#include <vector>

#include "sim/score/run.h"

namespace sim::score {

/// The times after a quarter and after three quarters of the plan's total turn.
struct TurnMarks {
  Stamp quarter{0}, three_quarters{0};
};

/// Returns nothing unless the plan turns by at least 350° about z from its first to its last pose, whole
/// turns counted.
std::optional<TurnMarks> turn_marks(const Trajectory& plan_waist);

/// Returns the landmarks that were found again, in their order. Each was first seen in the first quarter of
/// the turn. Its surface point, the first point of the room on the ray through its first pixel from the true
/// camera, was then outside the camera's field of view (occlusion does not matter) in all frames over at
/// least 5 s in one stretch, and a later match was accepted within 3 px of its true projection.
std::vector<LoopLandmark> loop_landmarks(const Run& run, const TurnMarks& marks);

/// The distance of a landmark from its surface point, see loop_landmarks().
struct LandmarkError {
  int id = 0;
  double distance = 0;         ///< m
  std::optional<double> nees;  ///< 3 is expected; absent if the covariance is not positive definite
  /// The least NEES over the surfaces that the template shows: against the point of the ray at the distance
  /// of each surface nearest to the first pixel. Across the edge of a near surface the landmark may be on
  /// either.
  std::optional<double> nees_of_template;
};

/// Returns the errors of the map's landmarks with a history and a surface point. template_half_px: a template
/// has 2 template_half_px + 1 rows and columns around the first pixel.
std::vector<LandmarkError> landmark_errors(const Run& run, int template_half_px = 0);

}  // namespace sim::score
