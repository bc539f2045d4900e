#include "sim/result/summary.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim/files/durable_file.h"
#include "sim/files/number.h"
#include "sim/result/json.h"
#include "sim/scenario/limits.h"
#include "sim/score/evaluate.h"

namespace sim::result {
namespace {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

score::Direction direction_of(const std::string& metric, const scenario::Scenario& scenario) {
  const score::Direction own = score::direction_of(metric);
  if (own.worst == score::Worst::farthest_from_expected) return own;
  for (const scenario::MetricLimit& limit : scenario.limits.metrics)
    if (limit.metric == metric) return worst_side(limit);
  return own;
}

std::vector<double> values_of(const std::string& metric, const std::vector<SeedScore>& seeds) {
  std::vector<double> values;
  for (const SeedScore& seed : seeds)
    if (const auto value = seed.value(metric)) values.push_back(*value);
  return values;
}

// The value over seeds that a limit is on; the worst is the one nearest to missing this limit.
std::optional<double> aggregate(const scenario::MetricLimit& limit, const std::vector<SeedScore>& seeds) {
  const score::Summary over_seeds = score::summarise(values_of(limit.metric, seeds), worst_side(limit));
  if (over_seeds.n == 0) return std::nullopt;
  return limit.aggregate == "median" ? over_seeds.median
         : limit.aggregate == "mean" ? over_seeds.mean
                                     : over_seeds.worst;
}

ordered_json json_of(const MetricSummary& metric) {
  const score::Summary& s = metric.over_seeds;
  if (s.n == 0)
    return {{"unit", metric.unit}, {"n", 0},        {"median", nullptr},
            {"mean", nullptr},     {"sd", nullptr}, {"worst", nullptr}};
  return {{"unit", metric.unit},
          {"n", s.n},
          {"median", s.median},
          {"mean", s.mean},
          {"sd", or_null(s.standard_deviation)},
          {"worst", s.worst}};
}

std::string number(const std::optional<double>& value) { return value ? fmt::format("{:.4g}", *value) : "-"; }

std::string row(const MetricSummary& metric) {
  const score::Summary& s = metric.over_seeds;
  if (s.n == 0) return fmt::format("{:<26} {:<5} {:>3}\n", metric.name, metric.unit, 0);
  return fmt::format("{:<26} {:<5} {:>3} {:>10.4g} {:>10.4g} {:>10} {:>10.4g}\n", metric.name, metric.unit,
                     s.n, s.median, s.mean, number(s.standard_deviation), s.worst);
}

}  // namespace

Summary summarize(const scenario::Scenario& scenario, const std::vector<SeedScore>& seeds) {
  Summary summary{scenario.name, seeds, {}, {}};
  const auto fullest = std::max_element(
      seeds.begin(), seeds.end(),
      [](const SeedScore& a, const SeedScore& b) { return a.metrics.size() < b.metrics.size(); });
  if (fullest != seeds.end()) {
    for (const SeedMetric& metric : fullest->metrics) {
      summary.metrics.push_back(
          {metric.name, metric.unit,
           score::summarise(values_of(metric.name, seeds), direction_of(metric.name, scenario))});
    }
  }
  for (const scenario::MetricLimit& limit : scenario.limits.metrics) {
    if (!limit.aggregate.empty()) summary.limits.push_back(judge(scenario, limit, aggregate(limit, seeds)));
  }
  return summary;
}

int exit_code(const Summary& summary) {
  int worst = 0;
  for (const SeedScore& seed : summary.seeds) worst = std::max(worst, seed.exit_code);
  for (const JudgedLimit& limit : summary.limits) worst = std::max(worst, limit.missed() ? 1 : 0);
  return worst;
}

void write_summary(const fs::path& file, const Summary& summary) {
  ordered_json json{{"format_version", 1}, {"scenario", summary.scenario}};
  json["seeds"] = ordered_json::array();
  for (const SeedScore& seed : summary.seeds) {
    json["seeds"].push_back({{"seed", seed.seed}, {"ending", seed.ending}, {"exit_code", seed.exit_code}});
  }
  json["metrics"] = ordered_json::object();
  for (const MetricSummary& m : summary.metrics) {
    json["metrics"][m.name] = json_of(m);
  }
  json["limits"] = ordered_json::array();
  for (const JudgedLimit& limit : summary.limits) json["limits"].push_back(to_json(limit));
  files::write_durably(file, json.dump(2) + "\n");
}

std::string summary_table(const Summary& summary) {
  std::string text = fmt::format("{}, {}\n", summary.scenario, files::counted(summary.seeds.size(), "seed"));
  for (const SeedScore& seed : summary.seeds) {
    text += fmt::format("  seed {:<6} {:<10} exit {}\n", seed.seed, seed.ending, seed.exit_code);
  }
  text += fmt::format("\n{:<26} {:<5} {:>3} {:>10} {:>10} {:>10} {:>10}\n", "metric", "unit", "n", "median",
                      "mean", "sd", "worst");
  for (const MetricSummary& m : summary.metrics) {
    text += row(m);
  }
  for (const JudgedLimit& limit : summary.limits) {
    text += fmt::format("limit {} {} {}: {}  {}\n", subject(limit.limit), word(limit.limit.bound),
                        limit.limit.value, number(limit.value), verdict_word(limit.passed));
  }
  return text;
}

}  // namespace sim::result
