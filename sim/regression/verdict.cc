#include "sim/regression/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/files/text.h"
#include "sim/score/metrics.h"
#include "sim/score/statistics.h"

namespace sim::regression {
namespace {

constexpr double kLevel = 0.05;

// A metric's values of both sides; paired: seed by seed, those that both have.
struct Values {
  std::vector<std::uint64_t> seeds;
  std::vector<double> baseline, now;
  std::size_t lost = 0, won = 0;  // values of only one side
  std::vector<double> lost_from;  // of the baseline
  std::string why_lost;           // how the first run without its value ended
  bool identical = true;
};

Values paired_values(const ScenarioResults& baseline, const ScenarioResults& now, const std::string& metric) {
  Values values;
  for (const result::SeedScore& seed : now.seeds) {
    const result::SeedScore* other = baseline.find(seed.seed);
    if (!other) continue;
    const auto a = other->value(metric), b = seed.value(metric);
    values.identical &= a == b;
    values.won += b && !a;
    if (a && !b) {
      values.lost_from.push_back(*a);
      if (values.lost++ == 0) values.why_lost = ending_text(seed);
    }
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
  for (const result::SeedScore& seed : baseline.seeds)
    if (const auto v = seed.value(metric)) values.baseline.push_back(*v);
  for (const result::SeedScore& seed : now.seeds)
    if (const auto v = seed.value(metric)) {
      values.now.push_back(*v);
      values.seeds.push_back(seed.seed);
    }
  // Single values cannot be missing, since the seeds differ; all of them can.
  if (values.now.empty()) {
    values.lost = values.baseline.size();
    values.lost_from = values.baseline;
    if (!now.seeds.empty()) values.why_lost = ending_text(now.seeds.front());
  }
  if (values.baseline.empty()) values.won = values.now.size();
  values.identical = values.baseline.empty() && values.now.empty();
  return values;
}

std::vector<double> losses(const std::string& metric, std::vector<double> values) {
  for (double& value : values) value = score::loss(value, score::direction_of(metric));
  return values;
}

std::vector<double> differences(const std::vector<double>& before, std::vector<double> after) {
  for (std::size_t i = 0; i < after.size(); ++i) after[i] -= before[i];
  return after;
}

// The verdict for too few seeds for a test: by the number of seeds that changed by more than the tolerance.
Verdict by_seeds(const std::vector<double>& worse_by, double tolerance, std::string& remark) {
  const auto beyond = [&](auto test) { return std::count_if(worse_by.begin(), worse_by.end(), test); };
  const auto worse = beyond([&](double d) { return d > tolerance; }),
             better = beyond([&](double d) { return d < -tolerance; });
  const auto n = static_cast<std::ptrdiff_t>(worse_by.size());
  if (worse + better == 0) return Verdict::same;
  remark = fmt::format("{} of {} worse beyond tolerance, {} better", worse,
                       files::counted(worse_by.size(), "seed"), better);
  if (better == 0 && 2 * worse > n) return Verdict::fail;
  if (worse == 0 && 2 * better > n) return Verdict::better;
  return Verdict::noisy;
}

// By how much the loss may grow.
double tolerance(const Gate& gate, double baseline) {
  if (const auto factor = tolerated_factor(gate)) return std::log(*factor);
  return std::max(gate.absolute, gate.percent / 100 * std::abs(baseline));
}

// The verdict on a metric before its p-value is adjusted. worse_by: the increase of its loss.
struct Judged {
  MetricVerdict verdict;
  double worse_by = 0;
  bool tested = false;
};

Judged judge_values(const Gate& gate, const Values& values, bool paired) {
  const std::vector<double> before = losses(gate.metric, values.baseline),
                            after = losses(gate.metric, values.now),
                            worse_by = paired ? differences(before, after) : after;
  Judged judged{{gate}, score::median(worse_by) - (paired ? 0 : score::median(before)), true};
  MetricVerdict& v = judged.verdict;
  v.n = std::min(before.size(), after.size());
  v.baseline = score::median(values.baseline);
  v.now = score::median(values.now);
  const auto worst = std::max_element(worse_by.begin(), worse_by.end()) - worse_by.begin();
  v.worst_seed = values.seeds[static_cast<std::size_t>(worst)];
  if (!paired) {
    v.change = *v.now - *v.baseline;
    v.p = score::rank_sum(before, after);
    return judged;
  }
  const std::vector<double> changes = differences(values.baseline, values.now);
  v.change = score::median(changes);
  v.band = score::median_interval(changes);
  judged.tested = worse_by.size() >= kSeedsForTest;
  if (judged.tested)
    v.p = score::wilcoxon_signed_rank(worse_by);
  else
    v.verdict = by_seeds(worse_by, tolerance(gate, *v.baseline), v.remark);
  return judged;
}

Judged judge(const Gate& gate, const Values& values, bool paired) {
  Judged judged{{gate}, 0, false};
  MetricVerdict& v = judged.verdict;
  if (!values.baseline.empty() && !values.now.empty())
    judged = judge_values(gate, values, paired);
  else if (values.identical)
    v.remark = "no run has a value";
  if (values.identical) {
    v.verdict = Verdict::identical;
    judged.tested = false;
    v.p.reset();
  } else if (values.lost > 0) {
    v.verdict = Verdict::missing;
    v.remark = fmt::format("{} lost the value: {}", files::counted(values.lost, "seed"), values.why_lost);
    if (!v.baseline) v.baseline = score::median(values.lost_from);
    judged.tested = false;
    v.p.reset();
  } else if (values.baseline.empty()) {
    v.verdict = Verdict::added;
  } else if (values.won > 0) {
    v.remark = fmt::format("{} got a value that had none before", files::counted(values.won, "seed"));
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
    v.remark = v.n < kSeedsForTest ? "too few seeds for a significance test: 8 are needed"
                                   : "not significant: more seeds are needed";
  } else {
    v.verdict = judged.worse_by > 0 ? Verdict::fail : Verdict::better;
  }
}

// Adds how far the medians are from the expected value, if there is one.
void add_distances(MetricVerdict& v) {
  const score::Direction direction = score::direction_of(v.gate.metric);
  const bool changed =
      v.verdict == Verdict::better || v.verdict == Verdict::fail || v.verdict == Verdict::noisy;
  if (!tolerated_factor(v.gate) || !changed) return;
  const auto factor = [&](double value) { return std::exp(score::loss(value, direction)); };
  v.remark = fmt::format("{} expected, off by a factor of {:.3g} before, {:.3g} now{}", direction.expected,
                         factor(*v.baseline), factor(*v.now), v.remark.empty() ? "" : "; " + v.remark);
}

std::vector<MetricVerdict> judge_gates(const ScenarioResults& baseline, const ScenarioResults& now,
                                       const std::vector<Gate>& gates, bool paired) {
  std::vector<Judged> judged;
  std::vector<double> p;
  for (const Gate& gate : gates) {
    judged.push_back(judge(
        gate,
        paired ? paired_values(baseline, now, gate.metric) : unpaired_values(baseline, now, gate.metric),
        paired));
    p.push_back(judged.back().tested ? *judged.back().verdict.p : 1);
  }
  p = score::holm(p);
  std::vector<MetricVerdict> verdicts;
  for (std::size_t i = 0; i < judged.size(); ++i) {
    if (judged[i].tested) {
      judged[i].verdict.p = p[i];
      decide(judged[i]);
    }
    add_distances(judged[i].verdict);
    verdicts.push_back(judged[i].verdict);
  }
  return verdicts;
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

}  // namespace

std::string ending_text(const result::SeedScore& seed) {
  return fmt::format("seed {} {}{}{}", seed.seed, scenario::name_of(seed.ending),
                     seed.cause.empty() ? "" : ": ", seed.cause);
}

std::optional<double> tolerated_factor(const Gate& gate) {
  const score::Direction direction = score::direction_of(gate.metric);
  if (direction.worst != score::Worst::farthest_from_expected) return std::nullopt;
  return 1 + std::max(gate.absolute / direction.expected, gate.percent / 100);
}

std::string_view word(Verdict verdict) {
  static constexpr std::array<std::string_view, 7> kWords{"IDENTICAL", "SAME", "BETTER", "FAIL",
                                                          "NOISY",     "NEW",  "MISSING"};
  return kWords[static_cast<std::size_t>(verdict)];
}

bool fails(Verdict verdict) { return verdict == Verdict::fail || verdict == Verdict::missing; }

const std::vector<Gate>& default_gates() {
  static const std::vector<Gate> gates{{"ate_se3_rmse_m", 10, 0.001},   {"rmse_m", 15, 0.002},
                                       {"rpe_1m_m", 10, 0.001},         {"end_yaw_error_deg", 20, 0.1},
                                       {"nees_position_mean", 30, 0.5}, {"loop_landmarks", 20, 2}};
  return gates;
}

ScenarioVerdict compare(const ScenarioResults& baseline, const ScenarioResults& now,
                        const std::vector<Gate>& gates) {
  ScenarioVerdict result;
  result.name = now.name;
  std::size_t common = 0;
  for (const result::SeedScore& seed : now.seeds) {
    const result::SeedScore* other = baseline.find(seed.seed);
    if (!other) continue;
    ++common;
    result.other_recordings += other->recording != seed.recording;
  }
  result.paired = common > 0;
  result.n_baseline = result.paired ? common : baseline.seeds.size();
  result.n_now = result.paired ? common : now.seeds.size();
  result.other_config = config_differences(baseline.config, now.config);
  for (const result::SeedScore& seed : now.seeds) result.wall_s += seed.wall_s;
  result.metrics = judge_gates(baseline, now, gates, result.paired);
  return result;
}

ScenarioVerdict without_counterpart(const ScenarioResults& there, const std::vector<Gate>& gates,
                                    Verdict verdict) {
  ScenarioVerdict result;
  result.name = there.name;
  result.n_now = verdict == Verdict::added ? there.seeds.size() : 0;
  result.n_baseline = verdict == Verdict::added ? 0 : there.seeds.size();
  if (verdict == Verdict::added)
    for (const result::SeedScore& seed : there.seeds) result.wall_s += seed.wall_s;
  for (const Gate& gate : gates) {
    MetricVerdict v{gate};
    std::vector<double> values;
    for (const result::SeedScore& seed : there.seeds)
      if (const auto value = seed.value(gate.metric)) values.push_back(*value);
    v.n = values.size();
    if (!values.empty()) (verdict == Verdict::added ? v.now : v.baseline) = score::median(values);
    v.verdict = verdict;
    if (verdict == Verdict::missing) v.remark = "the scenario was not run";
    result.metrics.push_back(v);
  }
  return result;
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

}  // namespace sim::regression
