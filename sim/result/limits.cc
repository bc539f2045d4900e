#include "sim/result/limits.h"

#include <fmt/ranges.h>

#include <fstream>

#include "sim/files/atomic_file.h"
#include "sim/scenario/keys.h"
#include "sim/score/metrics.h"
#include "sim/score/run.h"

namespace sim::result {
namespace {

using nlohmann::ordered_json;

score::Direction direction_of(const std::string& metric, const scenario::Scenario& scenario) {
  const score::Direction own = score::direction_of(metric);
  if (own.worst == score::Worst::farthest_from_expected) return own;
  for (const scenario::MetricLimit& limit : scenario.limits.metrics)
    if (limit.metric == metric) return worst_side(limit);
  return own;
}

// Judges a limit on a value over seeds. The value is absent if a seed has none. The worst seed is the one
// closest to missing this limit.
JudgedLimit judge_over_seeds(const scenario::Scenario& scenario, const scenario::MetricLimit& limit,
                             const std::vector<SeedScore>& seeds) {
  const std::vector<double> values = values_of(limit.metric, seeds);
  const std::size_t without = seeds.size() - values.size();
  if (values.empty() || without > 0) {
    JudgedLimit judged = judge(scenario, limit, std::nullopt);
    if (!values.empty()) judged.passed = false;
    if (judged.missed()) judged.reason = fmt::format("no value for {} of {} seeds", without, seeds.size());
    return judged;
  }
  const score::Summary over_seeds = score::summarize(values, worst_side(limit));
  return judge(scenario, limit,
               limit.aggregate == "median" ? over_seeds.median
               : limit.aggregate == "mean" ? over_seeds.mean
                                           : over_seeds.worst);
}

std::string row(const MetricSummary& metric) {
  const score::Summary& s = metric.over_seeds;
  const std::string start = fmt::format("{:<26} {:<5} {:>3}", metric.name, metric.unit, s.n);
  if (s.n == 0) return start + "\n";
  return fmt::format("{} {:>10.4g} {:>10.4g} {:>10} {:>10.4g}\n", start, s.median, s.mean,
                     number_text(s.standard_deviation), s.worst);
}

// "1..5, 7"
std::string ranges(std::vector<std::uint64_t> seeds) {
  std::ranges::sort(seeds);
  std::string text;
  for (std::size_t first = 0, last = 0; first < seeds.size(); first = last + 1) {
    for (last = first; last + 1 < seeds.size() && seeds[last + 1] == seeds[last] + 1;) ++last;
    text += fmt::format("{}{}", text.empty() ? "" : ", ", seeds[first]);
    if (last > first) text += fmt::format("{}{}", last == first + 1 ? ", " : "..", seeds[last]);
  }
  return text;
}

// Returns a line for each group of seeds with the same ending, passed seeds first.
std::string endings(const Summary& summary, const TableStyle& style) {
  std::map<std::pair<int, scenario::Ending>, std::vector<std::uint64_t>> alike;
  for (const SeedScore& seed : summary.seeds) alike[{seed.exit_code, seed.ending}].push_back(seed.seed);
  std::string text;
  for (const auto& [how, seeds] : alike) {
    constexpr const char* kTexts[]{"passed", "missed a limit", "not started", "failed"};
    const std::string passed = fmt::format("{:<14}", kTexts[std::clamp(how.first, 0, 3)]);
    text += fmt::format("  {}  {:<16}  {} {}\n",
                        painted(passed, how.first == 0 ? Paint::good : Paint::bad, style.colors),
                        name_of(how.second), seeds.size() == 1 ? "seed" : "seeds", ranges(seeds));
  }
  return text;
}

// Headline metrics first; then, on request, the others.
std::string metrics(const Summary& summary, const TableStyle& style) {
  if (summary.metrics.empty()) return "no metrics: no seed has a score\n";
  std::string head = fmt::format("{:<26} {:<5} {:>3} {:>10} {:>10} {:>10} {:>10}\n", "metric", "unit", "n",
                                 "median", "mean", "sd", "worst"),
              others;
  for (const MetricSummary& m : summary.metrics) {
    const score::MetricDefinition* defined = score::find_metric(m.name);
    (m.limited || (defined && defined->headline) ? head : others) += row(m);
  }
  if (style.all_metrics) return head + (others.empty() ? "" : "\n") + others;
  return head + (others.empty() ? "" : "--all-metrics shows all metrics in summary.json\n");
}

// A run's table.

std::string shown(std::optional<double> value, int decimals = 4) {
  if (!value) return "-";
  if (*value == std::floor(*value) && std::abs(*value) < 1e6) return fmt::format("{:.0f}", *value);
  return std::abs(*value) < 1e-3 ? fmt::format("{:.{}g}", *value, decimals - 1)
                                 : fmt::format("{:.{}f}", *value, decimals);
}

// Returns how many decimals distinguish a value from its limits.
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

// Returns a line for each metric shown. A reason shared by several of them appears once, below them.
std::string metric_lines(const SeedScore& scored, const TableStyle& style) {
  std::vector<SeedMetric> shown_metrics;
  std::map<std::string, int> times;
  std::size_t width = 24;
  for (const SeedMetric& metric : scored.metrics) {
    const score::MetricDefinition* defined = score::find_metric(metric.name);
    if (!style.all_metrics && !(defined && defined->headline) && verdicts(scored, metric.name, false).empty())
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
                                     short_reason(metric.reason), metric.note.value_or("")};
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

// "  readings used: vision 98.3 %, gyro 100 % (in 96.7 % of the frames)"; only sensors with readings.
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

std::string number_text(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? fmt::format("{:.4g}", *value) : "-";
}

std::vector<double> values_of(const std::string& metric, const std::vector<SeedScore>& seeds) {
  std::vector<double> values;
  for (const SeedScore& seed : seeds)
    if (const auto value = seed.value(metric)) values.push_back(*value);
  return values;
}

JudgedLimit judge(const scenario::Scenario& scenario, const scenario::MetricLimit& limit,
                  std::optional<double> value) {
  if (!value && !scenario.slam) return {limit, {}, {}};
  return {limit, value, value && keeps(limit, *value)};
}

std::vector<JudgedLimit> judge_run(const scenario::Scenario& scenario,
                                   const std::function<std::optional<double>(const std::string&)>& value_of) {
  std::vector<JudgedLimit> all;
  for (const scenario::MetricLimit& limit : scenario.limits.metrics)
    if (!limit.aggregate) all.push_back(judge(scenario, limit, value_of(limit.metric)));
  return all;
}

bool is_allowed(const scenario::Scenario& scenario, scenario::Ending ending) {
  return std::ranges::count(scenario.limits.ending, scenario::name_of(ending)) > 0;
}

int exit_code(const scenario::Scenario& scenario, scenario::Ending ending,
              const std::vector<JudgedLimit>& limits) {
  if (!is_allowed(scenario, ending)) return scenario::exit_code_of(ending);
  return std::ranges::any_of(limits, &JudgedLimit::missed) ? 1 : 0;
}

score::Worst worst_side(const scenario::MetricLimit& limit) {
  return limit.bound == scenario::Bound::at_most ? score::Worst::largest : score::Worst::smallest;
}

std::string verdict_text(std::optional<bool> passed, bool colors) {
  if (!passed) return "not judged";
  return *passed ? painted("ok", Paint::good, colors) : painted("MISSED", Paint::bad, colors);
}

nlohmann::ordered_json to_json(const JudgedLimit& judged) {
  nlohmann::ordered_json json{{"metric", subject(judged.limit)},
                              {std::string(word(judged.limit.bound)), judged.limit.value},
                              {"value", or_null(judged.value)},
                              {"passed", or_null(judged.passed)}};
  if (judged.reason) json["reason"] = *judged.reason;
  return json;
}

Summary summarize(const scenario::Scenario& scenario, const std::vector<SeedScore>& seeds) {
  Summary summary{scenario.name, seeds, {}, {}};
  const auto fullest =
      std::ranges::max_element(seeds, {}, [](const SeedScore& s) { return s.metrics.size(); });
  if (fullest != seeds.end())
    for (const SeedMetric& m : fullest->metrics)
      summary.metrics.push_back(
          {m.name, m.unit, score::summarize(values_of(m.name, seeds), direction_of(m.name, scenario)),
           std::ranges::count(scenario.limits.metrics, m.name, &scenario::MetricLimit::metric) > 0});
  for (const scenario::MetricLimit& limit : scenario.limits.metrics)
    if (limit.aggregate) summary.limits.push_back(judge_over_seeds(scenario, limit, seeds));
  return summary;
}

int exit_code(const Summary& summary) {
  int worst = 0;
  for (const SeedScore& seed : summary.seeds) worst = std::max(worst, seed.exit_code);
  for (const JudgedLimit& limit : summary.limits) worst = std::max(worst, limit.missed() ? 1 : 0);
  return worst;
}

ordered_json to_json(const Summary& summary) {
  ordered_json json{{"format_version", 1}, {"scenario", summary.scenario}};
  json["seeds"] = ordered_json::array();
  for (const SeedScore& seed : summary.seeds)
    json["seeds"].push_back(
        {{"seed", seed.seed}, {"ending", scenario::name_of(seed.ending)}, {"exit_code", seed.exit_code}});
  json["metrics"] = ordered_json::object();
  for (const MetricSummary& m : summary.metrics) {
    const score::Summary& s = m.over_seeds;
    const auto number = [&](double value) { return s.n > 0 ? ordered_json(value) : ordered_json(nullptr); };
    json["metrics"][m.name] = {{"unit", m.unit},
                               {"n", s.n},
                               {"median", number(s.median)},
                               {"mean", number(s.mean)},
                               {"sd", or_null(s.standard_deviation)},
                               {"worst", number(s.worst)}};
  }
  json["limits"] = ordered_json::array();
  for (const JudgedLimit& limit : summary.limits) json["limits"].push_back(to_json(limit));
  return json;
}

void write_summary(const fs::path& file, const Summary& summary) {
  files::write_atomically(file, files::json_text(to_json(summary), 2) + "\n");
}

void renew_summary(const fs::path& result) {
  using files::FileLock;
  const fs::path root = fs::absolute(result).lexically_normal().parent_path(), file = root / "summary.json";
  if (!seed_of(result) || !fs::is_regular_file(file) || !files::has_marker(root)) return;
  const auto lock = FileLock::acquire(root / files::kMarker, FileLock::How::try_exclusive);
  if (!lock) return;
  const Provenance own = provenance_of(result);
  std::vector<SeedScore> scores;
  for (const std::uint64_t seed : seeds_in(root)) try {
      const fs::path folder = root / fmt::format("seed-{}", seed);
      if (provenance_of(folder) == own) scores.push_back(read_result(folder));
    } catch (const std::exception&) {  // damaged
    }
  write_summary(file, summarize(scenario::read_scenario(result / "scenario.yaml").scenario, scores));
}

std::string summary_table(const Summary& summary, const TableStyle& style) {
  std::string text = fmt::format("{}, {}\n", summary.scenario, files::counted(summary.seeds.size(), "seed"));
  text += endings(summary, style) + "\n" + metrics(summary, style);
  for (const JudgedLimit& limit : summary.limits)
    text += fmt::format("limit {} {} {}: {}  {}{}\n", subject(limit.limit), word(limit.limit.bound),
                        limit.limit.value, number_text(limit.value), verdict_text(limit.passed, style.colors),
                        limit.reason ? ": " + *limit.reason : "");
  return text;
}

std::string score_table(const fs::path& result_folder, const TableStyle& style, bool failed) {
  const SeedScore scored = read_score(result_folder / "score.json");
  const files::Json timing = files::read_json(result_folder / "timing.json");
  const fs::path file = result_folder / "about.json";
  const About about = fs::exists(file) ? read_about(file) : About();
  std::string text = fmt::format(
      "{}  seed {}  {}", scored.scenario, scored.seed,
      painted(std::string(name_of(scored.ending)), failed ? Paint::bad : Paint::none, style.colors));
  if (!failed && scored.ending != scenario::Ending::completed && !about.cause.empty())
    text += ": " + about.cause;
  text += "\n" + tracking_faults(scored) + metric_lines(scored, style);
  text += coverage(scored) + sensor_use(scored) + timeliness(scored);
  if (scored.value("poses_matched"))
    text += fmt::format(
        "  {}; {}\n",
        about.alignment.empty() || about.alignment == "none"
            ? "errors without alignment except ate_se3"
            : fmt::format("errors after {} alignment with the truth, NEES after aligning the first pose",
                          about.alignment),
        style.all_metrics ? "report explains each metric" : "score.json has all metrics");
  if (const auto median = timing.find("frame_cpu_ms_median"))
    text += fmt::format("  {} {:.3f} ms CPU per frame (median; p99 {:.3f})", scored.estimator,
                        median->number(), timing.at("frame_cpu_ms_p99").number());
  else
    text += fmt::format("  {} {:.3f} ms CPU per frame (mean)", scored.estimator,
                        timing.at("frame_cpu_ms_mean").number());
  if (const auto median = timing.find("controller_ms_median"))
    text += fmt::format(", walking controller {:.3f} ms per answer (median; p99 {:.3f})", median->number(),
                        timing.at("controller_ms_p99").number());
  text += fmt::format(", {:.2f} x real time\n", timing.at("realtime_factor").number());
  // The bench's own remarks follow the walking controller's log.
  std::ifstream log(result_folder / "controller.log");
  for (std::string line; std::getline(log, line);)
    if (line.starts_with("gaitslam: ")) text += "  walking controller: " + line.substr(10) + "\n";
  return text;
}

}  // namespace sim::result
