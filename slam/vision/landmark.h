// A landmark: its parameters in the state, which give its position, and its appearance when first seen.
#pragma once

#include "slam/kalman.h"
#include "slam/vision/patch.h"

namespace slam {

/// Civera, Davison, Montiel 2008: the parameters y = (c₀, θ, φ, ρ), an anchor, a bearing and an inverse
/// depth, describe the point c₀ + m(θ, φ)/ρ at any depth up to infinity. Unlike in their paper, the angles
/// refer to world axes with z up, and m = (cos φ cos θ, cos φ sin θ, sin φ), because a level camera never
/// sees the pole.
struct InverseDepth {
  static constexpr int kSize = 6;
};

/// A measured inverse depth 1/z, z along the optical axis.
struct MeasuredDepth {
  double inverse_1_m, sigma_1_m;
};

/// The readings of an aligned depth camera at the time of an image.
struct DepthImage {
  cv::Mat mm = {};  ///< CV_16UC1, 0: none; empty without a reading
  double sigma_inverse_1_m = 0;

  /// The depth of the patch around a pixel: the mean of its inverse depths, which are linear in the pixel on
  /// a plane. Returns nothing if a reading is missing or the patch is not planar, for example across the edge
  /// of an object. sigma_1_m is the standard deviation of one reading, because neighbors share errors, but at
  /// least the error of rounding to 1 mm.
  std::optional<MeasuredDepth> at(const Eigen::Vector2i& pixel) const;
};

/// A new landmark on the ray of a pixel with standard deviation sigma_px. displacement: the pixel's
/// displacement by the lens, px. The inverse depth is the measured one, ρ = cos α / z with the angle α
/// between the optical axis and the ray, or else the one in the options.
LandmarkInitialization initialize_inverse_depth(const RobotVector& x, const Ray& ray, double sigma_px,
                                                const Eigen::Vector2d& displacement,
                                                const Options::Depth& options,
                                                const std::optional<MeasuredDepth>& measured = {});

/// The linearity index L_d = 4 σ_d |cos α| / d₁ of Civera, Davison, Montiel 2007. Below about 0.1, a point
/// with Gaussian uncertainty describes the landmark equally well. sigma_rho: standard deviation of ρ; r:
/// position of the camera.
double linearity_index(const Vector6d& y, double sigma_rho, const Eigen::Vector3d& r);

/// Davison 2003, and Fig. 3 of the paper: the parameters y = (c₀, ĥ), in m and as a unit vector in W,
/// describe the landmark's line c₀ + λĥ, λ > 0. Particles represent its depth λ.
struct SemiInfiniteLine {
  static constexpr int kSize = 6;
  std::vector<DepthParticle> particles;
  int attempts = 0;  ///< searches for it
};

/// Mean and standard deviation of the depth, m.
struct DepthMoments {
  double mean_m, sigma_m;
};

/// Equal probability for all depths from nearest to furthest.
std::vector<DepthParticle> uniform_prior(const Options::Depth::Particles& options);

/// Returns the mean and standard deviation of the depth, weighted by probability.
DepthMoments depth_moments(const std::vector<DepthParticle>& particles);

/// Multiplies each probability by its likelihood, removes particles below 0.05/N and normalizes the sum to 1
/// (Davison et al. 2007). No particle is left if all likelihoods are 0.
void reweight(std::vector<DepthParticle>& particles, const std::vector<double>& likelihoods);

/// The parameters of a new line along the ray of a pixel with standard deviation sigma_px.
LandmarkInitialization initialize_line(const RobotVector& x, const Ray& ray, double sigma_px);

/// A point in space: 3 parameters, p_W in m.
struct Point {
  static constexpr int kSize = 3;
};

using LandmarkKind = std::variant<Point, InverseDepth, SemiInfiniteLine>;

struct Landmark {
  static constexpr int kMostMisses = 5;  ///< misses after which a landmark is set aside
  static constexpr double kSlides = 3;   ///< standard deviations

  int id = 0;
  LandmarkKind kind = InverseDepth{};
  int at = 0;  ///< first index of its parameters in the state
  SourcePatch patch;
  Eigen::Isometry3d X_WC_first =
      Eigen::Isometry3d::Identity();                      ///< estimated camera pose when it was first seen
  Eigen::Vector2d pixel_first = Eigen::Vector2d::Zero();  ///< its first pixel
  Stamp initialized{0};
  Eigen::Vector2d tilt = Eigen::Vector2d::Zero();  ///< tilt of its surface; see surface_normal()
  Eigen::Vector3d p_WC_inflated =
      Eigen::Vector3d::Zero();      ///< camera position when its covariance was last inflated for the view, m
  int attempts = 0, successes = 0;  ///< searches for it, and accepted matches
  int last_session = 1;             ///< number of the session that last found it
  int misses = 0;                   ///< number of failed searches from one view since its last accepted match
  Eigen::Vector3d p_WC_missed = Eigen::Vector3d::Zero();  ///< camera position at the first of them, m
  Stamp last_search{0};                                   ///< time of its last search or its initialization
  Stamp last_visible{0};  ///< when it was last predicted to be visible, or initialized
  /// Sum of its innovations in both directions, in standard deviations, and their number; older ones weigh
  /// less.
  Eigen::Vector2d drift = Eigen::Vector2d::Zero();
  double drift_count = 0;
  bool on_trial =
      false;  ///< perhaps on something that moves with the camera; not used until it moved as predicted

  int size() const {
    return std::visit([](const auto& k) { return std::decay_t<decltype(k)>::kSize; }, kind);
  }
  Parameters parameters(const State& state) const { return state.storage_x.segment(at, size()); }
  /// True if its matches deviate persistently from their predicted pixels, as where edges at different
  /// distances cross: such a corner slides along both when the camera moves.
  bool slides() const { return drift_count >= 20 && drift.squaredNorm() > kSlides * kSlides * drift_count; }
  /// True if the current view differs from the view of the first of its misses.
  bool is_seen_anew(const State& state) const;
  /// True if searches for it from this view have failed repeatedly, so that others have priority.
  bool is_set_aside(const State& state) const { return misses >= kMostMisses && !is_seen_anew(state); }
};

/// The derivative of three values with respect to a landmark's parameters.
using PositionJacobian = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 6>;

/// The vector from the camera to a landmark in C, of any positive length, and its derivatives.
struct Direction {
  Eigen::Vector3d h_C;
  Eigen::Matrix3d J_r;   ///< ∂h/∂r
  Matrix34d J_q;         ///< ∂h/∂q
  PositionJacobian J_y;  ///< ∂h/∂y, y being the landmark's parameters
};

/// h_C = R(q)ᵀ(y − r) for a point, R(q)ᵀ(ρ(c₀ − r) + m) for inverse depth, and R(q)ᵀ(c₀ + λ̄ĥ − r) for a line
/// of mean depth λ̄. y: the landmark's parameters.
Direction direction(const LandmarkKind& kind, const Parameters& y, const Eigen::Vector3d& r,
                    const Eigen::Vector4d& q);

/// The position of the landmark, m in W, at most 100 m from the camera that first saw it.
Eigen::Vector3d position(const LandmarkKind& kind, const Parameters& y);
/// ∂position/∂y.
PositionJacobian position_jacobian(const LandmarkKind& kind, const Parameters& y);
/// The covariance of the position, m² in W.
Eigen::Matrix3d position_covariance(const State& state, const Landmark& landmark);

}  // namespace slam
