// A landmark: how its parameters in the state give its position, and its appearance when first seen.
#pragma once

#include <Eigen/Geometry>
#include <variant>

#include "slam/depth_particles.h"
#include "slam/inverse_depth.h"
#include "slam/observation.h"
#include "slam/patch.h"
#include "slam/state.h"

namespace slam {

/// A point in space: 3 parameters, p_W in m.
struct Point {
  static constexpr int kSize = 3;
};

using LandmarkKind = std::variant<Point, InverseDepth, SemiInfiniteLine>;

struct Landmark {
  int id = 0;
  LandmarkKind kind = InverseDepth{};
  int at = 0;  ///< first index of its parameters in the state
  SourcePatch patch;
  Eigen::Isometry3d X_WC_first =
      Eigen::Isometry3d::Identity();                      ///< estimated camera pose when it was first seen
  Eigen::Vector2d pixel_first = Eigen::Vector2d::Zero();  ///< where it was first seen, px
  Stamp initialised{0};
  Eigen::Vector2d tilt = Eigen::Vector2d::Zero();  ///< of its surface; see surface_normal
  Eigen::Vector3d p_WC_inflated =
      Eigen::Vector3d::Zero();      ///< camera position when its covariance was last inflated for the view, m
  int attempts = 0, successes = 0;  ///< searches for it, and those whose match was accepted
  Stamp last_visible{0};            ///< when it was last predicted to be visible, or initialised

  int size() const {
    return std::visit([](const auto& k) { return std::decay_t<decltype(k)>::kSize; }, kind);
  }
  Parameters parameters(const State& state) const { return state.storage_x.segment(at, size()); }
};

/// The vector from the camera to a landmark in C, of any positive length, and its derivatives.
struct Direction {
  Eigen::Vector3d h_C;
  Eigen::Matrix3d J_r;                                    ///< ∂h/∂r
  Matrix34d J_q;                                          ///< ∂h/∂q
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 6> J_y;  ///< ∂h/∂y, y being the landmark's parameters
};

/// h_C = R(q)ᵀ(y − r) for a point, R(q)ᵀ(ρ(c₀ − r) + m) for inverse depth, and R(q)ᵀ(c₀ + λ̄ĥ − r) for a line
/// of mean depth λ̄. y: the landmark's parameters.
Direction direction(const LandmarkKind& kind, const Parameters& y, const Eigen::Vector3d& r,
                    const Eigen::Vector4d& q);

/// The position of the landmark, m in W, at most 100 m from where it was first seen.
Eigen::Vector3d position(const LandmarkKind& kind, const Parameters& y);
/// ∂position/∂y.
Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 6> position_jacobian(const LandmarkKind& kind,
                                                                    const Parameters& y);
/// The covariance of the position, m² in W.
Eigen::Matrix3d position_covariance(const State& state, const Landmark& landmark);

}  // namespace slam
