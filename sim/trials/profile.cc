#include "sim/trials/profile.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>

#include "sim/score/statistics.h"

namespace sim::trials {
namespace {

constexpr int kMostOutward = 4;  // more points on a side with a rise below the threshold
constexpr double kLeastStep = 0.01, kMostStep = 0.25;  // of the range

Eigen::Index coefficients(Eigen::Index n) { return 1 + n + n * (n + 1) / 2; }

Eigen::VectorXd monomials(const Eigen::VectorXd& x) {
  const Eigen::Index n = x.size();
  Eigen::VectorXd row(coefficients(n));
  row(0) = 1;
  row.segment(1, n) = x;
  Eigen::Index at = 1 + n;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = i; j < n; ++j) row(at++) = i == j ? x(i) * x(i) / 2 : x(i) * x(j);
  return row;
}

// The candidates nearest to the best in value, enough for a quadratic that is not forced through noise.
std::optional<Quadratic> quadratic_near(const Study& study, const Candidate& best) {
  const auto n = static_cast<Eigen::Index>(best.point.size());
  std::vector<const Candidate*> near;
  for (const Candidate& c : study.candidates())
    if (c.complete()) near.push_back(&c);
  std::stable_sort(near.begin(), near.end(), [](const auto* a, const auto* b) { return a->loss < b->loss; });
  near.resize(std::min(near.size(), static_cast<std::size_t>(3 * coefficients(n))));
  Eigen::MatrixXd points(static_cast<Eigen::Index>(near.size()), n);
  Eigen::VectorXd values(points.rows());
  for (Eigen::Index k = 0; k < points.rows(); ++k) {
    const Candidate& c = *near[static_cast<std::size_t>(k)];
    points.row(k) = (Eigen::Map<const Eigen::VectorXd>(c.point.data(), n) -
                     Eigen::Map<const Eigen::VectorXd>(best.point.data(), n))
                        .transpose();
    values(k) = c.loss;
  }
  return fit_quadratic(points, values);
}

// The losses along a line through the best setting: parameter i moves and the others follow.
class Line {
 public:
  Line(Study& study, const std::vector<double>& best, const std::optional<Quadratic>& about, int i)
      : study_(study), best_(best), i_(static_cast<std::size_t>(i)) {
    direction_ = about ? following(about->hessian, i)
                       : Eigen::VectorXd::Unit(static_cast<Eigen::Index>(best.size()), i);
    const double curvature = about ? direction_.dot(about->hessian * direction_) : 0;
    if (curvature > 0) step_ = std::clamp(std::sqrt(0.2 / curvature), kLeastStep, kMostStep / 2);
  }

  /// The step over which the loss should rise.
  double step() const { return step_; }

  /// The setting at `step` along the line, or nullopt if parameter i would leave its range.
  std::optional<std::vector<double>> at(double step) const {
    if (best_[i_] + step < 0 || best_[i_] + step > 1) return std::nullopt;
    std::vector<double> coordinates = best_;
    for (std::size_t k = 0; k < coordinates.size(); ++k)
      coordinates[k] = std::clamp(coordinates[k] + step * direction_(static_cast<Eigen::Index>(k)), 0.0, 1.0);
    return coordinates;
  }

  /// Returns false if parameter i would leave its range.
  bool evaluate(double step) {
    const auto setting = at(step);
    if (!setting) return false;
    std::vector<double> losses;
    for (const TrialRecord* record : study_.evaluate("profile", *setting).records)
      losses.push_back(loss_of(*record, study_.spec().objective));
    losses_[best_[i_] + step] = losses;
    return true;
  }

  Profile profile() const;

 private:
  Study& study_;
  std::vector<double> best_;
  std::size_t i_;
  Eigen::VectorXd direction_;
  double step_ = 0.05;
  std::map<double, std::vector<double>> losses_;  // of the runs, by the coordinate of parameter i
};

// P(|T| <= t) of Student's t with n degrees of freedom (Abramowitz & Stegun 26.7.3 and 26.7.4).
double within(double t, int n) {
  const double theta = std::atan(t / std::sqrt(n)), cos2 = std::cos(theta) * std::cos(theta);
  const bool odd = n % 2 == 1;
  double term = odd ? std::cos(theta) : 1, sum = n == 1 ? 0 : term;
  for (int k = odd ? 3 : 2; k < n; k += 2) sum += term *= cos2 * (k - 1) / k;
  return odd ? 2 / std::numbers::pi * (theta + std::sin(theta) * sum) : std::sin(theta) * sum;
}

// The t beyond which 2.5 % lie on each side, by bisection.
double t_95(int n) {
  double low = 1.9, high = 13;
  while (high - low > 1e-12) (within((low + high) / 2, n) < 0.95 ? low : high) = (low + high) / 2;
  return low;
}

Profile Line::profile() const {
  const Range& parameter = study_.spec().parameters[i_];
  Profile profile{parameter.key, {}, {}, {}, 0, {}, {}};
  profile.values.resize(static_cast<Eigen::Index>(losses_.begin()->second.size()),
                        static_cast<Eigen::Index>(losses_.size()));
  std::vector<double> coordinates;
  for (const auto& [coordinate, losses] : losses_) {
    profile.values.col(static_cast<Eigen::Index>(coordinates.size())) =
        Eigen::Map<const Eigen::VectorXd>(losses.data(), profile.values.rows());
    coordinates.push_back(coordinate);
    profile.at.push_back(parameter.value_at(coordinate));
  }
  const Eigen::VectorXd mean = profile.values.colwise().mean();
  Eigen::Index least = 0;
  const double floor = mean.minCoeff(&least);
  for (const double value : mean) profile.rises.push_back(value - floor);
  profile.threshold = rise_at_95(coordinates, profile.values, coordinates[static_cast<std::size_t>(least)])
                          .value_or(std::numeric_limits<double>::infinity());
  find_interval(profile);
  return profile;
}

constexpr std::array kFirstSteps{0.0, -0.5, 0.5, -1.0, 1.0, -2.0, 2.0};

Profile profile_along(Line& line) {
  for (const double k : kFirstSteps) line.evaluate(k * line.step());
  Profile profile = line.profile();
  double outward = 2 * line.step();
  for (int k = 0; k < kMostOutward && !profile.identifiable(); ++k) {
    outward = std::min(2 * outward, outward + kMostStep);
    const bool below = !profile.low && line.evaluate(-outward),
               above = !profile.high && line.evaluate(outward);
    if (!below && !above) break;
    profile = line.profile();
  }
  return profile;
}

}  // namespace

