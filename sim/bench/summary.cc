#include "sim/bench/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "sim/bench/scenario_limits.h"
#include "sim/stream/durable_file.h"

namespace sim::bench {
namespace {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

score::Worst worst_side(const std::string& metric, const Scenario& scenario) {
  for (const MetricLimit& limit : scenario.limits.metrics) {
    if (limit.metric == metric)
      return limit.bound == Bound::at_most ? score::Worst::largest : score::Worst::smallest;
  }
  return score::Worst::largest_magnitude;
}

std::vector<double> values_of(const std::string& metric, const std::vector<SeedScore>& seeds) {
  std::vector<double> values;
  for (const SeedScore& seed : seeds) {
    for (const SeedMetric& m : seed.metrics) {
      if (m.name == metric && m.value) values.push_back(*m.value);
    }
  }
  return values;
}

std::optional<double> aggregate(const score::Summary& over_seeds, const std::string& name) {
  if (over_seeds.n == 0) return std::nullopt;
  return name == "median" ? over_seeds.median : name == "mean" ? over_seeds.mean : over_seeds.worst;
}

JudgedLimit judge(const MetricLimit& limit, const std::vector<MetricSummary>& metrics,
                  bool filter_was_to_run) {
  JudgedLimit judged{limit, {}, {}};
  for (const MetricSummary& metric : metrics) {
    if (metric.name == limit.metric) judged.value = aggregate(metric.over_seeds, limit.aggregate);
  }
  if (judged.value || filter_was_to_run) judged.passed = judged.value && keeps(limit, *judged.value);
  return judged;
}

ordered_json json_of(const MetricSummary& metric) {
  const auto& [n, median, mean, sd, worst] = metric.over_seeds;
  if (n == 0)
    return {{"unit", metric.unit}, {"n", 0},        {"median", nullptr},
            {"mean", nullptr},     {"sd", nullptr}, {"worst", nullptr}};
  return {{"unit", metric.unit}, {"n", n}, {"median", median}, {"mean", mean}, {"sd", sd}, {"worst", worst}};
}

ordered_json json_of(const std::optional<double>& value) {
  return value ? ordered_json(*value) : ordered_json(nullptr);
}

ordered_json json_of(const JudgedLimit& judged) {
  return {{"metric", subject(judged.limit)},
          {std::string(word(judged.limit.bound)), judged.limit.value},
          {"value", json_of(judged.value)},
          {"passed", judged.passed ? ordered_json(*judged.passed) : ordered_json(nullptr)}};
}

std::string number(const std::optional<double>& value) { return value ? fmt::format("{:.4g}", *value) : "-"; }

std::string row(const MetricSummary& metric) {
  const score::Summary& s = metric.over_seeds;
  if (s.n == 0) return fmt::format("{:<26} {:<5} {:>3}\n", metric.name, metric.unit, 0);
  return fmt::format("{:<26} {:<5} {:>3} {:>10.4g} {:>10.4g} {:>10.4g} {:>10.4g}\n", metric.name, metric.unit,
                     s.n, s.median, s.mean, s.standard_deviation, s.worst);
}

}  // namespace

SeedScore read_score(const fs::path& file) {
  std::ifstream in(file);
  if (!in) throw stream::FileError(file, "cannot be read");
  try {
    const ordered_json json = ordered_json::parse(in);
    SeedScore score{json.value("seed", std::uint64_t{0}), json.at("ending"), 0, {}};
    for (const auto& [name, metric] : json.at("metrics").items()) {
      const ordered_json& value = metric.at("value");
      score.metrics.push_back(
          {name, metric.at("unit"), value.is_null() ? std::nullopt : std::optional(value.get<double>())});
    }
    return score;
  } catch (const ordered_json::exception& e) {
    throw stream::FileError(file, e.what());
  }
}

SeedScore read_seed_score(const fs::path& root, std::uint64_t seed, int exit_code) {
  const fs::path file = root / fmt::format("seed-{}", seed) / "score.json";
  if (!fs::exists(file) && exit_code > 1)
    return {seed, exit_code == 2 ? "not begun" : "crashed", exit_code, {}};
  SeedScore score = read_score(file);
  score.seed = seed;
  score.exit_code = exit_code;
  return score;
}

Summary summarize(const Scenario& scenario, const std::vector<SeedScore>& seeds) {
  Summary summary{scenario.name, seeds, {}, {}};
  const auto fullest = std::max_element(
      seeds.begin(), seeds.end(),
      [](const SeedScore& a, const SeedScore& b) { return a.metrics.size() < b.metrics.size(); });
  if (fullest != seeds.end()) {
    for (const SeedMetric& metric : fullest->metrics) {
      summary.metrics.push_back(
          {metric.name, metric.unit,
           score::summarise(values_of(metric.name, seeds), worst_side(metric.name, scenario))});
    }
  }
  for (const MetricLimit& limit : scenario.limits.metrics) {
    if (!limit.aggregate.empty())
      summary.limits.push_back(judge(limit, summary.metrics, scenario.slam.has_value()));
  }
  return summary;
}

int exit_code(const Summary& summary) {
  int worst = 0;
  for (const SeedScore& seed : summary.seeds) worst = std::max(worst, seed.exit_code);
  for (const JudgedLimit& limit : summary.limits)
    worst = std::max(worst, limit.passed.value_or(true) ? 0 : 1);
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
  for (const JudgedLimit& limit : summary.limits) json["limits"].push_back(json_of(limit));
  stream::write_durably(file, json.dump(2) + "\n");
}

std::string summary_table(const Summary& summary) {
  std::string text = fmt::format("{}, {} seeds\n", summary.scenario, summary.seeds.size());
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
                        limit.limit.value, number(limit.value),
                        !limit.passed   ? "not judged"
                        : *limit.passed ? "ok"
                                        : "MISSED");
  }
  return text;
}

}  // namespace sim::bench
