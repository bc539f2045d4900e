#include "sim/regression/verdict.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim/score/statistics.h"

namespace sim::regression {
namespace {

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
  result.metrics = judge_gates(baseline, now, gates, result.paired);
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
    for (const result::SeedScore& seed : there.seeds)
      if (const auto value = seed.value(gate.metric)) values.push_back(*value);
    v.n = values.size();
    if (!values.empty()) (verdict == Verdict::added ? v.now : v.baseline) = score::median(values);
    v.verdict = verdict;
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
