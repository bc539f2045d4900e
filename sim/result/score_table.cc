#include "sim/result/score_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "sim/result/limits.h"
#include "sim/result/score_file.h"
#include "sim/score/metrics.h"
#include "sim/score/run.h"

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
std::string verdicts(const std::vector<Json>& limits, const std::string& metric, const TableStyle& style) {
  std::string text;
  for (const Json& limit : limits) {
    if (limit.at("metric").text() != metric) continue;
    const auto at_most = limit.find("at_most"), found = limit.find("passed");
    const double bound = (at_most ? *at_most : limit.at("at_least")).number();
    const auto passed = found ? std::optional(found->flag()) : std::nullopt;
    text += fmt::format("{}{} {}  {}", text.empty() ? "" : ", ", at_most ? "<=" : ">=", shown(bound),
                        verdict_text(passed, style.colors));
  }
  return text;
}

std::optional<double> value_of(const Json& metrics, const char* name) {
  const auto metric = metrics.find(name);
  return metric ? metric->at("value").number_or_null() : std::nullopt;
}

// A line for each period of lost tracking or of a suspect sensor.
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

// Without a known scale the error up to scale replaces ate_se3_rmse_m.
bool is_substitute(const Json& metrics, const std::string& name) {
  return name == "ate_sim3_rmse_m" && value_of(metrics, "ate_sim3_rmse_m") &&
         !value_of(metrics, "ate_se3_rmse_m");
}

// Reasons of missing values: beside the metric, or once below if several metrics share them.
class Reasons {
 public:
  void count(const std::string& reason) { ++times_[reason]; }
  /// The remark beside the metric.
  std::string remark(const std::string& reason) {
    if (times_[reason] < 2) return reason;
    auto found = std::find(notes_.begin(), notes_.end(), reason);
    if (found == notes_.end()) found = notes_.insert(found, reason);
    return fmt::format("({})", found - notes_.begin() + 1);
  }
  std::string notes() const {
    std::string text;
    for (std::size_t i = 0; i < notes_.size(); ++i) text += fmt::format("  ({}) {}\n", i + 1, notes_[i]);
    return text;
  }

 private:
  std::map<std::string, int> times_;
  std::vector<std::string> notes_;
};

std::optional<std::string> reason_of(const Json& metric) {
  const auto reason = metric.find("reason");
  return metric.at("value").is_null() && reason ? std::optional(reason->text()) : std::nullopt;
}

std::string metric_line(const std::string& name, std::size_t width, const Json& metric,
                        const std::string& judged, Reasons& reasons) {
  const auto reason = reason_of(metric);
  std::string remark = reason ? reasons.remark(*reason) : judged;
  if (reason && !judged.empty()) remark = judged + "  " + remark;
  if (const auto note = metric.find("note")) remark += (remark.empty() ? "" : "  ") + note->text();
  std::string line = fmt::format("  {:<{}}{:>12} {:<4}  {}", name, width,
                                 shown(metric.at("value").number_or_null()), unit(metric), remark);
  line.erase(line.find_last_not_of(' ') + 1);
  return line + '\n';
}

std::string metric_lines(const Json& scored, const TableStyle& style) {
  const Json metrics = scored.at("metrics");
  const std::vector<Json> limits = scored.at("limits").items();
  const auto is_shown = [&](const std::string& name) {
    const score::MetricDefinition* defined = score::find_metric(name);
    return style.all_metrics || (defined && defined->headline) || !verdicts(limits, name, {}).empty() ||
           is_substitute(metrics, name);
  };
  Reasons reasons;
  std::size_t width = 24;
  for (const auto& [name, metric] : metrics.entries()) {
    if (!is_shown(name)) continue;
    width = std::max(width, name.size());
    if (const auto reason = reason_of(metric)) reasons.count(*reason);
  }
  std::string text;
  for (const auto& [name, metric] : metrics.entries())
    if (is_shown(name)) text += metric_line(name, width, metric, verdicts(limits, name, style), reasons);
  return text + reasons.notes();
}

// ": left hand and desk at 3.2 s" of a run that was not completed.
std::string cause_of(const std::string& ending, const std::filesystem::path& about) {
  const std::string cause =
      ending != "completed" && std::filesystem::exists(about) ? read_about(about).cause : "";
  return cause.empty() ? "" : ": " + cause;
}

// The alignment of the errors.
std::string alignment_text(const std::filesystem::path& about) {
  const std::string by = std::filesystem::exists(about) ? read_about(about).alignment : "";
  return by.empty() || by == "none" ? "errors without alignment except ate_se3"
                                    : fmt::format("errors after its {} alignment with the truth", by);
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
    const auto readings = value_of(metrics, fmt::format("readings_{}_fraction", sensor).c_str()),
               accepted = value_of(metrics, fmt::format("accepted_{}_fraction", sensor).c_str());
    if (!readings || *readings == 0) continue;
    text += fmt::format("{}{} {:.3g} %", text.empty() ? "" : ", ", sensor, 100 * accepted.value_or(0));
    if (*readings < 0.9995) text += fmt::format(" (in {:.3g} % of the frames)", 100 * *readings);
  }
  return text.empty() ? "" : "  readings used: " + text + "\n";
}

}  // namespace

std::string score_table(const std::filesystem::path& result_folder, const TableStyle& style, bool failed) {
  const Json scored = read_whole_score(result_folder / "score.json"),
             timing = files::read_json(result_folder / "timing.json");
  std::string text =
      fmt::format("{}  seed {}  {}{}\n", scored.at("scenario").text(), scored.at("seed").whole(),
                  painted(scored.at("ending").text(), failed ? Paint::bad : Paint::none, style.colors),
                  failed ? "" : cause_of(scored.at("ending").text(), result_folder / "about.json"));
  text += tracking_faults(scored) + metric_lines(scored, style);
  text += coverage(scored.at("metrics")) + sensor_use(scored.at("metrics"));
  if (value_of(scored.at("metrics"), "poses_matched"))
    text += fmt::format("  {}; {}\n", alignment_text(result_folder / "about.json"),
                        style.all_metrics ? "report explains each metric" : "score.json has all metrics");
  if (const auto median = timing.find("frame_cpu_ms_median")) {
    text += fmt::format("  filter {:.3f} ms CPU per frame", median->number());
    text += fmt::format(" (median; p99 {:.3f})", timing.at("frame_cpu_ms_p99").number());
  } else {
    text +=
        fmt::format("  estimator {:.3f} ms CPU per frame (mean)", timing.at("frame_cpu_ms_mean").number());
  }
  text += fmt::format(", {:.2f} x real time\n", timing.at("realtime_factor").number());
  return text;
}

}  // namespace sim::result
