// Tables of the changes between two sets of runs.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "sim/files/csv.h"
#include "sim/files/text.h"
#include "sim/pages/pages.h"
#include "sim/regression/verdict.h"
#include "sim/scenario/keys.h"
#include "sim/score/metrics.h"
#include "sim/score/statistics.h"

namespace sim::pages {
namespace {

using regression::MetricVerdict, regression::Verdict;
using Seeds = std::vector<result::SeedScore>;

std::string signed_text(double value) { return (value > 0 ? "+" : "") + number_text(value); }

/// "+0.0004 (+7 %)"
std::string change_text(const MetricVerdict& v) {
  if (!v.change) return "-";
  if (!v.baseline || *v.baseline == 0 || *v.change == 0) return signed_text(*v.change);
  const double percent = 100 * *v.change / std::abs(*v.baseline);
  return signed_text(*v.change) + (std::abs(percent) < 999.5 ? fmt::format(" ({:+.3g} %)", percent)
                                                             : fmt::format(" ({:+.0f} %)", percent));
}

/// Returns the gates of compare, then the other shown metrics, which have no tolerance and thus no verdict,
/// in the units of display_of().
std::vector<std::pair<MetricVerdict, bool>> verdicts_of(const Seeds& a, const Seeds& b, const RunData& run) {
  const std::vector<regression::Gate>& gates = regression::default_gates();
  std::vector<regression::Gate> others;
  for (const std::string& name : shown_metrics(run))
    if (std::ranges::find(gates, name, &regression::Gate::metric) == gates.end()) others.push_back({name});
  std::vector<std::pair<MetricVerdict, bool>> all;
  for (const auto& [of, judged] : {std::pair{gates, true}, {others, false}})
    for (MetricVerdict& v : regression::compare({"", {}, a}, {"", {}, b}, of).metrics) {
      if (!v.baseline && !v.now) continue;
      const double factor = display_of(v.gate.metric).factor;
      for (std::optional<double>* value : {&v.baseline, &v.now, &v.change})
        if (*value) **value *= factor;
      if (v.band) v.band->first *= factor, v.band->second *= factor;
      all.emplace_back(v, judged);
    }
  return all;
}

}  // namespace

std::optional<double> worst_instant(const RunData& run, const std::string& metric) {
  if (metric.starts_with("loop_")) return run.value("loop_time_s");
  if (!run.errors || run.errors->t.empty()) return std::nullopt;
  const Errors& e = *run.errors;
  if (metric.starts_with("end_") || metric.starts_with("navigation_end_")) return e.t.back();
  const auto has = [&](const char* word) { return metric.find(word) != metric.npos; };
  const Column& column = has("yaw") || has("rotation") ? e.error[3]
                         : has("nees_orientation")     ? e.nees_orientation
                         : has("nees")                 ? e.nees_position
                                                       : e.distance;
  const bool counts_gaps = has("tracked");
  std::optional<std::size_t> worst;
  for (std::size_t i = 0; i < column.size(); ++i) {
    if (counts_gaps && std::isnan(column[i])) return e.t[i];
    if (std::isfinite(column[i]) && (!worst || std::abs(column[i]) > std::abs(column[*worst]))) worst = i;
  }
  return worst ? std::optional(e.t[*worst]) : std::nullopt;
}

Seeds seeds_beside(const RunData& run) {
  fs::path above = fs::absolute(run.folder / "x").lexically_normal().parent_path(), inside;
  while (above.has_relative_path() && !result::seed_of(above))
    inside = above.filename() / inside, above = above.parent_path();
  Seeds all{run};
  if (!result::seed_of(above)) return all;
  for (const std::uint64_t seed : result::seeds_in(above.parent_path())) try {
      const fs::path other = above.parent_path() / fmt::format("seed-{}", seed) / inside;
      if (seed == run.seed || !result::is_result(other)) continue;
      const auto score = result::read_score(other / "score.json");
      if (score.scenario == run.scenario && score.estimator == run.estimator &&
          settings_of(other, result::read_about(other / "about.json")) == run.settings)
        all.push_back(score);
    } catch (const files::FileError&) {
      // A broken neighbor is not compared.
    }
  return all;
}

ChangeTable changes(const std::vector<const RunData*>& runs, const Seeds& a, const Seeds& b) {
  const auto verdicts = verdicts_of(a, b, *runs.at(0));
  std::size_t most = 0;
  bool has_band = false, has_p = false;
  for (const auto& [v, judged] : verdicts)
    most = std::max(most, v.n), has_band |= v.band.has_value(), has_p |= judged && v.p;
  ChangeTable table;
  table.titles = {"key or metric"};
  for (std::size_t i = 0; i < runs.size(); ++i)
    table.titles.push_back(std::string(1, static_cast<char>('A' + i)) +
                           (most > 1 && i < 2 ? fmt::format(", {} seeds", most) : ""));
  table.titles.emplace_back("change from A to B");
  if (has_band) table.titles.emplace_back("95 % interval");
  if (has_p) table.titles.emplace_back("p");
  table.titles.emplace_back("verdict");
  for (const auto& [key, values] : changed_keys(runs)) {
    ChangeTable::Row& row = table.rows.emplace_back();
    row.cells = {key};
    row.cells.insert(row.cells.end(), values.begin(), values.end());
    row.cells.resize(table.titles.size());
  }
  for (const auto& [v, judged] : verdicts) {
    const std::string& name = v.gate.metric;
    ChangeTable::Row& row = table.rows.emplace_back();
    row.metric = name, row.worst_seed = v.worst_seed, row.remark = judged ? v.remark : "";
    const MetricDisplay display = display_of(name);
    row.cells = {with_unit(display.title, display.unit), number_text(v.baseline), number_text(v.now)};
    for (std::size_t i = 2; i < runs.size(); ++i) {
      const auto value = runs[i]->value(name);
      row.cells.push_back(value ? number_text(display.factor * *value) : "-");
    }
    row.cells.push_back(change_text(v));
    if (has_band)
      row.cells.push_back(v.band ? signed_text(v.band->first) + " to " + signed_text(v.band->second) : "-");
    if (has_p) row.cells.push_back(judged && v.p ? fmt::format("{:.3g}", *v.p) : "-");
    row.cells.emplace_back(judged || v.verdict == Verdict::identical ? word(v.verdict) : "-");
  }
  return table;
}

}  // namespace sim::pages
