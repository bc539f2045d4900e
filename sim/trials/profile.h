// How well the recordings determine a parameter: the profile likelihood along it, with a confidence interval.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "sim/trials/study.h"

namespace sim::trials {

/// A quadratic c + gᵀx + ½ xᵀHx, fitted to values at points by least squares.
struct Quadratic {
  double constant = 0;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;
};
/// points: one row each. Returns nullopt unless the points determine all coefficients.
std::optional<Quadratic> fit_quadratic(const Eigen::MatrixXd& points, const Eigen::VectorXd& values);

/// The direction that keeps the quadratic least as parameter i moves by 1: dx = −H_oo⁻¹ H_oi, 1 at i. Only i
/// moves if H is not positive definite.
Eigen::VectorXd following(const Eigen::MatrixXd& hessian, int i);

/// The loss along one parameter, the others at their best.
struct Profile {
  std::string key;
  std::vector<double> at;           ///< values of the parameter, rising
  Eigen::MatrixXd values;           ///< losses: a row for each run, a column for each value
  std::vector<double> rises;        ///< of the mean loss over runs above its least
  double threshold = 0;             ///< of the rise at the ends of the 95 % interval
  std::optional<double> low, high;  ///< of the interval; absent if it does not end within the range
  bool identifiable() const { return low && high; }
};

/// The rise of the mean over R runs at the ends of a 95 % interval: λ F(0.95; 1, R − 1) / 2R, λ = variance of
/// the runs' slopes / curvature. values: a row for each run, a column for each coordinate. Runs are
/// independent, their frames are not (White 1982, Chandler & Bate 2007). Returns nullopt for fewer than two
/// runs or no curvature.
std::optional<double> rise_at_95(const std::vector<double>& coordinates, const Eigen::MatrixXd& values,
                                 double best_coordinate);

/// Sets low and high where `rises` first exceed the threshold on each side of the least, by linear
/// interpolation.
void find_interval(Profile& profile);

/// The profiles of all parameters about the best candidate of the study.
std::vector<Profile> profiles(Study& study);

}  // namespace sim::trials
