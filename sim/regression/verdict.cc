#include "sim/regression/verdict.h"

#include <fmt/ranges.h>

#include <set>

#include "sim/result/limits.h"
#include "sim/scenario/keys.h"
#include "sim/score/metrics.h"

namespace sim::regression {
namespace {

constexpr double kLevel = 0.05;

// "seed 4 fell: CAUSE", without the last lines of a program.
std::string ending_text(const result::SeedScore& seed) {
  return fmt::format("seed {} {}{}{}", seed.seed, scenario::name_of(seed.ending),
                     seed.cause.empty() ? "" : ": ",
                     seed.cause.substr(0, seed.cause.find(result::kLastLines)));
}

// A metric's values for the seeds that both sides have.
struct Values {
  std::vector<std::uint64_t> seeds;
  std::vector<double> baseline, now;          // magnitudes if a larger magnitude is worse
  std::vector<double> changes, worse_by;      // by how much each value and its loss increased
  std::vector<double> lost;                   // the baseline's values that are now missing
  std::size_t won = 0;                        // number of values that only the results have
  std::optional<std::uint64_t> first_lost{};  // the first seed that lost its value
  std::string why_lost;                       // how its run ended
  bool identical = true;

  bool empty() const { return now.empty() && lost.empty() && won == 0; }
};

Values values_of(const ScenarioResults& baseline, const ScenarioResults& now, const std::string& metric) {
  const score::Direction direction = score::direction_of(metric);
  const auto judged = [&](double value) {
    return direction.worst == score::Worst::largest_magnitude ? std::abs(value) : value;
  };
  Values values;
  for (const result::SeedScore& seed : now.seeds) {
    const result::SeedScore* other = baseline.find(seed.seed);
    if (!other) continue;
    const auto a = other->value(metric), b = seed.value(metric);
    values.identical &= a == b;
    if (a && b) {
      values.seeds.push_back(seed.seed);
      values.baseline.push_back(judged(*a));
      values.now.push_back(judged(*b));
      values.changes.push_back(values.now.back() - values.baseline.back());
      values.worse_by.push_back(score::loss(*b, direction) - score::loss(*a, direction));
    } else if (a) {
      if (values.lost.empty()) values.first_lost = seed.seed, values.why_lost = ending_text(seed);
      values.lost.push_back(*a);
    } else {
      values.won += b.has_value();
    }
  }
  return values;
}

// The p-value of the change of a mean's distance from the expected value, by t-tests on jackknife
// pseudo-values (Tukey 1958). |a| > |b| means a + b > 0 and a - b > 0. Both are tested, because |b| has a
// kink at 0.
double p_of_means(const Values& values, double expected) {
  using Seed = std::optional<std::size_t>;
  const auto log_ratio = [&](std::vector<double> of, Seed without) {
    if (without) of.erase(of.begin() + std::ptrdiff_t(*without));
    return std::log(std::max(score::mean(of), std::numeric_limits<double>::min()) / expected);
  };
  const bool worse = std::abs(log_ratio(values.now, {})) > std::abs(log_ratio(values.baseline, {}));
  const auto &far = worse ? values.now : values.baseline, &near = worse ? values.baseline : values.now;
  const double side = log_ratio(far, {}) > 0 ? 1 : -1, n = double(far.size());
  double p = 0;
  for (const double sign : {1.0, -1.0}) {
    const auto contrast = [&](Seed without) {
      return side * log_ratio(far, without) + sign * log_ratio(near, without);
    };
    std::vector<double> pseudo_values;
    for (std::size_t i = 0; i < far.size(); ++i)
      pseudo_values.push_back(n * contrast({}) - (n - 1) * contrast(i));
    p = std::max(p, score::t_test(pseudo_values)->p);
  }
  return p;
}

// The p-value before Holm's adjustment; absent if there are too few seeds. With a consistent filter, the mean
// NEES of a single run is between 1.0 and 5.8 where 3 is expected, so the mean over seeds is tested, not each
// run.
std::optional<double> p_of(const Gate& gate, const Values& values) {
  if (values.identical || !values.lost.empty()) return std::nullopt;
  if (tolerated_factor(gate)) {
    if (values.now.size() < 2) return std::nullopt;
    return p_of_means(values, score::direction_of(gate.metric).expected);
  }
  if (values.now.size() < kSeedsForTest) return std::nullopt;
  return score::wilcoxon_signed_rank(values.worse_by);
}

// How much the loss may grow.
double tolerance(const Gate& gate, double baseline) {
  if (const auto factor = tolerated_factor(gate)) return std::log(*factor);
  return std::max(gate.absolute, gate.percent / 100 * std::abs(baseline));
}

// Fills in the numbers and the verdict for a change on v.n > 0 seeds. p: after Holm's adjustment; absent
// without a test.
void judge_change(MetricVerdict& v, const Values& values, const std::optional<double>& p) {
  const score::Direction direction = score::direction_of(v.gate.metric);
  const bool of_means = tolerated_factor(v.gate).has_value();
  const auto middle =
      of_means ? score::mean : [](const std::vector<double>& all) { return score::median(all); };
  v.baseline = middle(values.baseline);
  v.now = middle(values.now);
  const score::Shift shift =
      of_means ? score::Shift{*v.now - *v.baseline} : score::hodges_lehmann(values.changes);
  v.change = shift.estimate, v.band = shift.interval, v.coverage = shift.coverage;
  const auto worst = std::ranges::max_element(values.worse_by) - values.worse_by.begin();
  v.worst_seed = values.seeds[std::size_t(worst)];
  v.p = p;
  const double tolerated = tolerance(v.gate, *v.baseline),
               worse = of_means ? score::loss(*v.now, direction) - score::loss(*v.baseline, direction)
                                : score::hodges_lehmann(values.worse_by).estimate;
  const auto n_worse = std::ranges::count_if(values.worse_by, [&](double d) { return d > tolerated; }),
             n_better = std::ranges::count_if(values.worse_by, [&](double d) { return d < -tolerated; });
  if (!p && !of_means && n_worse + n_better > 0)
    v.remark = fmt::format("{} of {} worse beyond tolerance, {} better", n_worse, files::counted(v.n, "seed"),
                           n_better);
  const bool decided = p ? *p < kLevel : !of_means && (worse > 0 ? n_better : n_worse) == 0;
  v.verdict = std::abs(worse) <= tolerated ? Verdict::same
              : !decided                   ? Verdict::undecided
              : worse > 0                  ? Verdict::fail
                                           : Verdict::better;
  if (v.verdict == Verdict::undecided && (p || of_means)) v.remark = "not significant: more seeds are needed";
}

MetricVerdict judge(const Gate& gate, const Values& values, const std::optional<double>& p) {
  MetricVerdict v{.gate = gate, .n = values.now.size()};
  if (v.n > 0) judge_change(v, values, p);
  if (values.identical) {
    v.verdict = Verdict::identical, v.band.reset();
  } else if (!values.lost.empty()) {
    v.verdict = Verdict::missing;
    v.worst_seed = values.first_lost;
    v.remark =
        fmt::format("{} lost the value: {}", files::counted(values.lost.size(), "seed"), values.why_lost);
    if (!v.baseline) v.baseline = score::median(values.lost);
  } else if (v.n == 0) {
    v.verdict = Verdict::added;
  } else if (values.won > 0) {
    v.remark = fmt::format("{} got a value for the first time", files::counted(values.won, "seed"));
  }
  return v;
}

// Adds how far the means are from the expected value, if there is one.
void add_distances(MetricVerdict& v) {
  using enum Verdict;
  const score::Direction direction = score::direction_of(v.gate.metric);
  const auto factor = [&](double value) { return std::exp(score::loss(value, direction)); };
  if (tolerated_factor(v.gate) && (v.verdict == better || v.verdict == fail || v.verdict == undecided))
    v.remark = fmt::format("{} expected, off by a factor of {:.3g} before, {:.3g} now{}", direction.expected,
                           factor(*v.baseline), factor(*v.now), v.remark.empty() ? "" : "; " + v.remark);
}

std::vector<MetricVerdict> judge_gates(const ScenarioResults& baseline, const ScenarioResults& now,
                                       const std::vector<Gate>& gates) {
  std::vector<Values> values;
  std::vector<std::optional<double>> tested;
  std::vector<double> p;
  for (const Gate& gate : gates) {
    values.push_back(values_of(baseline, now, gate.metric));
    tested.push_back(p_of(gate, values.back()));
    p.push_back(tested.back().value_or(1));
  }
  p = score::holm(p);
  std::vector<MetricVerdict> verdicts;
  for (std::size_t i = 0; i < gates.size(); ++i)
    if (!values[i].empty())
      add_distances(
          verdicts.emplace_back(judge(gates[i], values[i], tested[i] ? std::optional(p[i]) : std::nullopt)));
  return verdicts;
}

// The verdict on gates of a scenario that exists on only one side.
std::vector<MetricVerdict> one_sided(const std::vector<result::SeedScore>& seeds,
                                     const std::vector<Gate>& gates, Verdict verdict) {
  std::vector<MetricVerdict> verdicts;
  for (const Gate& gate : gates) {
    MetricVerdict v{.gate = gate,
                    .verdict = verdict,
                    .remark = verdict == Verdict::missing ? "the scenario was not run" : ""};
    const std::vector<double> values = result::values_of(gate.metric, seeds);
    if (values.empty()) continue;
    v.n = values.size();
    const bool of_means = tolerated_factor(gate).has_value(), added = verdict == Verdict::added;
    const double middle = of_means ? score::mean(values) : score::median(values);
    (added ? v.now : v.baseline) = middle;
    if (added)
      v.remark = fmt::format("{} of {}: {}", of_means ? "mean" : "median", files::counted(v.n, "seed"),
                             result::number_text(middle));
    verdicts.push_back(v);
  }
  return verdicts;
}

LimitVerdict endings(const scenario::Scenario& scenario, const std::vector<result::SeedScore>& seeds) {
  LimitVerdict verdict;
  verdict.what = fmt::format("ending {}", fmt::join(scenario.limits.ending, " or "));
  std::set<std::string> shown{""};  // the last lines of the texts: they name the exceptions
  for (const result::SeedScore& seed : seeds) {
    if (result::is_allowed(scenario, seed.ending)) continue;
    if (!verdict.worst_seed) verdict.worst_seed = seed.seed;
    const auto lines = files::lines_of(seed.last_lines);
    const bool is_new = shown.insert(lines.empty() ? "" : lines.back()).second;
    verdict.failures.push_back(ending_text(seed) + (is_new ? "\nits last lines:\n" + seed.last_lines : ""));
  }
  verdict.state = verdict.worst_seed ? LimitState::run_failed : LimitState::met;
  verdict.observed = fmt::format("{}/{}", seeds.size() - verdict.failures.size(), seeds.size());
  return verdict;
}

// Returns the verdict on a limit, with the seed that has the worst value. A missing value is worse than any
// other.
LimitVerdict verdict_on(const scenario::MetricLimit& limit, const std::string& observed, LimitState state,
                        const std::vector<result::SeedScore>& seeds) {
  const auto loss = [&](const result::SeedScore& seed) {
    const auto value = seed.value(limit.metric);
    return value ? score::loss(*value, result::worst_side(limit)) : std::numeric_limits<double>::max();
  };
  LimitVerdict verdict{fmt::format("{} {} {}", subject(limit),
                                   limit.bound == scenario::Bound::at_most ? "<=" : ">=", limit.value),
                       observed, state};
  if (state != LimitState::met && !seeds.empty())
    verdict.worst_seed = std::ranges::max_element(seeds, {}, loss)->seed;
  return verdict;
}

LimitState met_if(bool met) { return met ? LimitState::met : LimitState::missed; }

// Returns the verdict on a limit for a metric with an expected value, from its mean. Each seed has a value.
LimitVerdict verdict_on_mean(scenario::MetricLimit limit, const std::vector<result::SeedScore>& seeds) {
  limit.aggregate = "mean";
  const std::vector<double> values = result::values_of(limit.metric, seeds);
  const score::MeanTest test = score::t_test(values).value();
  const double mean = score::mean(values);
  const LimitState state = keeps(limit, mean)                                  ? LimitState::met
                           : keeps(limit, test.low) || keeps(limit, test.high) ? LimitState::undecided
                                                                               : LimitState::missed;
  return verdict_on(limit, fmt::format("{:.3g} [{:.3g}, {:.3g}]", mean, test.low, test.high), state, seeds);
}

LimitVerdict missed_by_all(const scenario::Scenario& scenario, const std::vector<result::SeedScore>& seeds) {
  LimitVerdict verdict;
  verdict.what = "misses a limit";
  std::size_t missed = 0;
  for (const result::SeedScore& seed : seeds)
    if (std::ranges::any_of(result::judge_run(scenario, [&](const auto& m) { return seed.value(m); }),
                            &result::JudgedLimit::missed))
      ++missed;
    else if (!verdict.worst_seed)
      verdict.worst_seed = seed.seed;
  verdict.state = met_if(missed == seeds.size());
  verdict.observed = fmt::format("{}/{}", missed, seeds.size());
  return verdict;
}

}  // namespace

std::optional<double> tolerated_factor(const Gate& gate) {
  const score::Direction direction = score::direction_of(gate.metric);
  if (direction.worst != score::Worst::farthest_from_expected) return std::nullopt;
  return 1 + std::max(gate.absolute / direction.expected, gate.percent / 100);
}

std::string_view word(Verdict verdict) {
  static constexpr std::array<std::string_view, 7> kWords{"IDENTICAL", "SAME", "BETTER", "FAIL",
                                                          "UNDECIDED", "NEW",  "MISSING"};
  return kWords[std::size_t(verdict)];
}

std::vector<std::string> config_differences(const std::map<std::string, std::string>& baseline,
                                            const std::map<std::string, std::string>& now) {
  const auto text = [](const auto& config, const std::string& name) {
    if (const auto found = config.find(name); found != config.end()) return found->second;
    const scenario::Key* key = scenario::find_key(name);
    return key ? key->print(scenario::default_scenario()) + " (default)" : "not set";
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
  std::vector<double> covered_before, covered_now;
  for (const result::SeedScore& seed : now.seeds) {
    verdict.wall_s += seed.wall_s;
    const result::SeedScore* other = baseline.find(seed.seed);
    if (!other) continue;
    ++common;
    verdict.other_recordings += other->recording != seed.recording;
    const auto before = other->coverage(), after = seed.coverage();
    if (!before && !after) continue;
    covered_before.push_back(before.value_or(0));
    covered_now.push_back(after.value_or(0));
  }
  if (common > 0) {
    verdict.n_baseline = verdict.n_now = common;
    if (!covered_now.empty())
      verdict.coverage = std::pair(score::mean(covered_before), score::mean(covered_now));
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

std::string word(LimitState state) {
  static constexpr std::array<const char*, 4> kWords{"ok", "MISSED", "UNDECIDED", "RUN FAILED"};
  return kWords[std::size_t(state)];
}

std::vector<LimitVerdict> judge_limits(const scenario::Scenario& scenario,
                                       const std::vector<result::SeedScore>& seeds, bool expects_missed) {
  std::vector<LimitVerdict> all{endings(scenario, seeds)};
  if (expects_missed) {
    all.push_back(missed_by_all(scenario, seeds));
    return all;
  }
  // Too many runs of a consistent filter exceed a limit on NEES or NIS, so with two or more seeds their mean
  // is judged.
  const auto judges_mean = [&](const scenario::MetricLimit& limit) {
    return score::direction_of(limit.metric).worst == score::Worst::farthest_from_expected &&
           limit.aggregate.value_or("mean") == "mean" && seeds.size() > 1 &&
           result::values_of(limit.metric, seeds).size() == seeds.size();
  };
  for (const scenario::MetricLimit& limit : scenario.limits.metrics) {
    if (judges_mean(limit)) all.push_back(verdict_on_mean(limit, seeds));
    if (limit.aggregate || judges_mean(limit)) continue;
    std::size_t judged = 0, met = 0;
    for (const result::SeedScore& seed : seeds) {
      const auto passed = result::judge(scenario, limit, seed.value(limit.metric)).passed;
      judged += passed.has_value();
      met += passed.value_or(false);
    }
    if (judged > 0 || scenario.slam)
      all.push_back(verdict_on(limit, fmt::format("{}/{}", met, judged), met_if(met == judged), seeds));
  }
  for (const result::JudgedLimit& judged : result::summarize(scenario, seeds).limits) {
    if (judges_mean(judged.limit)) continue;
    const std::string reason = judged.reason.value_or("no value");
    all.push_back(verdict_on(judged.limit, judged.value ? fmt::format("{:.4g}", *judged.value) : reason,
                             met_if(!judged.missed()), seeds));
  }
  return all;
}

}  // namespace sim::regression
