#include "sim/regression/verdict.h"
#include "sim/result/limits.h"
#include "sim/score/metrics.h"
#include "sim/sensor_errors/random.h"

namespace sim::regression {
namespace {

using sensor_errors::Random;

constexpr std::uint64_t kDraws = 10'000;

// Draws of the mean NEES of one run. Errors of position and orientation accumulate, so each is a random walk,
// and the covariance grows like its variance.
std::vector<double> nees_of_runs() {
  constexpr int kMoments = 32;
  Random random(1, "errors of a consistent filter");
  std::vector<double> all;
  for (std::uint64_t draw = 0; draw < kDraws; ++draw) {
    Eigen::Vector3d error = Eigen::Vector3d::Zero();
    double sum = 0;
    for (int moment = 1; moment <= kMoments; ++moment) {
      for (double& x : error) x += random.normal();
      sum += error.squaredNorm() / moment;
    }
    all.push_back(sum / kMoments);
  }
  return all;
}

score::Band nees_band(std::size_t runs) {
  static const std::vector<double> of_run = nees_of_runs();
  Random random(1, "runs of a consistent filter");
  std::vector<double> means;
  for (std::uint64_t draw = 0; draw < kDraws; ++draw) {
    double sum = 0;
    for (std::size_t run = 0; run < runs; ++run) sum += of_run[random.bits() % kDraws];
    means.push_back(sum / double(runs));
  }
  return {score::quantile(means, 0.025), score::quantile(means, 0.975)};
}

// Innovations of a consistent filter are white, so that each frame's counts.
score::Band nis_band(const std::vector<result::SeedScore>& seeds) {
  double frames = 0;
  for (const double poses : result::values_of("true_poses", seeds)) frames += poses;
  return score::mean_band(1, std::max(1, int(frames)));
}

}  // namespace

std::vector<LimitVerdict> judge_consistency(const std::vector<result::SeedScore>& seeds, double factor) {
  std::vector<LimitVerdict> verdicts;
  for (const score::MetricDefinition& metric : score::metric_definitions()) {
    const std::vector<double> values = result::values_of(metric.name, seeds);
    if (metric.direction.worst != score::Worst::farthest_from_expected || values.empty()) continue;
    const auto [low, high] = metric.name.starts_with("nees_") ? nees_band(values.size()) : nis_band(seeds);
    const score::Band band{low / (factor * factor), high * factor * factor};
    const double mean = score::mean(values);
    const bool met = mean >= band.low && mean <= band.high;
    LimitVerdict& verdict = verdicts.emplace_back(LimitVerdict{
        "consistent " + metric.name, fmt::format("{:.3g} [{:.3g}, {:.3g}]", mean, band.low, band.high),
        met ? LimitState::met : LimitState::missed});
    if (!met)
      verdict.worst_seed =
          std::ranges::max_element(seeds, {}, [&](const result::SeedScore& seed) {
            return score::loss(seed.value(metric.name).value_or(metric.direction.expected), metric.direction);
          })->seed;
  }
  return verdicts;
}

}  // namespace sim::regression