std::optional<Quadratic> fit_quadratic(const Eigen::MatrixXd& points, const Eigen::VectorXd& values) {
  const Eigen::Index n = points.cols();
  Eigen::MatrixXd A(points.rows(), coefficients(n));
  if (A.rows() < A.cols()) return std::nullopt;
  for (Eigen::Index k = 0; k < A.rows(); ++k) A.row(k) = monomials(points.row(k).transpose()).transpose();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A);
  if (qr.rank() < A.cols()) return std::nullopt;
  const Eigen::VectorXd c = qr.solve(values);
  Quadratic quadratic{c(0), c.segment(1, n), Eigen::MatrixXd(n, n)};
  Eigen::Index at = 1 + n;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = i; j < n; ++j) quadratic.hessian(i, j) = quadratic.hessian(j, i) = c(at++);
  return quadratic;
}

// The rows of H x = e_i other than i say that x_o = −H_oo⁻¹ H_oi x_i.
Eigen::VectorXd following(const Eigen::MatrixXd& hessian, int i) {
  const Eigen::VectorXd unit = Eigen::VectorXd::Unit(hessian.rows(), i);
  const Eigen::LLT<Eigen::MatrixXd> llt(hessian);
  if (llt.info() != Eigen::Success) return unit;
  const Eigen::VectorXd x = llt.solve(unit);
  return x / x(i);
}

std::optional<double> rise_at_95(const std::vector<double>& coordinates, const Eigen::MatrixXd& values,
                                 double best_coordinate) {
  const Eigen::Index runs = values.rows();
  if (runs < 2) return std::nullopt;
  // A parabola of each run through the five points nearest to the least.
  std::vector<Eigen::Index> near(coordinates.size());
  std::iota(near.begin(), near.end(), Eigen::Index{0});
  std::stable_sort(near.begin(), near.end(), [&](Eigen::Index a, Eigen::Index b) {
    return std::abs(coordinates[static_cast<std::size_t>(a)] - best_coordinate) <
           std::abs(coordinates[static_cast<std::size_t>(b)] - best_coordinate);
  });
  near.resize(std::min<std::size_t>(near.size(), 5));
  Eigen::MatrixXd points(static_cast<Eigen::Index>(near.size()), 1);
  for (Eigen::Index k = 0; k < points.rows(); ++k)
    points(k, 0) = coordinates[static_cast<std::size_t>(near[static_cast<std::size_t>(k)])] - best_coordinate;
  std::vector<double> slopes;
  double curvature = 0;
  for (Eigen::Index run = 0; run < runs; ++run) {
    const auto parabola = fit_quadratic(points, values.row(run)(near).transpose());
    if (!parabola) return std::nullopt;
    slopes.push_back(parabola->gradient(0));
    curvature += parabola->hessian(0, 0) / static_cast<double>(runs);
  }
  if (!(curvature > 0)) return std::nullopt;
  const double sd = score::standard_deviation(slopes);
  const double t = t_95(static_cast<int>(runs - 1));
  return sd * sd / curvature * t * t / (2 * static_cast<double>(runs));
}

void find_interval(Profile& profile) {
  const std::vector<double>&at = profile.at, &rises = profile.rises;
  const auto least = std::min_element(rises.begin(), rises.end()) - rises.begin();
  profile.low.reset(), profile.high.reset();
  const auto crossing = [&](std::size_t inside, std::size_t outside) {
    const double fraction = (profile.threshold - rises[inside]) / (rises[outside] - rises[inside]);
    return at[inside] + fraction * (at[outside] - at[inside]);
  };
  for (auto i = static_cast<std::size_t>(least); i-- > 0 && !profile.low;)
    if (rises[i] > profile.threshold) profile.low = crossing(i + 1, i);
  for (auto i = static_cast<std::size_t>(least) + 1; i < at.size() && !profile.high; ++i)
    if (rises[i] > profile.threshold) profile.high = crossing(i - 1, i);
}

std::vector<Profile> profiles(Study& study) {
  const Candidate best = study.best();
  const auto about = quadratic_near(study, best);
  std::vector<Line> lines;
  std::vector<std::vector<double>> first;
  for (std::size_t i = 0; i < best.point.size(); ++i) {
    lines.emplace_back(study, best.point, about, static_cast<int>(i));
    for (const double k : kFirstSteps)
      if (auto setting = lines.back().at(k * lines.back().step())) first.push_back(std::move(*setting));
  }
  study.prefetch(first);
  std::vector<Profile> all;
  for (Line& line : lines) all.push_back(profile_along(line));
  return all;
}

}  // namespace sim::trials
