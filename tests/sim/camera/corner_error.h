// The accuracy of corners in the head camera's frames: where they are found again against where the true
// surfaces put them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/camera/head_camera.h"
#include "sim/score/surfaces.h"

namespace sim::camera {

/// Errors of corners found again. px; all zero when there were none.
struct CornerError {
  int corners = 0;
  double rms_px = 0, median_px = 0;
  Eigen::Vector2d mean_px{0, 0};
};

/// Puts the robot on the tangent circle (0.75 m about (1, 0.25)) after a turn by `yaw`.
void stand_on_circle(mjData& data, double yaw);

/// Strong corners of a frame are searched in another, a little further on the circle, by correlation of 11x11
/// patches, refined by a parabola, and compared with where the room's true surface puts them through the
/// lens. Patches across the edge of something nearer are left out, as are those that correlate below 0.9.
CornerError corner_error(HeadCamera& camera, int headings, double turn_rad);

}  // namespace sim::camera
