#include "sim/bench/verdict.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "sim/bench/scenario_limits.h"
#include "sim/score/evaluate.h"
#include "sim/score/significance.h"
#include "sim/score/statistics.h"

namespace sim::bench {
namespace {

constexpr double kLevel = 0.05;

std::optional<double> value_of(const SeedScore& seed, const std::string& metric) {
  for (const SeedMetric& m : seed.metrics)
    if (m.name == metric) return m.value;
  return std::nullopt;
}

// What grows as the metric becomes worse.
double badness(const std::string& metric, double value) {
  const score::MetricDefinition* defined = score::find_metric(metric);
  if (defined && defined->worst == score::Worst::smallest) return -value;
  return defined && defined->worst == score::Worst::largest_magnitude ? std::abs(value) : value;
}

// A metric's values of both sides; paired: seed by seed, those that both have.
struct Values {
  std::vector<std::uint64_t> seeds;
  std::vector<double> baseline, now;
  std::size_t lost = 0, won = 0;  // values that one side alone has
  bool identical = true;
};

const SeedScore* find(const std::vector<SeedScore>& seeds, std::uint64_t seed) {
  const auto found =
      std::find_if(seeds.begin(), seeds.end(), [&](const SeedScore& s) { return s.seed == seed; });
  return found == seeds.end() ? nullptr : &*found;
}

Values paired_values(const ScenarioResults& baseline, const ScenarioResults& now, const std::string& metric) {
  Values values;
  for (const SeedScore& seed : now.seeds) {
    const SeedScore* other = find(baseline.seeds, seed.seed);
    if (!other) continue;
    const auto a = value_of(*other, metric), b = value_of(seed, metric);
    values.identical &= a == b;
    values.lost += a && !b;
    values.won += b && !a;
    if (!a || !b) continue;
    values.seeds.push_back(seed.seed);
    values.baseline.push_back(*a);
    values.now.push_back(*b);
  }
  return values;
}

Values unpaired_values(const ScenarioResults& baseline, const ScenarioResults& now,
                       const std::string& metric) {
  Values values;
  for (const SeedScore& seed : baseline.seeds)
    if (const auto v = value_of(seed, metric)) values.baseline.push_back(*v);
  for (const SeedScore& seed : now.seeds)
    if (const auto v = value_of(seed, metric)) {
      values.now.push_back(*v);
      values.seeds.push_back(seed.seed);
    }
  // Of other seeds it is the rate that can be lost.
  if (values.now.empty()) values.lost = values.baseline.size();
  if (values.baseline.empty()) values.won = values.now.size();
  values.identical = values.baseline.empty() && values.now.empty();
  return values;
}

// The values as something that grows as they become worse.
std::vector<double> badnesses(const std::string& metric, std::vector<double> values) {
  for (double& value : values) value = badness(metric, value);
  return values;
}

// Its place among the changes says the seed.
std::vector<double> changes(const std::string& metric, const Values& values) {
  std::vector<double> all = badnesses(metric, values.now);
  const std::vector<double> before = badnesses(metric, values.baseline);
  for (std::size_t i = 0; i < all.size(); ++i) all[i] -= before[i];
  return all;
}

// By how many seeds a change beyond the tolerance is borne out: too few for a test.
Verdict by_seeds(const std::vector<double>& worse_by, double tolerance, std::string& remark) {
  const auto beyond = [&](auto test) { return std::count_if(worse_by.begin(), worse_by.end(), test); };
  const auto worse = beyond([&](double d) { return d > tolerance; }),
             better = beyond([&](double d) { return d < -tolerance; });
  const auto n = static_cast<std::ptrdiff_t>(worse_by.size());
  if (worse + better == 0) return Verdict::same;
  remark = fmt::format("{} of {} seeds worse beyond tolerance, {} better", worse, n, better);
  if (better == 0 && 2 * worse > n) return Verdict::fail;
  if (worse == 0 && 2 * better > n) return Verdict::better;
  return Verdict::noisy;
}

double tolerance(const Gate& gate, double baseline) {
  return std::max(gate.absolute, gate.percent / 100 * std::abs(baseline));
}

// One metric before its p-value is adjusted; the raw one in `p`. worse_by: the change of badness.
struct Judged {
  MetricVerdict verdict;
  double worse_by = 0;
  bool tested = false;
};

Judged judge_paired(const Gate& gate, const Values& values) {
  const std::vector<double> worse_by = changes(gate.metric, values);
  Judged judged{{gate}, score::median(worse_by), worse_by.size() >= kSeedsForTest};
  MetricVerdict& v = judged.verdict;
  v.n = worse_by.size();
  v.baseline = score::median(values.baseline);
  v.now = score::median(values.now);
  v.worst_seed = values.seeds[static_cast<std::size_t>(std::max_element(worse_by.begin(), worse_by.end()) -
                                                       worse_by.begin())];
  std::vector<double> difference = values.now;
  for (std::size_t i = 0; i < difference.size(); ++i) difference[i] -= values.baseline[i];
  v.change = score::median(difference);
  v.band = score::median_interval(difference);
  if (judged.tested) {
    v.p = score::wilcoxon_signed_rank(worse_by);
  } else {
    v.verdict = by_seeds(worse_by, tolerance(gate, *v.baseline), v.remark);
  }
  return judged;
}

Judged judge_unpaired(const Gate& gate, const Values& values) {
  const std::vector<double> before = badnesses(gate.metric, values.baseline),
                            after = badnesses(gate.metric, values.now);
  Judged judged{{gate}, score::median(after) - score::median(before), true};
  MetricVerdict& v = judged.verdict;
  v.n = std::min(before.size(), after.size());
  v.baseline = score::median(values.baseline);
  v.now = score::median(values.now);
  v.change = *v.now - *v.baseline;
  v.worst_seed =
      values.seeds[static_cast<std::size_t>(std::max_element(after.begin(), after.end()) - after.begin())];
  v.p = score::rank_sum(before, after);
  return judged;
}

Judged judge(const Gate& gate, const Values& values, bool paired) {
  Judged judged{{gate}, 0, false};
  MetricVerdict& v = judged.verdict;
  if (!values.baseline.empty() && !values.now.empty())
    judged = paired ? judge_paired(gate, values) : judge_unpaired(gate, values);
  else if (values.identical)
    v.remark = "no run has it";
  if (values.identical) {
    v.verdict = Verdict::identical;
    judged.tested = false;
    v.p.reset();
  } else if (values.lost > 0) {
    v.verdict = Verdict::missing;
    v.remark = fmt::format("{} seeds have no value that had one", values.lost);
    judged.tested = false;
    v.p.reset();
  } else if (values.baseline.empty()) {
    v.verdict = Verdict::added;
  } else if (values.won > 0) {
    v.remark = fmt::format("{} seeds have a value that had none", values.won);
  }
  return judged;
}

void decide(Judged& judged) {
  MetricVerdict& v = judged.verdict;
  const bool beyond = std::abs(judged.worse_by) > tolerance(v.gate, *v.baseline);
  if (!beyond) {
    v.verdict = Verdict::same;
  } else if (*v.p >= kLevel) {
    v.verdict = Verdict::noisy;
    v.remark = v.n < kSeedsForTest ? "too few seeds for a test: 8 are needed"
                                   : "may be chance: more seeds would tell";
  } else {
    v.verdict = judged.worse_by > 0 ? Verdict::fail : Verdict::better;
  }
}

std::vector<std::string> config_differences(const std::map<std::string, std::string>& a,
                                            const std::map<std::string, std::string>& b) {
  std::vector<std::string> all;
  const auto text = [](const std::map<std::string, std::string>& config, const std::string& key) {
    const auto found = config.find(key);
    return found == config.end() ? std::string("not set") : found->second;
  };
  std::map<std::string, std::string> keys = a;
  keys.insert(b.begin(), b.end());
  for (const auto& [key, value] : keys)
    if (text(a, key) != text(b, key))
      all.push_back(fmt::format("{}: {} -> {}", key, text(a, key), text(b, key)));
  return all;
}

LimitVerdict endings(const Scenario& scenario, const std::vector<SeedScore>& seeds) {
  LimitVerdict verdict{fmt::format("ending {}", fmt::join(scenario.limits.ending, " or ")), "", true, false,
                       0};
  std::size_t kept = 0;
  for (const SeedScore& seed : seeds) {
    const auto& allowed = scenario.limits.ending;
    if (std::find(allowed.begin(), allowed.end(), seed.ending) != allowed.end()) {
      ++kept;
    } else if (verdict.passed) {
      verdict.passed = false;
      verdict.run_failed = true;
      verdict.worst_seed = seed.seed;
    }
  }
  verdict.kept = fmt::format("{}/{}", kept, seeds.size());
  return verdict;
}

std::string in_words(const MetricLimit& limit) {
  return fmt::format("{} {} {}", subject(limit), limit.bound == Bound::at_most ? "<=" : ">=", limit.value);
}

LimitVerdict on_each_seed(const MetricLimit& limit, const std::vector<SeedScore>& seeds) {
  LimitVerdict verdict{in_words(limit), "", true, false, 0};
  std::size_t kept = 0;
  double worst = -std::numeric_limits<double>::infinity();
  for (const SeedScore& seed : seeds) {
    const auto value = value_of(seed, limit.metric);
    if (value && keeps(limit, *value)) {
      ++kept;
      continue;
    }
    verdict.passed = false;
    const double by = value ? (limit.bound == Bound::at_most ? *value : -*value)
                            : std::numeric_limits<double>::max();  // no value is worse than any
    if (by > worst) verdict.worst_seed = seed.seed;
    worst = std::max(worst, by);
  }
  verdict.kept = fmt::format("{}/{}", kept, seeds.size());
  return verdict;
}

LimitVerdict over_seeds(const JudgedLimit& judged, const std::vector<SeedScore>& seeds) {
  LimitVerdict verdict{in_words(judged.limit),
                       judged.value ? fmt::format("{:.4g}", *judged.value) : "no value",
                       judged.passed.value_or(true), false, 0};
  if (seeds.empty()) return verdict;
  const auto by = [&](const SeedScore& seed) {
    const auto value = value_of(seed, judged.limit.metric);
    if (!value) return std::numeric_limits<double>::max();
    return judged.limit.bound == Bound::at_most ? *value : -*value;
  };
  verdict.worst_seed = std::max_element(seeds.begin(), seeds.end(), [&](const auto& a, const auto& b) {
                         return by(a) < by(b);
                       })->seed;
  return verdict;
}

}  // namespace

std::string_view word(Verdict verdict) {
  static constexpr std::array<std::string_view, 7> kWords{"IDENTICAL", "SAME", "BETTER", "FAIL",
                                                          "NOISY",     "NEW",  "MISSING"};
  return kWords[static_cast<std::size_t>(verdict)];
}

bool fails(Verdict verdict) { return verdict == Verdict::fail || verdict == Verdict::missing; }

ScenarioVerdict compare(const ScenarioResults& baseline, const ScenarioResults& now,
                        const std::vector<Gate>& gates) {
  ScenarioVerdict result;
  result.name = now.name;
  std::size_t common = 0;
  for (const SeedScore& seed : now.seeds) {
    const SeedScore* other = find(baseline.seeds, seed.seed);
    if (!other) continue;
    ++common;
    result.other_recordings += other->recording != seed.recording;
  }
  result.paired = common > 0;
  result.n_baseline = result.paired ? common : baseline.seeds.size();
  result.n_now = result.paired ? common : now.seeds.size();
  result.other_config = config_differences(baseline.config, now.config);
  std::vector<Judged> judged;
  std::vector<double> p;
  for (const Gate& gate : gates) {
    judged.push_back(judge(gate,
                           result.paired ? paired_values(baseline, now, gate.metric)
                                         : unpaired_values(baseline, now, gate.metric),
                           result.paired));
    p.push_back(judged.back().tested ? *judged.back().verdict.p : 1);
  }
  p = score::holm(p);
  for (std::size_t i = 0; i < judged.size(); ++i) {
    if (judged[i].tested) {
      judged[i].verdict.p = p[i];
      decide(judged[i]);
    }
    result.metrics.push_back(judged[i].verdict);
  }
  return result;
}

ScenarioVerdict without_counterpart(const ScenarioResults& there, const std::vector<Gate>& gates,
                                    Verdict verdict) {
  ScenarioVerdict result;
  result.name = there.name;
  result.n_now = verdict == Verdict::added ? there.seeds.size() : 0;
  result.n_baseline = verdict == Verdict::added ? 0 : there.seeds.size();
  for (const Gate& gate : gates) {
    MetricVerdict v{gate};
    std::vector<double> values;
    for (const SeedScore& seed : there.seeds)
      if (const auto value = value_of(seed, gate.metric)) values.push_back(*value);
    v.n = values.size();
    if (!values.empty()) (verdict == Verdict::added ? v.now : v.baseline) = score::median(values);
    v.verdict = verdict;
    result.metrics.push_back(v);
  }
  return result;
}

std::vector<LimitVerdict> judge_limits(const Scenario& scenario, const std::vector<SeedScore>& seeds) {
  std::vector<LimitVerdict> all{endings(scenario, seeds)};
  for (const MetricLimit& limit : scenario.limits.metrics)
    if (limit.aggregate.empty() && scenario.slam) all.push_back(on_each_seed(limit, seeds));
  for (const JudgedLimit& judged : summarize(scenario, seeds).limits)
    all.push_back(over_seeds(judged, seeds));
  return all;
}

int exit_code(const std::vector<ScenarioVerdict>& verdicts) {
  int worst = 0;
  for (const ScenarioVerdict& scenario : verdicts) {
    for (const MetricVerdict& metric : scenario.metrics)
      worst = std::max(worst, fails(metric.verdict) ? 1 : 0);
    for (const LimitVerdict& limit : scenario.limits)
      worst = std::max(worst, limit.passed ? 0 : limit.run_failed ? 3 : 1);
  }
  return worst;
}

const std::vector<Gate>& default_gates() {
  static const std::vector<Gate> gates{{"ate_se3_rmse_m", 10, 0.001},   {"rmse_m", 15, 0.002},
                                       {"rpe_1m_m", 10, 0.001},         {"end_yaw_error_deg", 20, 0.1},
                                       {"nees_position_mean", 30, 0.5}, {"loop_landmarks", 20, 2}};
  return gates;
}

}  // namespace sim::bench
