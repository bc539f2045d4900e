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

std::string shown(std::optional<double> value, int decimals = 4) {
  if (!value) return "-";
  if (*value == std::floor(*value) && std::abs(*value) < 1e6) return fmt::format("{:.0f}", *value);
  return std::abs(*value) < 1e-3 ? fmt::format("{:.{}g}", *value, decimals - 1)
                                 : fmt::format("{:.{}f}", *value, decimals);
}

// Returns the decimals that distinguish a value from its limits.
int decimals_of(const SeedScore& scored, const SeedMetric& metric) {
  int decimals = 4;
  for (const JudgedLimit& judged : scored.limits)
    if (const double bound = judged.limit.value; metric.value && judged.limit.metric == metric.name)
      while (bound != *metric.value && decimals < 17 &&
             shown(bound, decimals) == shown(metric.value, decimals))
        ++decimals;
  return decimals;
}

// "<= 0.1  ok" for each limit on the metric.
std::string verdicts(const SeedScore& scored, const std::string& metric, bool colors, int decimals = 4) {
  std::string text;
  for (const auto& [limit, value, passed, reason] : scored.limits)
    if (limit.metric == metric)
      text += fmt::format("{}{} {}  {}", text.empty() ? "" : ", ",
                          limit.bound == scenario::Bound::at_most ? "<=" : ">=", shown(limit.value, decimals),
                          verdict_text(passed, colors));
  return text;
}

// A line for each period of lost tracking or of a suspect sensor.
std::string tracking_faults(const SeedScore& scored) {
  std::string text;
  for (const auto& [kind, cause, from_s, to_s] : scored.faults)
    text += fmt::format("  {} from {:.2f} s to {}: {}\n", kind, from_s,
                        to_s ? fmt::format("{:.2f} s", *to_s) : "the end", cause);
  return text;
}

// A line for each metric that is shown. A reason that several of them share stands once, below them.
std::string metric_lines(const SeedScore& scored, const TableStyle& style) {
  const bool no_scale = scored.value("ate_sim3_rmse_m") && !scored.value("ate_se3_rmse_m");
  std::vector<SeedMetric> shown_metrics;
  std::map<std::string, int> times;
  std::size_t width = 24;
  for (const SeedMetric& metric : scored.metrics) {
    const score::MetricDefinition* defined = score::find_metric(metric.name);
    if (!style.all_metrics && !(defined && defined->headline) &&
        verdicts(scored, metric.name, false).empty() && !(no_scale && metric.name == "ate_sim3_rmse_m"))
      continue;
    shown_metrics.push_back(metric);
    width = std::max(width, metric.name.size());
    ++times[metric.reason];
  }
  std::vector<std::string> notes;
  const auto short_reason = [&](const std::string& reason) {
    if (reason.empty() || times[reason] < 2) return reason;
    const auto found = std::ranges::find(notes, reason) - notes.begin();
    if (found == std::ssize(notes)) notes.push_back(reason);
    return fmt::format("({})", found + 1);
  };
  std::string text;
  for (const SeedMetric& metric : shown_metrics) {
    const int decimals = decimals_of(scored, metric);
    std::vector<std::string> remarks{verdicts(scored, metric.name, style.colors, decimals),
                                     short_reason(metric.reason), metric.note};
    std::erase(remarks, "");
    text += fmt::format("  {:<{}}{:>12} {:<4}  {}", metric.name, width, shown(metric.value, decimals),
                        metric.unit == "1" ? "" : metric.unit, fmt::join(remarks, "  "));
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  }
  for (std::size_t i = 0; i < notes.size(); ++i) text += fmt::format("  ({}) {}\n", i + 1, notes[i]);
  return text;
}

// "  1291 of 1291 true poses matched (stamps within 0.1 ms), tracked 100 % of the time"
std::string coverage(const SeedScore& scored) {
  const auto matched = scored.value("poses_matched"), all = scored.value("true_poses"),
             tracked = scored.value("tracked_fraction");
  if (!matched || !all) return "";
  return fmt::format("  {} of {} true poses matched (stamps within 0.1 ms){}\n", *matched, *all,
                     tracked ? fmt::format(", tracked {:.4g} % of the time", 100 * *tracked) : "");
}

// "  readings used: vision 98.3 %, gyro 100 % (in 96.7 % of the frames)", without sensors that had none.
std::string sensor_use(const SeedScore& scored) {
  std::string text;
  for (const std::string_view sensor : score::kUsedSensors) {
    const auto readings = scored.value(fmt::format("readings_{}_fraction", sensor)),
               accepted = scored.value(fmt::format("accepted_{}_fraction", sensor));
    if (!readings || *readings == 0) continue;
    text += fmt::format("{}{} {:.3g} %", text.empty() ? "" : ", ", sensor, 100 * accepted.value_or(0));
    if (*readings < 0.9995) text += fmt::format(" (in {:.3g} % of the frames)", 100 * *readings);
  }
  return text.empty() ? "" : "  readings used: " + text + "\n";
}

// "  time of the estimator fixed: 645 frames dropped (50 %), latency 60 ms (median; p99 60), ..."
std::string timeliness(const SeedScore& scored) {
  if (!scored.repeatable) return "";
  const auto number = [&](const char* name, double factor = 1) {
    const auto value = scored.value(name);
    if (!value) return std::string("-");
    const double shown = factor * *value;
    return shown < 100 ? fmt::format("{:.3g}", shown) : fmt::format("{:.0f}", shown);
  };
  return fmt::format(
      "  time of the estimator {}: {} frames dropped ({} %), latency {} ms (median; p99 {}), {} % of the "
      "time between frames (mean; p99 {})\n",
      *scored.repeatable ? "fixed" : "measured, NOT REPEATABLE", number("dropped_frames"),
      number("dropped_frames_fraction", 100), number("latency_median_ms"), number("latency_p99_ms"),
      number("budget_fraction_mean", 100), number("budget_fraction_p99", 100));
}

}  // namespace

std::string score_table(const std::filesystem::path& result_folder, const TableStyle& style, bool failed) {
  const SeedScore scored = read_score(result_folder / "score.json");
  const files::Json timing = files::read_json(result_folder / "timing.json");
  const std::filesystem::path file = result_folder / "about.json";
  const About about = std::filesystem::exists(file) ? read_about(file) : About();
  std::string text = fmt::format(
      "{}  seed {}  {}", scored.scenario, scored.seed,
      painted(std::string(name_of(scored.ending)), failed ? Paint::bad : Paint::none, style.colors));
  if (!failed && scored.ending != scenario::Ending::completed && !about.cause.empty())
    text += ": " + about.cause;
  text += "\n" + tracking_faults(scored) + metric_lines(scored, style);
  text += coverage(scored) + sensor_use(scored) + timeliness(scored);
  if (scored.value("poses_matched"))
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
