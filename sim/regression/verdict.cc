#include "sim/regression/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "sim/files/text.h"
#include "sim/score/metrics.h"
#include "sim/score/statistics.h"

namespace sim::regression {
namespace {

constexpr double kLevel = 0.05;

// A metric's values on the seeds that both sides have.
struct Values {
  std::vector<std::uint64_t> seeds;
  std::vector<double> baseline, now;
  std::vector<double> lost;  // values of the baseline that have gone
  std::size_t won = 0;       // values that only the results have
  std::string why_lost;      // how the first run without its value ended
  bool identical = true;
};

Values values_of(const ScenarioResults& baseline, const ScenarioResults& now, const std::string& metric) {
  Values values;
  for (const result::SeedScore& seed : now.seeds) {
    const result::SeedScore* other = baseline.find(seed.seed);
    if (!other) continue;
    const auto a = other->value(metric), b = seed.value(metric);
    values.identical &= a == b;
    if (a && b) {
      values.seeds.push_back(seed.seed);
      values.baseline.push_back(*a);
      values.now.push_back(*b);
    } else if (a) {
      if (values.lost.empty()) values.why_lost = ending_text(seed);
      values.lost.push_back(*a);
    } else {
      values.won += b.has_value();
    }
  }
  return values;
}

// By how much each seed increased; on the losses by how much it got worse.
std::vector<double> differences(const Values& values, const std::function<double(double)>& of) {
  std::vector<double> all;
  for (std::size_t i = 0; i < values.now.size(); ++i)
    all.push_back(of(values.now[i]) - of(values.baseline[i]));
  return all;
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

// The verdict on a metric, before its p-value is adjusted.
struct Judged {
  MetricVerdict verdict;
  double worse_by = 0;  // the increase of its loss
  bool tested = false;
};

Judged judge(const Gate& gate, const Values& values) {
  Judged judged{{gate}};
  MetricVerdict& v = judged.verdict;
  v.n = values.now.size();
  if (v.n > 0) {
    v.baseline = score::median(values.baseline);
    v.now = score::median(values.now);
    const auto worse_by = differences(
        values, [&](double value) { return score::loss(value, score::direction_of(gate.metric)); });
    const auto changes = differences(values, [](double value) { return value; });
    judged.worse_by = score::median(worse_by);
    v.change = score::median(changes);
    v.band = score::median_interval(changes);
    v.worst_seed = values.seeds[static_cast<std::size_t>(std::max_element(worse_by.begin(), worse_by.end()) -
                                                         worse_by.begin())];
    if (v.n >= kSeedsForTest)
      v.p = score::wilcoxon_signed_rank(worse_by);
    else
      v.verdict = by_seeds(worse_by, tolerance(gate, *v.baseline), v.remark);
  } else if (values.identical) {
    v.remark = "no run has a value";
  }
  if (values.identical) {
    v.verdict = Verdict::identical;
  } else if (!values.lost.empty()) {
    v.verdict = Verdict::missing;
    v.remark =
        fmt::format("{} lost the value: {}", files::counted(values.lost.size(), "seed"), values.why_lost);
    if (!v.baseline) v.baseline = score::median(values.lost);
  } else {
    judged.tested = v.p.has_value();
    if (v.n == 0) v.verdict = Verdict::added;
    if (v.n > 0 && values.won > 0)
      v.remark = fmt::format("{} got a value that had none before", files::counted(values.won, "seed"));
  }
  if (!judged.tested) v.p.reset();
  return judged;
}

void decide(Judged& judged) {
  MetricVerdict& v = judged.verdict;
  if (std::abs(judged.worse_by) <= tolerance(v.gate, *v.baseline)) {
    v.verdict = Verdict::same;
  } else if (*v.p >= kLevel) {
    v.verdict = Verdict::noisy;
    v.remark = "not significant: more seeds are needed";
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
                                       const std::vector<Gate>& gates) {
  std::vector<Judged> judged;
  std::vector<double> p;
  for (const Gate& gate : gates) {
    judged.push_back(judge(gate, values_of(baseline, now, gate.metric)));
    p.push_back(judged.back().verdict.p.value_or(1));
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

// The verdict on gates of a scenario that only one side has.
std::vector<MetricVerdict> one_sided(const std::vector<result::SeedScore>& seeds,
                                     const std::vector<Gate>& gates, Verdict verdict) {
  std::vector<MetricVerdict> verdicts;
  for (const Gate& gate : gates) {
    MetricVerdict v{.gate = gate,
                    .verdict = verdict,
                    .remark = verdict == Verdict::missing ? "the scenario was not run" : ""};
    std::vector<double> values;
    for (const result::SeedScore& seed : seeds)
      if (const auto value = seed.value(gate.metric)) values.push_back(*value);
    v.n = values.size();
    if (v.n > 0) (verdict == Verdict::added ? v.now : v.baseline) = score::median(values);
    verdicts.push_back(v);
  }
  return verdicts;
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

std::vector<std::string> config_differences(const std::map<std::string, std::string>& baseline,
                                            const std::map<std::string, std::string>& now) {
  const auto text = [](const auto& config, const std::string& key) {
    const auto found = config.find(key);
    return found == config.end() ? std::string("not set") : found->second;
  };
  std::map<std::string, std::string> keys = baseline;
  keys.insert(now.begin(), now.end());
  std::vector<std::string> all;
  for (const auto& [key, value] : keys)
    if (text(baseline, key) != text(now, key))
      all.push_back(fmt::format("{}: {} -> {}", key, text(baseline, key), text(now, key)));
  return all;
}

ScenarioVerdict compare(const ScenarioResults& baseline, const ScenarioResults& now,
                        const std::vector<Gate>& gates) {
  ScenarioVerdict verdict;
  verdict.name = now.name;
  std::size_t common = 0;
  for (const result::SeedScore& seed : now.seeds) {
    const result::SeedScore* other = baseline.find(seed.seed);
    common += other != nullptr;
    verdict.other_recordings += other && other->recording != seed.recording;
    verdict.wall_s += seed.wall_s;
  }
  if (common > 0) {
    verdict.n_baseline = verdict.n_now = common;
    verdict.other_config = config_differences(baseline.config, now.config);
    verdict.metrics = judge_gates(baseline, now, gates);
  } else if (now.seeds.empty()) {
    verdict.n_baseline = baseline.seeds.size();
    verdict.metrics = one_sided(baseline.seeds, gates, Verdict::missing);
  } else {
    verdict.n_now = now.seeds.size();
    verdict.metrics = one_sided(now.seeds, gates, Verdict::added);
  }
  return verdict;
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
