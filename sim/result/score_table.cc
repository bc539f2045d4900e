#include "sim/result/score_table.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <vector>

#include "sim/result/limits.h"
#include "sim/result/score_file.h"
#include "sim/score/evaluate.h"

namespace sim::result {
namespace {

using files::Json;

std::string shown(std::optional<double> value) {
  if (!value) return "-";
  return *value == std::floor(*value) && std::abs(*value) < 1e6 ? fmt::format("{:.0f}", *value)
                                                                : fmt::format("{:.4f}", *value);
}

// Empty for a count or a ratio.
std::string unit(const Json& metric) {
  const std::string unit = metric.at("unit").text();
  return unit == "1" ? "" : unit;
}

// "<= 0.1  ok" for each limit on the metric.
std::string verdicts(const std::vector<Json>& limits, const std::string& metric) {
  std::string text;
  for (const Json& limit : limits) {
    if (limit.at("metric").text() != metric) continue;
    const auto at_most = limit.find("at_most"), passed = limit.find("passed");
    const double bound = (at_most ? *at_most : limit.at("at_least")).number();
    text += fmt::format("{}{} {}  {}", text.empty() ? "" : ", ", at_most ? "<=" : ">=", shown(bound),
                        verdict_word(passed ? std::optional(passed->flag()) : std::nullopt));
  }
  return text;
}

std::optional<double> value_of(const Json& metrics, const char* name) {
  const auto metric = metrics.find(name);
  return metric ? metric->at("value").number_or_null() : std::nullopt;
}

// A line for each time in which tracking was lost or a sensor was suspect.
std::string tracking_faults(const Json& scored) {
  std::string text;
  const auto tracking = scored.find("tracking");
  if (!tracking) return text;
  for (const char* const kind : {"lost", "suspect"}) {
    const auto faults = tracking->find(kind);
    if (!faults) continue;
    for (const Json& fault : faults->items()) {
      const auto to = fault.at("to_s").number_or_null();
      text += fmt::format("  {} from {:.2f} s to {}: {}\n", kind, fault.at("from_s").number(),
                          to ? fmt::format("{:.2f} s", *to) : "the end", fault.at("cause").text());
    }
  }
  return text;
}

// Where the scale is not known, the error up to scale is shown instead of ate_se3_rmse_m.
bool is_substitute(const Json& metrics, const std::string& name) {
  return name == "ate_sim3_rmse_m" && value_of(metrics, "ate_sim3_rmse_m") &&
         !value_of(metrics, "ate_se3_rmse_m");
}

std::string metric_line(const std::string& name, const Json& metric, const std::string& judged) {
  const auto reason = metric.find("reason");
  const std::string remark = metric.at("value").is_null() && reason ? reason->text() : judged;
  std::string line = fmt::format("  {:<24}{:>12} {:<4}  {}", name, shown(metric.at("value").number_or_null()),
                                 unit(metric), remark);
  line.erase(line.find_last_not_of(' ') + 1);
  return line + '\n';
}

}  // namespace

std::string score_table(const std::filesystem::path& result_folder) {
  const Json scored = read_whole_score(result_folder / "score.json"),
             timing = files::read_json(result_folder / "timing.json"), metrics = scored.at("metrics");
  const std::vector<Json> limits = scored.at("limits").items();
  std::string text = fmt::format("{}  seed {}  {}\n", scored.at("scenario").text(), scored.at("seed").whole(),
                                 scored.at("ending").text());
  text += tracking_faults(scored);
  for (const auto& [name, metric] : metrics.entries()) {
    const score::MetricDefinition* defined = score::find_metric(name);
    const std::string judged = verdicts(limits, name);
    if (!judged.empty() || (defined && defined->headline) || is_substitute(metrics, name))
      text += metric_line(name, metric, judged);
  }
  if (const auto poses = value_of(metrics, "poses_matched"))
    text += fmt::format(
        "  errors over {} poses, without alignment except ate_se3; score.json has all metrics\n", *poses);
  const double median = timing.at("frame_cpu_ms_median").number(),
               p99 = timing.at("frame_cpu_ms_p99").number();
  text += fmt::format("  filter {:.3f} ms CPU per frame (median; p99 {:.3f}), {:.2f} x real time\n", median,
                      p99, timing.at("realtime_factor").number());
  return text;
}

}  // namespace sim::result
