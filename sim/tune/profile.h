// How well the recordings tell a parameter: the likelihood along it, the others following, with a confidence
// interval.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/tune/study.h"

namespace sim::tune {

/// A quadratic through values at points: c + gᵀx + ½ xᵀHx, least squares.
struct Quadratic {
  double constant = 0;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;
};
/// points: one row each. Nothing where they do not tell all its coefficients.
std::optional<Quadratic> fit_quadratic(const Eigen::MatrixXd& points, const Eigen::VectorXd& values);

/// How the other parameters follow when parameter i moves by 1, so that the quadratic is least:
/// dx = −H_oo⁻¹ H_oi, 1 at i. Only i moves where H_oo is not positive definite.
Eigen::VectorXd following(const Eigen::MatrixXd& hessian, int i);

/// The value along one parameter. at: its values; values: of the objective, a row for each run.
struct Profile {
  std::string key;
  std::vector<double> at;
  Eigen::MatrixXd values;           ///< run x point
  std::vector<double> rises;        ///< of the mean over runs, over its least
  double threshold = 0;             ///< of the rise at the ends of the 95 % interval
  std::optional<double> low, high;  ///< of the interval; absent where it does not end within the range
  bool identifiable() const { return low && high; }
};

/// The rise of the mean over `values.rows()` runs at which a 95 % interval ends, from the profile as
/// functions of part (column of `parts` each): λ F(0.95; 1, R − 1) / 2R, λ = variance of the runs' slopes by
/// the curvature. The frames of a run are not independent, so that their likelihood alone would promise too
/// much; the runs are (White 1982, Chandler & Bate 2007). Nothing for fewer than two runs, or no curvature.
std::optional<double> rise_at_95(const std::vector<double>& parts, const Eigen::MatrixXd& values,
                                 double best_part);

/// Student's t quantile, two-sided 95 %, of `dof` >= 1 degrees of freedom.
double t_quantile_95(int dof);

/// Where `rises` over `at` first exceed the threshold on both sides of the least, interpolated linearly.
void find_interval(Profile& profile);

/// The profiles of all parameters about the best candidate of the study, for its first objective.
std::vector<Profile> profiles(Study& study);

}  // namespace sim::tune
