// Figures over time of a run in the view: errors, consistency, landmarks, slip and balance.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "sim/pages/figure.h"
#include "sim/pages/frame.h"

namespace sim::view {

using pages::FootPlace;
using pages::Frame;

/// A force on a foot: position of its sole point (m, W), its yaw, force and torque in its axes.
struct SoleForce {
  Eigen::Vector3d place;  ///< x, y (m), yaw (rad)
  Eigen::Vector3d force, torque;
};

/// The zero-moment point of the ground forces on both soles, assumed level; empty if they carry less than 20
/// N.
std::optional<Eigen::Vector2d> zero_moment_point(const std::array<SoleForce, 2>& soles);

/// Collects the values of frames in order of time.
class Strips {
 public:
  Strips();
  /// Also completes the frame: where each foot was set down, and the support polygon.
  void add(Frame& frame);
  const std::vector<pages::Figure>& figures() const { return figures_; }

 private:
  void follow_feet(Frame& frame);

  std::vector<pages::Figure> figures_;
  std::array<std::optional<Eigen::Vector3d>, 2> landed_;
};

std::string strips_html(const std::vector<pages::Figure>& figures);

}  // namespace sim::view
