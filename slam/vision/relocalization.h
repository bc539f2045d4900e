// Relocalization: landmarks of the map are searched for in the whole image, and the camera pose is found from
// two of them and confirmed by others.
#pragma once

#include <numbers>

#include "slam/vision/landmark.h"

namespace slam {

/// Minimum number of landmarks of the map that must confirm the pose of a lost filter.
inline constexpr std::size_t kLeastRecognized = 6;

/// The position of a landmark and the unit vector in C toward its possible match.
struct BearingObservation {
  Eigen::Vector3d p_W, direction_C;
};

/// The camera poses R_z(ψ)R_WC that see both landmarks along their bearings; at most two. The tilt is taken
/// from R_WC; ψ follows from the condition that both rays meet in the camera, (p₂ − p₁)·R_z(ψ)(d₁ × d₂) = 0.
std::vector<Eigen::Isometry3d> poses_from_two(const BearingObservation& first,
                                              const BearingObservation& second, const Eigen::Matrix3d& R_WC);

/// Searches the image for the landmarks that were first seen in about this heading, with their appearance at
/// that time, and tries the poses implied by each pair of them. The tilt, and roughly the height, are taken
/// from the state, in which gyro, gravity and plan maintain them. turn: about the vertical, relative to the
/// state's orientation. A pose is accepted if it is clearly the best and at least half of the landmarks that
/// it predicts in view are found there, and at least kLeastRecognized of them. The work is bounded for any
/// size of the map. The time of the estimate remains 0.
std::optional<Estimate> relocalize(const cv::Mat& image, const std::vector<Landmark>& landmarks,
                                   const State& state, double turn, const Camera& camera, double sigma_px);

/// True if two poses are the same within their uncertainties.
bool agree(const Estimate& found, const Estimate& predicted);

/// True if two cameras see the same from about the same place: poses further apart contradict each other.
bool is_same_view(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);

/// The headings to search, one per image: all around, starting with the most likely one.
class Headings {
 public:
  static constexpr int kCount = 8;
  double next();
  /// Begins with the turn of a pose that was found.
  void begin_with(double turn) { first_ = turn, searched_ = 0; }

 private:
  static constexpr double kStep = 2 * std::numbers::pi / kCount;  // half of a camera's field of view
  double first_ = 0;
  int searched_ = 0;
};

/// Confirms poses found in the images of a lost filter. Landmarks that move with the camera, for example on
/// something that covers the view, would otherwise be recognized too.
class RelocalizationConfirmer {
 public:
  /// Adds a pose that was found, and the filter's prediction. Returns true if the two agree within their
  /// uncertainties, or if the poses found over the last second or two have moved as predicted. The two
  /// motions may differ by up to half of the larger, because gyro or plan may have caused the loss. Without a
  /// plan, only rotations are compared.
  bool confirms(const Estimate& found, const Estimate& predicted, bool plan_is_known) {
    return agree(found, predicted) || moves_alike(found, predicted, plan_is_known);
  }
  /// Does the same, but only for the motion.
  bool moves_alike(const Estimate& found, const Estimate& predicted, bool plan_is_known);
  void clear() { *this = {}; }

 private:
  struct Poses {
    Estimate found, predicted;
  };
  std::optional<Poses> first_;  // the poses to be confirmed
};

/// The robot's state after relocalization: the found pose, velocities as uncertain as a walking robot's,
/// and everything else unchanged.
RobotState relocalized_state(const Estimate& found, const State& before);

}  // namespace slam
