

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
    const slam::Stamp t = begin + std::int64_t(k) * kStep;
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

/// Correlates the angles of the turns for an offset. The mean turns are subtracted, which removes a bias.
Correlation correlation(const Turns& truth, const Turns& gyro, int lag) {
  Correlation c;
  const auto size = int(truth.size());
  const auto each = [&](const auto& take) {
    for (int k = std::max(0, -lag); k < size - std::max(0, lag); ++k) {
      const auto &a = truth[std::size_t(k)], &b = gyro[std::size_t(k + lag)];
      if (a && b) take(*a, *b);
    }
  };
  Eigen::Vector3d truth_sum = Eigen::Vector3d::Zero(), gyro_sum = truth_sum;
  each([&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { truth_sum += a, gyro_sum += b, ++c.pairs; });
  if (c.pairs < kFewest) return c;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  each([&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const Eigen::Vector2d pair((a - truth_sum / c.pairs).norm(), (b - gyro_sum / c.pairs).norm());
    sum += pair;
    squares += pair * pair.transpose();
  });
  const Eigen::Matrix2d S = squares - sum * sum.transpose() / c.pairs;
  if (S(0, 0) > 1e-12 && S(1, 1) > 1e-12) {
    c.r = S(0, 1) / std::sqrt(S(0, 0) * S(1, 1));
    c.gain = S(0, 1) / S(0, 0);
  }
  return c;
}

}  // namespace

std::optional<GyroComparison> compare_gyro(const std::vector<TimedRotation>& gyro,
                                           const std::vector<files::TumRow>& truth) {
  if (gyro.empty() || truth.empty()) return std::nullopt;
  const slam::Stamp margin = kMostLag * kStep, begin = truth.front().t - margin;
  const slam::Stamp end = std::min(truth.back().t, truth.front().t + kHour) + margin;
  const auto size = std::size_t((end - begin) / kStep);
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
  const auto lag = decisive ? int(best - all.begin()) - kMostLag : 0;
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
  return comparison;
}

}  // namespace sim::recording
