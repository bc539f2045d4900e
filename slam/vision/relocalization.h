// Relocalization: landmarks of the map are searched for in the whole image, and the camera pose is found from
// two of them and confirmed by others.
#pragma once

#include "slam/vision/landmark.h"

namespace slam {

/// Landmarks of the map that confirm the pose of a lost filter.
inline constexpr std::size_t kLeastRecognized = 6;

/// The position of a landmark and the unit vector in C toward its possible match.
struct BearingObservation {
  Eigen::Vector3d p_W, direction_C;
};

/// The camera poses R_z(ψ)R_WC that see both landmarks along their bearings; at most two. The tilt is that of
/// R_WC; ψ follows from the condition that both rays meet in the camera, (p₂ − p₁)·R_z(ψ)(d₁ × d₂) = 0.
std::vector<Eigen::Isometry3d> poses_from_two(const BearingObservation& first,
                                              const BearingObservation& second, const Eigen::Matrix3d& R_WC);

/// Searches for well-known landmarks in the whole image and tries the poses of every two of them; the tilt is
/// that of the state, which gyro and gravity maintain. Nothing if fewer than kLeastRecognized landmarks agree
/// on a pose within 4 px. The time of the estimate is left 0.
std::optional<Estimate> relocalize(const cv::Mat& image, const std::vector<Landmark>& landmarks,
                                   const State& state, const Camera& camera, double sigma_px);

/// Confirms poses found in the images of a lost filter. Landmarks that move with the camera, for example on
/// something that covers the view, would otherwise be recognized too.
class RelocalizationConfirmer {
 public:
  /// True if the image at t is to be searched: five a second, because a search takes longer than a frame.
  bool is_due(Stamp t);
  /// Adds a pose found and the filter's prediction. It is confirmed if both agree within their
  /// uncertainties, or if the poses found over the last second or two have moved as predicted: up to half the
  /// motion, because gyro or plan may have caused the loss. Without a plan, only rotations are compared.
  bool confirms(const Estimate& found, const Estimate& predicted, bool plan_is_known);
  void clear() { *this = {}; }

 private:
  struct Poses {
    Estimate found, predicted;
  };
  std::optional<Stamp> searched_;
  std::optional<Poses> first_;  // that is to be confirmed
};

/// The robot's state after relocalization: the pose found, velocities as uncertain as those of a walking
/// robot, and everything else as it was in the state before.
RobotState relocalized_state(const Estimate& found, const State& before);

}  // namespace slam
