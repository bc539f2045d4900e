#include "sim/result/score_table.h"

#include <fmt/format.h>

#include <cmath>

#include "sim/result/json.h"
#include "sim/result/limits.h"
#include "sim/score/evaluate.h"

namespace sim::result {
namespace {

using json = nlohmann::ordered_json;

std::string number(const json& value) {
  if (!value.is_number()) return "-";
  const double x = value.get<double>();
  return x == std::floor(x) && std::abs(x) < 1e6 ? fmt::format("{:.0f}", x) : fmt::format("{:.4f}", x);
}

// Empty for a count or a ratio.
std::string unit(const json& metric) {
  const std::string unit = metric["unit"];
  return unit == "1" ? "" : unit;
}

// "<= 0.1  ok" for each limit on the metric.
std::string verdicts(const json& limits, const std::string& metric) {
  std::string text;
  for (const json& limit : limits) {
    if (limit["metric"] != metric) continue;
    const bool at_most = limit.contains("at_most");
    const auto verdict =
        verdict_word(limit["passed"].is_null() ? std::nullopt : std::optional(limit["passed"].get<bool>()));
    text += fmt::format("{}{} {}  {}", text.empty() ? "" : ", ",
                        at_most ? "<=" : ">=", number(limit[at_most ? "at_most" : "at_least"]), verdict);
  }
  return text;
}

// A line for each time in which tracking was lost or a sensor was suspect.
std::string tracking_faults(const json& scored) {
  std::string text;
  if (!scored.contains("tracking")) return text;
  for (const char* const kind : {"lost", "suspect"}) {
    if (!scored["tracking"].contains(kind)) continue;
    for (const json& fault : scored["tracking"][kind]) {
      const std::string to = fault["to_s"].is_null() ? "the end" : fmt::format("{:.2f} s", fault["to_s"].get<double>());
      text += fmt::format("  {} from {:.2f} s to {}: {}\n", kind, fault["from_s"].get<double>(), to,
                          fault["cause"].get<std::string>());
    }
  }
  return text;
}

// Where the scale is not known, the error up to scale is shown instead of ate_se3_rmse_m.
bool is_substitute(const json& metrics, const std::string& name) {
  return name == "ate_sim3_rmse_m" && metrics[name]["value"].is_number() &&
         metrics["ate_se3_rmse_m"]["value"].is_null();
}

}  // namespace

std::string score_table(const std::filesystem::path& result_folder) {
  const json scored = read_json(result_folder / "score.json"),
             timing = read_json(result_folder / "timing.json");
  std::string text = fmt::format("{}  seed {}  {}\n", scored["scenario"].get<std::string>(),
                                 scored["seed"].get<std::uint64_t>(), scored["ending"].get<std::string>());
  text += tracking_faults(scored);
  for (const auto& [name, metric] : scored["metrics"].items()) {
    const score::MetricDefinition* defined = score::find_metric(name);
    const std::string judged = verdicts(scored["limits"], name);
    if (judged.empty() && !(defined && defined->headline) && !is_substitute(scored["metrics"], name))
      continue;
    const std::string remark =
        metric["value"].is_null() && metric.contains("reason") ? metric["reason"].get<std::string>() : judged;
    text += fmt::format("  {:<24}{:>12} {:<4}  {}", name, number(metric["value"]), unit(metric), remark);
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  }
  if (const json& poses = scored["metrics"]["poses_matched"]["value"]; poses.is_number())
    text +=
        fmt::format("  errors over {} poses, without alignment except ate_se3; score.json has all metrics\n",
                    poses.get<double>());
  text += fmt::format("  filter {:.3f} ms CPU per frame (median; p99 {:.3f}), {:.2f} x real time\n",
                      timing["frame_cpu_ms_median"].get<double>(), timing["frame_cpu_ms_p99"].get<double>(),
                      timing["realtime_factor"].get<double>());
  return text;
}

}  // namespace sim::result
