#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "sim/result/limits.h"
#include "sim/score/metrics.h"
#include "sim/score/run.h"

namespace sim::result {
namespace {

using files::Json;

std::string shown(std::optional<double> value, int decimals = 4) {
  if (!value) return "-";
  if (*value == std::floor(*value) && std::abs(*value) < 1e6) return fmt::format("{:.0f}", *value);
  return std::abs(*value) < 1e-3 ? fmt::format("{:.{}g}", *value, decimals - 1)
                                 : fmt::format("{:.{}f}", *value, decimals);
}

double bound_of(const Json& limit) {
  const auto at_most = limit.find("at_most");
  return (at_most ? *at_most : limit.at("at_least")).number();
}

// Returns the decimals that distinguish a value from its limits.
int decimals_of(const std::vector<Json>& limits, const std::string& metric, std::optional<double> value) {
  int decimals = 4;
  for (const Json& limit : limits)
    if (value && limit.at("metric").text() == metric)
      for (const double bound = bound_of(limit);
           bound != *value && decimals < 17 && shown(bound, decimals) == shown(value, decimals);)
        ++decimals;
  return decimals;
}

// "<= 0.1  ok" for each limit on the metric.
std::string verdicts(const std::vector<Json>& limits, const std::string& metric, const TableStyle& style,
                     int decimals = 4) {
  std::string text;
  for (const Json& limit : limits) {
    if (limit.at("metric").text() != metric) continue;
    const auto found = limit.find("passed");
    const auto passed = found ? std::optional(found->flag()) : std::nullopt;
    text += fmt::format("{}{} {}  {}", text.empty() ? "" : ", ",
                        limit.find("at_most") ? "<=" : ">=", shown(bound_of(limit), decimals),
                        verdict_text(passed, style.colors));
  }
  return text;
}

std::optional<double> value_of(const Json& metrics, const std::string& name) {
  const auto metric = metrics.find(name);
  return metric ? metric->at("value").number_or_null() : std::nullopt;
}

// A line for each period of lost tracking or of a suspect sensor.
std::string tracking_faults(const Json& scored) {
  std::string text;
  const auto tracking = scored.find("tracking");
  for (const char* const kind : {"lost", "suspect"})
    if (const auto faults = tracking ? tracking->find(kind) : std::nullopt)
      for (const Json& fault : faults->items()) {
        const auto to = fault.at("to_s").number_or_null();
        text += fmt::format("  {} from {:.2f} s to {}: {}\n", kind, fault.at("from_s").number(),
                            to ? fmt::format("{:.2f} s", *to) : "the end", fault.at("cause").text());
      }
  return text;
}

std::optional<std::string> reason_of(const Json& metric) {
  const auto reason = metric.find("reason");
  return metric.at("value").is_null() && reason ? std::optional(reason->text()) : std::nullopt;
}

// A line for each metric that is shown. A reason that several of them share stands once, below them.
std::string metric_lines(const Json& scored, const TableStyle& style) {
  const Json metrics = scored.at("metrics");
  const std::vector<Json> limits = scored.at("limits").items();
  const bool no_scale = value_of(metrics, "ate_sim3_rmse_m") && !value_of(metrics, "ate_se3_rmse_m");
  const auto is_shown = [&](const std::string& name) {
    const score::MetricDefinition* defined = score::find_metric(name);
    return style.all_metrics || (defined && defined->headline) || !verdicts(limits, name, {}).empty() ||
           (no_scale && name == "ate_sim3_rmse_m");
  };
  std::map<std::string, int> times;
  std::size_t width = 24;
  for (const auto& [name, metric] : metrics.entries()) {
    if (!is_shown(name)) continue;
    width = std::max(width, name.size());
    if (const auto reason = reason_of(metric)) ++times[*reason];
  }
  std::vector<std::string> notes;
  const auto short_reason = [&](const std::string& reason) {
    if (times[reason] < 2) return reason;
    const auto found = std::find(notes.begin(), notes.end(), reason) - notes.begin();
    if (found == std::ssize(notes)) notes.push_back(reason);
    return fmt::format("({})", found + 1);
  };
  std::string text;
  for (const auto& [name, metric] : metrics.entries()) {
    if (!is_shown(name)) continue;
    const auto value = metric.at("value").number_or_null();
    const int decimals = decimals_of(limits, name, value);
    std::vector<std::string> remarks{verdicts(limits, name, style, decimals)};
    if (const auto reason = reason_of(metric)) remarks.push_back(short_reason(*reason));
    if (const auto note = metric.find("note")) remarks.push_back(note->text());
    std::erase(remarks, "");
    const std::string unit = metric.at("unit").text();
    text += fmt::format("  {:<{}}{:>12} {:<4}  {}", name, width, shown(value, decimals),
                        unit == "1" ? "" : unit, fmt::join(remarks, "  "));
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  }
  for (std::size_t i = 0; i < notes.size(); ++i) text += fmt::format("  ({}) {}\n", i + 1, notes[i]);
  return text;
}

// "  1291 of 1291 true poses matched (stamps within 0.1 ms), tracked 100 % of the time"
std::string coverage(const Json& metrics) {
  const auto matched = value_of(metrics, "poses_matched"), all = value_of(metrics, "true_poses"),
             tracked = value_of(metrics, "tracked_fraction");
  if (!matched || !all) return "";
  return fmt::format("  {} of {} true poses matched (stamps within 0.1 ms){}\n", *matched, *all,
                     tracked ? fmt::format(", tracked {:.4g} % of the time", 100 * *tracked) : "");
}

// "  readings used: vision 98.3 %, gyro 100 % (in 96.7 % of the frames)", without sensors that had none.
std::string sensor_use(const Json& metrics) {
  std::string text;
  for (const std::string_view sensor : score::kUsedSensors) {
    const auto readings = value_of(metrics, fmt::format("readings_{}_fraction", sensor)),
               accepted = value_of(metrics, fmt::format("accepted_{}_fraction", sensor));
    if (!readings || *readings == 0) continue;
    text += fmt::format("{}{} {:.3g} %", text.empty() ? "" : ", ", sensor, 100 * accepted.value_or(0));
    if (*readings < 0.9995) text += fmt::format(" (in {:.3g} % of the frames)", 100 * *readings);
  }
  return text.empty() ? "" : "  readings used: " + text + "\n";
}

// "  time of the estimator fixed: 645 frames dropped (50 %), latency 60 ms (median; p99 60), ..."
std::string timeliness(const Json& scored) {
  const auto time = scored.find("estimator_time");
  if (!time) return "";
  const Json metrics = scored.at("metrics");
  const auto number = [&](const char* name, double factor = 1) {
    const auto value = value_of(metrics, name);
    if (!value) return std::string("-");
    const double shown = factor * *value;
    return shown < 100 ? fmt::format("{:.3g}", shown) : fmt::format("{:.0f}", shown);
  };
  return fmt::format(
      "  time of the estimator {}: {} frames dropped ({} %), latency {} ms (median; p99 {}), {} % of the "
      "time between frames (mean; p99 {})\n",
      time->at("repeatable").flag() ? "fixed" : "measured, NOT REPEATABLE", number("dropped_frames"),
      number("dropped_frames_fraction", 100), number("latency_median_ms"), number("latency_p99_ms"),
      number("budget_fraction_mean", 100), number("budget_fraction_p99", 100));
}

}  // namespace

std::string score_table(const std::filesystem::path& result_folder, const TableStyle& style, bool failed) {
  const Json scored = read_whole_score(result_folder / "score.json"),
             timing = files::read_json(result_folder / "timing.json");
  const std::filesystem::path file = result_folder / "about.json";
  const About about = std::filesystem::exists(file) ? read_about(file) : About();
  const std::string ending = scored.at("ending").text();
  std::string text = fmt::format("{}  seed {}  {}", scored.at("scenario").text(), scored.at("seed").whole(),
                                 painted(ending, failed ? Paint::bad : Paint::none, style.colors));
  if (!failed && ending != "completed" && !about.cause.empty()) text += ": " + about.cause;
  text += "\n" + tracking_faults(scored) + metric_lines(scored, style);
  text += coverage(scored.at("metrics")) + sensor_use(scored.at("metrics")) + timeliness(scored);
  if (value_of(scored.at("metrics"), "poses_matched"))
    text += fmt::format("  {}; {}\n",
                        about.alignment.empty() || about.alignment == "none"
                            ? "errors without alignment except ate_se3"
                            : fmt::format("errors after its {} alignment with the truth", about.alignment),
                        style.all_metrics ? "report explains each metric" : "score.json has all metrics");
  if (const auto median = timing.find("frame_cpu_ms_median"))
    text += fmt::format("  filter {:.3f} ms CPU per frame (median; p99 {:.3f})", median->number(),
                        timing.at("frame_cpu_ms_p99").number());
  else
    text +=
        fmt::format("  estimator {:.3f} ms CPU per frame (mean)", timing.at("frame_cpu_ms_mean").number());
  return text + fmt::format(", {:.2f} x real time\n", timing.at("realtime_factor").number());
}

}  // namespace sim::result
