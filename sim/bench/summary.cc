#include "sim/bench/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>

#include "sim/bench/scenario_limits.h"
#include "sim/stream/durable_file.h"

namespace sim::bench {
namespace {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double median_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

double sd_of(const std::vector<double>& values) {
  const double mean = mean_of(values);
  double sum = 0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

double worst_of(const std::vector<double>& values, const std::string& metric, const Scenario& scenario) {
  for (const MetricLimit& limit : scenario.limits.metrics) {
    if (limit.metric != metric) continue;
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    return limit.bound == Bound::at_most ? *most : *least;
  }
  return *std::max_element(values.begin(), values.end(),
                           [](double a, double b) { return std::abs(a) < std::abs(b); });
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

MetricSummary summarize_metric(const SeedMetric& metric, const Scenario& scenario,
                               const std::vector<SeedScore>& seeds) {
  const std::vector<double> values = values_of(metric.name, seeds);
  MetricSummary summary{metric.name, metric.unit, values.size(), {}, {}, {}, {}};
  if (values.empty()) return summary;
  summary.median = median_of(values);
  summary.mean = mean_of(values);
  if (values.size() > 1) summary.sd = sd_of(values);
  summary.worst = worst_of(values, metric.name, scenario);
  return summary;
}

JudgedLimit judge(const MetricLimit& limit, const std::vector<MetricSummary>& metrics) {
  JudgedLimit judged{limit, {}, false};
  for (const MetricSummary& metric : metrics) {
    if (metric.name != limit.metric) continue;
    judged.value = limit.aggregate == "median" ? metric.median
                   : limit.aggregate == "mean" ? metric.mean
                                               : metric.worst;
  }
  if (judged.value) {
    judged.passed =
        limit.bound == Bound::at_most ? *judged.value <= limit.value : *judged.value >= limit.value;
  }
  return judged;
}

ordered_json json_of(const std::optional<double>& value) {
  return value ? ordered_json(*value) : ordered_json(nullptr);
}

ordered_json json_of(const JudgedLimit& judged) {
  return {{"metric", subject(judged.limit)},
          {std::string(word(judged.limit.bound)), judged.limit.value},
          {"value", json_of(judged.value)},
          {"passed", judged.passed}};
}

std::string number(const std::optional<double>& value) { return value ? fmt::format("{:.4g}", *value) : "-"; }

}  // namespace

SeedScore read_seed_score(const fs::path& root, std::uint64_t seed, int exit_code) {
  SeedScore score{seed, exit_code == 2 ? "not begun" : "crashed", exit_code, {}};
  const fs::path file = root / fmt::format("seed-{}", seed) / "score.json";
  std::ifstream in(file);
  if (!in && exit_code > 1) return score;
  if (!in) throw stream::FileError(file, "cannot be read");
  try {
    const ordered_json json = ordered_json::parse(in);
    score.ending = json.at("ending");
    for (const auto& [name, metric] : json.at("metrics").items()) {
      const ordered_json& value = metric.at("value");
      score.metrics.push_back(
          {name, metric.at("unit"), value.is_null() ? std::nullopt : std::optional(value.get<double>())});
    }
  } catch (const ordered_json::exception& e) {
    throw stream::FileError(file, e.what());
  }
  return score;
}

Summary summarize(const Scenario& scenario, const std::vector<SeedScore>& seeds) {
  Summary summary{scenario.name, seeds, {}, {}};
  const auto fullest = std::max_element(
      seeds.begin(), seeds.end(),
      [](const SeedScore& a, const SeedScore& b) { return a.metrics.size() < b.metrics.size(); });
  if (fullest != seeds.end()) {
    for (const SeedMetric& metric : fullest->metrics) {
      summary.metrics.push_back(summarize_metric(metric, scenario, seeds));
    }
  }
  for (const MetricLimit& limit : scenario.limits.metrics) {
    if (!limit.aggregate.empty()) summary.limits.push_back(judge(limit, summary.metrics));
  }
  return summary;
}

int exit_code(const Summary& summary) {
  int worst = 0;
  for (const SeedScore& seed : summary.seeds) worst = std::max(worst, seed.exit_code);
  for (const JudgedLimit& limit : summary.limits) worst = std::max(worst, limit.passed ? 0 : 1);
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
    json["metrics"][m.name] = {{"unit", m.unit},
                               {"n", m.n},
                               {"median", json_of(m.median)},
                               {"mean", json_of(m.mean)},
                               {"sd", json_of(m.sd)},
                               {"worst", json_of(m.worst)}};
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
    text += fmt::format("{:<26} {:<5} {:>3} {:>10} {:>10} {:>10} {:>10}\n", m.name, m.unit, m.n,
                        number(m.median), number(m.mean), number(m.sd), number(m.worst));
  }
  for (const JudgedLimit& limit : summary.limits) {
    text += fmt::format("limit {} {} {}: {} {}\n", subject(limit.limit), word(limit.limit.bound),
                        limit.limit.value, number(limit.value), limit.passed ? "passed" : "MISSED");
  }
  return text;
}

}  // namespace sim::bench
