// Loop closure: landmarks of the beginning that left the field of view and were found again where they truly
// are.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <vector>

#include "sim/score/surfaces.h"
#include "sim/score/trajectory.h"

namespace sim::score {

/// A landmark's place (px) in the image of a time.
struct StampedPixel {
  Stamp t{0};
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

/// A landmark from its initialisation on.
struct LandmarkHistory {
  int id = 0;
  StampedPixel begun;
  std::vector<StampedPixel> accepted;  ///< matches that entered an update, in order of time
};

/// The true camera.
struct TrueCamera {
  /// The pixel of a point in W; nothing when it is behind the camera or outside the image.
  std::function<std::optional<Eigen::Vector2d>(const Eigen::Isometry3d& X_WC, const Eigen::Vector3d& p_W)>
      project;
  /// The unit vector in C along which a pixel looks.
  std::function<Eigen::Vector3d(const Eigen::Vector2d& pixel)> bearing;
};

/// The pose of exactly that time; null if there is none.
const StampedPose* pose_at(const Trajectory& trajectory, Stamp t);

/// The point of the room at which the ray through a pixel, from the true camera at that time, first meets a
/// surface.
std::optional<Eigen::Vector3d> surface_point(const StampedPixel& seen, const Trajectory& truth_X_WC,
                                             const std::vector<Surface>& surfaces, const TrueCamera& camera);

/// When the planned waist has turned a quarter and three quarters of the plan's total turn.
struct TurnMarks {
  Stamp quarter{0}, three_quarters{0};
};

/// Nothing unless the plan turns by at least 350° about z from its first to its last pose, whole turns
/// counted.
std::optional<TurnMarks> turn_marks(const Trajectory& plan_waist);

/// The conditions for a landmark to count as found again.
struct LoopRule {
  Stamp out_of_view = std::chrono::seconds(5);
  double tolerance_px = 3;
};

/// An early landmark that was found again.
struct LoopLandmark {
  int id = 0;
  Stamp found{0};       ///< its first match that counts, wherever on the path
  bool closes = false;  ///< a match after three quarters of the turn counts, too
};

/// The landmarks that were found again, in the order of `landmarks`. Each was begun before the end of the
/// first quarter; the surface point at which the ray through its first pixel meets the room was, by truth,
/// out of the camera's field of view (what stands between does not matter) in all frames over at least 5 s in
/// one stretch; and after that stretch a match was accepted within 3 px of where truth puts the surface
/// point. truth_X_WC: at the frames.
std::vector<LoopLandmark> loop_landmarks(const std::vector<LandmarkHistory>& landmarks,
                                         const TurnMarks& marks, const Trajectory& truth_X_WC,
                                         const std::vector<Surface>& surfaces, const TrueCamera& camera,
                                         const LoopRule& rule = {});

}  // namespace sim::score
