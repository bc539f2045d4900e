// The extended Kalman filter: the only writer of the state's mean and covariance.
#pragma once

#include <utility>

#include "slam/smoother.h"

namespace slam {

/// The parameters of a new landmark, y = g(robot, z): the mean y, ∂y/∂robot, and the covariance J R Jᵀ due
/// to the noise of the measurement z.
struct LandmarkInitialization {
  Vector6d y;
  Eigen::Matrix<double, 6, kRobot> J_robot;
  Matrix6d noise;
  Vector6d distortion = Vector6d::Zero();  ///< ∂y/∂δ, δ being the relative error of the lens distortion
};

/// The robot's part of State::null_yaw at the mean x.
RobotVector robot_null_yaw(const RobotVector& x);

class Kalman {
 public:
  /// match_biases: the number of places for match biases (MatchBiases) in the state.
  Kalman(const RobotState& initial, bool observability_constrained, int match_biases = 0);

  const State& state() const { return state_; }
  /// Records all later changes of the state for a smoother, which must outlive this object.
  void record(Smoother& smoother) { smoother_ = &smoother; }
  /// x ← f and P ← FPFᵀ + Q for the robot's part; its correlations with the landmarks change accordingly.
  void predict(const RobotVector& f, const RobotMatrix& F, const RobotMatrix& Q);
  /// Removes the part of H that observes the heading of the whole world, which is unobservable
  /// (Hesch et al. 2013: H' = H − HN(NᵀN)⁻¹Nᵀ). Does nothing when the constraint is switched off.
  void constrain(Measurement& measurement) const;
  /// P ← P − WWᵀ with W = PHᵀL⁻ᵀ and S = LLᵀ; then the quaternion is normalized. Returns false, and changes
  /// nothing, if S is not positive definite or the innovation is not finite.
  bool update(const StackedMeasurement& stacked);
  /// The whitening of the last update's innovation.
  const Whitening& whitening() const { return whitening_; }
  /// Later updates leave the parameters in [begin, end) and their covariance as they are, but reckon
  /// with their errors (Schmidt 1966). An empty range ends this.
  void consider(int begin, int end) { considered_ = {begin, end}; }
  bool considers(int at) const { return considered_.first <= at && at < considered_.second; }
  /// Adds evidence of a systematic error from a measurement that enters no update.
  void add_evidence(int error, const SystematicEvidence& evidence) {
    SystematicEvidence& sum = evidence_[static_cast<std::size_t>(error)];
    sum.score += evidence.score, sum.information += evidence.information;
  }
  /// Returns the evidence of systematic errors since the last call, both added and from updates.
  Evidence release_evidence() { return std::exchange(evidence_, {}); }
  /// Adds a landmark at the end of the state; returns the first index of its parameters.
  int append(const LandmarkInitialization& landmark);
  /// Adds a point known with standard deviation sigma_m, uncorrelated with the rest of the state; returns its
  /// first index.
  int append_point(const Eigen::Vector3d& p_W, double sigma_m);
  /// Adds landmarks that are independent of the rest of the state: their parameters x, the covariance P of
  /// all of them and their part of State::null_yaw. Returns the first index.
  int append_map(const Eigen::VectorXd& x, const Eigen::MatrixXd& P, const Eigen::VectorXd& null_yaw);
  /// Replaces the `count` parameters starting at `at` with at most as many new ones: y = g(parameters), J =
  /// ∂g/∂parameters.
  void replace(int at, int count, const Eigen::Ref<const Eigen::VectorXd>& y,
               const Eigen::Ref<const Eigen::MatrixXd>& J);
  /// Removes `count` parameters from the state.
  void erase(int at, int count);
  /// Predicts the match bias e, the two parameters starting at `at`: e ← decay·e plus noise of this variance.
  /// With decay 0, e becomes independent of all other parameters.
  void predict_match_bias(int at, double decay, double variance);
  /// Adds Q to the covariance of the three parameters starting at `at`.
  void inflate(int at, const Eigen::Matrix3d& Q);
  /// Replaces the robot's mean and covariance and makes it independent of all landmarks.
  void reset_robot(const RobotState& robot);
  /// True if everything is finite, no variance is negative, and the covariance of the first `count`
  /// parameters, scaled to unit variances, is positive semidefinite to 1e-9.
  bool is_valid(int count);

 private:
  void reserve(int size);
  void normalize_orientation();
  void subtract_square(const Eigen::Ref<const Eigen::MatrixXd>& W);
  void update_sensitivity(const StackedMeasurement& stacked);

  State state_;
  bool observability_constrained_;
  std::pair<int, int> considered_{0, 0};
  Smoother* smoother_ = nullptr;
  Whitening whitening_;
  Evidence evidence_{};
  Sensitivity sensitivity_;                     // work space: whitened
  Eigen::MatrixXd W_, robot_columns_, scaled_;  // work space
};

}  // namespace slam
