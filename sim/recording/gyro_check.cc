#include <fmt/format.h>

#include <limits>

#include "sim/recording/asl_folder.h"

namespace sim::recording {
namespace {

constexpr slam::Stamp kStep{20'000'000}, kBridged{100'000'000}, kHour = std::chrono::hours(1);
constexpr int kWindow = 5, kMostLag = 500, kFewest = 50;  // steps
constexpr double kLeastCorrelation = 0.6, kMostCorrelation = 0.99995, kDecisive = 20;

using Turns = std::vector<std::optional<Eigen::Vector3d>>;

/// Returns the turn from each time of a grid until a window later, if it is known.
Turns turns(const std::vector<files::TumRow>& poses, slam::Stamp begin, std::size_t size) {
  std::vector<std::optional<Eigen::Quaterniond>> at(size);
  std::size_t next = 1;
  for (std::size_t k = 0; k < size; ++k) {
    const slam::Stamp t = begin + static_cast<std::int64_t>(k) * kStep;
    while (next < poses.size() && poses[next].t < t) ++next;
    if (next >= poses.size()) break;
    const files::TumRow &a = poses[next - 1], &b = poses[next];
    if (a.t <= t && b.t - a.t <= kBridged) at[k] = Eigen::Quaterniond(files::interpolate(a, b, t).linear());
  }
  Turns all(size);
  for (std::size_t k = 0; k + kWindow < size; ++k)
    if (at[k] && at[k + kWindow]) {
      const Eigen::AngleAxisd turn(at[k]->conjugate() * *at[k + kWindow]);
      all[k] = turn.angle() * turn.axis();
    }
  return all;
}

struct Correlation {
  double r = 0, gain = 0;
  int pairs = 0;
  /// Log-likelihood ratio of a linear relation to no relation, counting one independent speed per window.
  double evidence(double of_r) const {
    return 0.5 * pairs / kWindow * -std::log1p(-std::pow(std::clamp(of_r, 0.0, 1 - 1e-12), 2));
  }
};

/// Calls f(turn of the truth, turn of the gyro) for an offset. The mean turns are subtracted, which removes a
/// bias. Returns the number of pairs; if there are too few, f is not called.
int each_pair(const Turns& truth, const Turns& gyro, int lag, const auto& f) {
  const auto size = static_cast<int>(truth.size());
  const auto each = [&](const auto& take) {
    for (int k = std::max(0, -lag); k < size - std::max(0, lag); ++k) {
      const auto &a = truth[static_cast<std::size_t>(k)], &b = gyro[static_cast<std::size_t>(k + lag)];
      if (a && b) take(*a, *b);
    }
  };
  int pairs = 0;
  Eigen::Vector3d truth_sum = Eigen::Vector3d::Zero(), gyro_sum = truth_sum;
  each([&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { truth_sum += a, gyro_sum += b, ++pairs; });
  const Eigen::Vector3d truth_mean = truth_sum / pairs, gyro_mean = gyro_sum / pairs;
  if (pairs >= kFewest)
    each([&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { f(a - truth_mean, b - gyro_mean); });
  return pairs;
}

/// Correlates the angles of the turns.
Correlation correlation(const Turns& truth, const Turns& gyro, int lag) {
  Correlation c;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  c.pairs = each_pair(truth, gyro, lag, [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const Eigen::Vector2d pair(a.norm(), b.norm());
    sum += pair;
    squares += pair * pair.transpose();
  });
  if (c.pairs < kFewest) return c;
  const Eigen::Matrix2d S = squares - sum * sum.transpose() / c.pairs;
  if (S(0, 0) > 1e-12 && S(1, 1) > 1e-12) {
    c.r = S(0, 1) / std::sqrt(S(0, 0) * S(1, 1));
    c.gain = S(0, 1) / S(0, 0);
  }
  return c;
}

/// Second moments of the turns about the axes of truth and gyro.
struct Moments {
  int pairs = 0;
  Eigen::Matrix3d truth = Eigen::Matrix3d::Zero(), gyro = truth, both = truth;  // both: rows are the gyro's

  /// Returns the fraction of the gyro's variance that M (orthogonal, truth to gyro) explains.
  double explained(const Eigen::Matrix3d& M) const {
    return (2 * (both * M.transpose()).trace() - truth.trace()) / gyro.trace();
  }
  /// Log-likelihood ratio of M to a different transformation. Less than 0.3 % of the variance does not count.
  double evidence(const Eigen::Matrix3d& M, const Eigen::Matrix3d& other) const {
    const auto left = [&](const Eigen::Matrix3d& of) { return std::max(1 - explained(of), 3e-3); };
    return 0.5 * pairs / kWindow * std::log(left(other) / left(M));
  }
};

Moments moments(const Turns& truth, const Turns& gyro, int lag, const Eigen::Matrix3d& R_GT) {
  Moments m;
  m.pairs = each_pair(truth, gyro, lag, [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const Eigen::Vector3d turn = R_GT * a;
    m.truth += turn * turn.transpose(), m.gyro += b * b.transpose(), m.both += b * turn.transpose();
  });
  return m;
}

/// Returns the rotation R with the largest trace of R^T M, using Horn's matrix (1987). Repeated squaring
/// yields its leading eigenvector and compiles faster than a decomposition.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& M) {
  Eigen::Matrix4d N;
  const Eigen::Vector3d off(M(2, 1) - M(1, 2), M(0, 2) - M(2, 0), M(1, 0) - M(0, 1));
  N << M.trace(), off.transpose(), off, M + M.transpose() - M.trace() * Eigen::Matrix3d::Identity();
  N += N.norm() * Eigen::Matrix4d::Identity();
  for (int i = 0; i < 30; ++i) N = (N * N / (N * N).norm()).eval();
  Eigen::Index column;
  N.colwise().norm().maxCoeff(&column);
  const Eigen::Vector4d q = N.col(column).normalized();
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
}

void compare_axes(const Moments& m, GyroComparison& comparison) {
  constexpr double kLeastExplained = 0.8, kLeastTurn_rad = 0.17;
  const Eigen::Matrix3d rotation = nearest_rotation(m.both), mirror = -nearest_rotation(-m.both);
  if (m.explained(mirror) > kLeastExplained && m.evidence(mirror, rotation) >= kDecisive) {
    comparison.mirrored = true;
    return;
  }
  const double turned = Eigen::AngleAxisd(rotation).angle();
  if (m.explained(rotation) > kLeastExplained && turned > kLeastTurn_rad &&
      m.evidence(rotation, Eigen::Matrix3d::Identity()) >= kDecisive)
    comparison.turned_rad = turned;
}

}  // namespace

std::optional<GyroComparison> compare_gyro(const std::vector<TimedRotation>& gyro,
                                           const std::vector<files::TumRow>& truth,
                                           const Eigen::Matrix3d& R_GT) {
  if (gyro.empty() || truth.empty()) return std::nullopt;
  const slam::Stamp margin = kMostLag * kStep, begin = truth.front().t - margin;
  const slam::Stamp end = std::min(truth.back().t, truth.front().t + kHour) + margin;
  const auto size = static_cast<std::size_t>((end - begin) / kStep);
  std::vector<files::TumRow> integral{{{gyro.front().t}, std::nullopt}};
  for (std::size_t i = 1; i < gyro.size(); ++i) {
    const Eigen::Vector3d turn =
        0.5 * (gyro[i - 1].value + gyro[i].value) * slam::seconds(gyro[i].t - gyro[i - 1].t);
    files::TumRow& now = integral.emplace_back(integral.back());
    now.t = gyro[i].t;
    now.X.rotate(Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()));
  }
  const Turns by_gyro = turns(integral, begin, size), by_truth = turns(truth, begin, size);
  std::vector<Correlation> all;
  for (int lag = -kMostLag; lag <= kMostLag; ++lag) all.push_back(correlation(by_truth, by_gyro, lag));
  const auto best = std::ranges::max_element(all, {}, [](const Correlation& c) { return c.evidence(c.r); });
  const double as_stamped = all[kMostLag].r;
  if (best->r < kLeastCorrelation) return std::nullopt;
  const auto evidence = [&](double r) { return best->evidence(std::min(r, kMostCorrelation)); };
  const bool decisive = evidence(best->r) - evidence(as_stamped) >= kDecisive;
  const auto lag = decisive ? static_cast<int>(best - all.begin()) - kMostLag : 0;
  GyroComparison comparison{0, best->r, as_stamped, best->gain};
  if (decisive) {  // between the steps, at the vertex of a parabola
    double between = 0;
    if (best != all.begin() && std::next(best) != all.end()) {
      const double before = std::prev(best)->r, after = std::next(best)->r,
                   curve = before + after - 2 * best->r;
      if (curve < 0) between = 0.5 * (before - after) / curve;
    }
    comparison.late_s = (lag + between) * slam::seconds(kStep);
  }
  if (const Moments m = moments(by_truth, by_gyro, lag, R_GT); m.pairs >= kFewest)
    compare_axes(m, comparison);
  return comparison;
}

}  // namespace sim::recording
