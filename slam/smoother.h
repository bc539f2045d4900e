// Fixed-interval smoothing: the poses of a run, each estimated from the observations of the whole run.
#pragma once

#include <cstdio>
#include <initializer_list>
#include <memory>
#include <optional>
#include <vector>

#include "slam/measurement.h"

namespace slam {

struct SmoothedPose {
  Stamp t{0};
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
};

/// Records the steps of a Kalman filter in a temporary file and smooths its poses from the last to the first,
/// in the form of Bryson & Frazier (Bierman 1977, "Factorization Methods for Discrete Sequential Estimation",
/// X.5): x_smoothed = x + Pλ after each step, λ = 0 after the last one, and back through each change,
///     e⁺ = Je + noise:  λ ← Jᵀλ         update:  λ ← λ + HᵀL⁻ᵀ(L⁻¹ν − Wᵀλ), W = PHᵀL⁻ᵀ, S = LLᵀ.
/// λ includes all landmarks and biases, so this is the exact smoother of the filter's linearized models. It
/// inverts no covariance, and only poses stay in memory.
class Smoother {
 public:
  Smoother();

  // The changes that Kalman makes to the state, in their order.
  /// The J.cols() parameters starting at `at` became J.rows() others, with Jacobian J; later parameters
  /// moved.
  void change(int at, const Eigen::Ref<const Eigen::MatrixXd>& J);
  /// J.rows() parameters were added at the end, `at`. J: their derivative with respect to the first J.cols()
  /// ones.
  void append(int at, const Eigen::Ref<const Eigen::MatrixXd>& J);
  void update(const StackedMeasurement& stacked, const Whitening& whitening,
              const Eigen::Ref<const Eigen::MatrixXd>& W);
  /// Ends a step: the pose of `state` will be smoothed.
  void end_step(Stamp t, const State& state);

  /// Returns the smoothed poses of all steps, in order, or nothing if the temporary file failed. Call it only
  /// once.
  std::optional<std::vector<SmoothedPose>> smoothed();

 private:
  struct Pose {
    Stamp t{0};
    Eigen::Matrix<double, 7, 1> x;   // position and orientation
    std::size_t at = 0, values = 0;  // start and number of its step's values in the file
  };
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  void put(const Eigen::Ref<const Eigen::MatrixXd>& M);
  void put(std::initializer_list<Eigen::Index> numbers);

  std::unique_ptr<std::FILE, Close> file_;
  bool written_;
  int size_ = 0;             // size of the state after the last step
  std::vector<float> step_;  // the changes since the end of the last step
  std::vector<Pose> poses_;
};

}  // namespace slam
