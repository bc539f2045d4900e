// Tables of several runs: what changes between two sets of runs, the metrics of each setting, and table
// files.
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

/// Escapes a text for LaTeX or Markdown.
std::string literal(std::string_view text, bool tex) {
  static const std::map<char, const char*> kWords{
      {'\\', "\\textbackslash{}"}, {'~', "\\textasciitilde{}"}, {'^', "\\textasciicircum{}"}};
  std::string out;
  for (const char c : text) {
    if (std::string_view(tex ? "&%$#_{}" : "|<*_").find(c) != std::string_view::npos) out += '\\';
    out += tex && kWords.contains(c) ? kWords.at(c) : std::string{c};
  }
  return out;
}

/// Returns the gates of compare, then the other shown metrics, which have no tolerance and thus no verdict.
std::vector<std::pair<MetricVerdict, bool>> verdicts_of(const Seeds& a, const Seeds& b, const RunData& run) {
  const std::vector<regression::Gate>& gates = regression::default_gates();
  std::vector<regression::Gate> others;
  for (const std::string& name : shown_metrics(run))
    if (std::ranges::find(gates, name, &regression::Gate::metric) == gates.end()) others.push_back({name});
  std::vector<std::pair<MetricVerdict, bool>> all;
  for (const auto& [of, judged] : {std::pair{gates, true}, {others, false}})
    for (const MetricVerdict& v : regression::compare({"", {}, a}, {"", {}, b}, of).metrics)
      if (v.baseline || v.now) all.emplace_back(v, judged);
  return all;
}

auto name_of(const ResultRow& row) {
  return std::tie(row.scenario, row.estimator, row.controller, row.robot, row.setting);
}

void add_value(MetricSummary& summary, double value, std::size_t run) {
  const auto loss = [&](double v) { return score::loss(v, score::direction_of(summary.metric)); };
  if (summary.values.empty() || loss(value) > loss(summary.worst))
    summary.worst = value, summary.worst_run = run;
  summary.values.push_back(value);
}

void add_run(ResultRow& row, const RunData& run, std::size_t number) {
  const bool completed = run.ending == scenario::Ending::completed;
  row.runs.push_back(number);
  row.completed += completed ? 1 : 0;
  row.coverage += completed ? run.coverage().value_or(0) : 0;
  if (run.frame_cpu_ms_median) row.cpu_ms.push_back(*run.frame_cpu_ms_median);
  for (const std::string& metric : shown_metrics(run)) {
    const auto value = run.value(metric);
    if (!value) continue;
    const std::string column = column_of(metric, run.alignment);
    auto summary = std::ranges::find(row.metrics, column, &MetricSummary::column);
    if (summary == row.metrics.end()) summary = row.metrics.insert(row.metrics.end(), {metric, column});
    add_value(*summary, *value, number);
    for (const result::JudgedLimit& judged : run.limits)
      if (judged.limit.metric == metric && !judged.limit.aggregate) summary->limit = judged.limit;
  }
}

/// Returns the loss of the median of the first metric, which no alignment affects.
double first_loss(const ResultRow& row) {
  const std::string first = shown_metrics(&ShownMetric::run).front();
  const auto found = std::ranges::find(row.metrics, first, &MetricSummary::column);
  return found == row.metrics.end() ? INFINITY
                                    : score::loss(score::median(found->values), score::direction_of(first));
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
    row.cells = {metric_label(name), number_text(v.baseline), number_text(v.now)};
    for (std::size_t i = 2; i < runs.size(); ++i) row.cells.push_back(number_text(runs[i]->value(name)));
    row.cells.push_back(change_text(v));
    if (has_band)
      row.cells.push_back(v.band ? signed_text(v.band->first) + " to " + signed_text(v.band->second) : "-");
    if (has_p) row.cells.push_back(judged && v.p ? fmt::format("{:.3g}", *v.p) : "-");
    row.cells.emplace_back(judged || v.verdict == Verdict::identical ? word(v.verdict) : "-");
  }
  return table;
}

std::string with_unit(const std::string& name, std::string_view unit) {
  return unit.empty() || unit == "1" ? name : fmt::format("{} [{}]", name, unit);
}

std::string metric_label(const std::string& metric, const std::string& column) {
  const auto* const known = score::find_metric(metric);
  return with_unit(column.empty() ? metric : column, known ? known->unit : "");
}

std::vector<ResultRow> result_rows(const std::vector<RunData>& runs) {
  std::vector<const RunData*> all;
  for (const RunData& run : runs) all.push_back(&run);
  const std::vector<std::string> settings = other_settings(all);
  std::vector<ResultRow> rows;
  std::vector<std::string> scenarios;  // in the given order
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (std::ranges::find(scenarios, runs[i].scenario) == scenarios.end())
      scenarios.push_back(runs[i].scenario);
    ResultRow own{runs[i].scenario, runs[i].estimator, runs[i].setting("walk.controller"),
                  runs[i].setting("world.robot"), settings[i]};
    auto row =
        std::ranges::find_if(rows, [&](const ResultRow& other) { return name_of(other) == name_of(own); });
    if (row == rows.end()) row = rows.insert(rows.end(), own);
    add_run(*row, runs[i], i);
  }
  for (ResultRow& row : rows) {
    row.coverage /= static_cast<double>(row.runs.size());
    for (MetricSummary& s : row.metrics) s.interval = score::median_interval(s.values);
  }
  std::ranges::stable_sort(rows, {}, [&](const ResultRow& row) {
    return std::tuple(std::ranges::find(scenarios, row.scenario), -std::round(100 * row.coverage),
                      first_loss(row));
  });
  return rows;
}

std::vector<std::pair<std::string, std::string ResultRow::*>> naming_columns(
    const std::vector<ResultRow>& rows) {
  std::vector<std::pair<std::string, std::string ResultRow::*>> columns{{"estimator", &ResultRow::estimator}};
  for (const auto& [title, member] : {std::pair{"controller", &ResultRow::controller},
                                      {"robot", &ResultRow::robot},
                                      {"setting", &ResultRow::setting}})
    if (std::ranges::any_of(rows, [&, m = member](const ResultRow& row) { return row.*m != rows[0].*m; }))
      columns.emplace_back(title, member);
  return columns;
}

std::string limit_text(const scenario::MetricLimit& limit) {
  return (limit.bound == scenario::Bound::at_most ? "≤ " : "≥ ") + number_text(limit.value);
}

TableFormat table_format(const fs::path& file) {
  for (const auto& [ending, format] :
       {std::pair{".csv", TableFormat::csv}, {".md", TableFormat::markdown}, {".tex", TableFormat::latex}})
    if (file.extension() == ending) return format;
  throw std::invalid_argument(fmt::format("{}: expected a name ending in .csv, .md or .tex", file.string()));
}

std::string median_text(double median, const std::optional<std::pair<double, double>>& interval) {
  return number_text(median) +
         (interval ? fmt::format(" [{}, {}]", number_text(interval->first), number_text(interval->second))
                   : "");
}

namespace {

/// Returns a table file. lines: titles, then rows; "-": absent. remark: put below the rows, but not in CSV.
std::string written_table(const std::vector<std::vector<std::string>>& lines, TableFormat format,
                          const std::string& remark) {
  if (format == TableFormat::csv) {
    std::string text;
    for (const auto& line : lines) {
      std::vector<std::string> fields;
      for (const std::string& cell : line) fields.push_back(cell == "-" ? "" : files::neutral_field(cell));
      text += fmt::format("{}\n", fmt::join(fields, ","));
    }
    return text;
  }
  const bool tex = format == TableFormat::latex;
  const auto row = [&](const std::vector<std::string>& line) {
    std::vector<std::string> cells;
    for (const std::string& cell : line) cells.push_back(literal(files::one_line(cell), tex));
    return tex ? fmt::format("{} \\\\\n", fmt::join(cells, " & "))
               : fmt::format("| {} |\n", fmt::join(cells, " | "));
  };
  const auto is_number = [&](std::size_t column) {
    return lines.size() > 1 && std::all_of(lines.begin() + 1, lines.end(), [&](const auto& line) {
             return line[column] == "-" ||
                    files::parse_number<double>(line[column].substr(0, line[column].find(' ')));
           });
  };
  std::string columns, dashes;
  for (std::size_t i = 0; i < lines[0].size(); ++i)
    columns += is_number(i) ? 'r' : 'l', dashes += is_number(i) ? "---:|" : "---|";
  std::string text = tex ? "% needs \\usepackage{booktabs}\n\\begin{tabular}{" + columns + "}\n\\toprule\n" +
                               row(lines[0]) + "\\midrule\n"
                         : row(lines[0]) + "|" + dashes + "\n";
  for (std::size_t i = 1; i < lines.size(); ++i) text += row(lines[i]);
  return text + (tex ? "\\bottomrule\n\\end{tabular}\n% " + remark + "\n" : "\n" + remark + "\n");
}

std::vector<std::vector<std::string>> exact_lines(const std::vector<RunData>& runs,
                                                  const std::vector<ResultRow>& rows) {
  std::vector<std::vector<std::string>> lines{{"scenario", "estimator", "controller", "robot", "setting",
                                               "runs", "completed", "coverage", "metric", "unit", "n",
                                               "median", "low_95", "high_95", "worst", "worst_seed"}};
  const auto text = [](auto value) { return fmt::format("{}", value); };
  for (const ResultRow& row : rows)
    for (const MetricSummary& s : row.metrics) {
      const auto* const known = score::find_metric(s.metric);
      lines.push_back(
          {row.scenario, row.estimator, row.controller, row.robot, row.setting, text(row.runs.size()),
           text(row.completed), text(row.coverage), s.column, known ? known->unit : "", text(s.values.size()),
           text(score::median(s.values)), s.interval ? text(s.interval->first) : "-",
           s.interval ? text(s.interval->second) : "-", text(s.worst), text(runs[s.worst_run].seed)});
    }
  return lines;
}

std::vector<std::vector<std::string>> short_lines(const std::vector<ResultRow>& rows) {
  std::vector<std::vector<std::string>> lines{{"scenario"}};
  const auto naming = naming_columns(rows);
  std::vector<std::string> columns;
  for (const auto& [title, member] : naming) lines[0].push_back(title);
  lines[0].insert(lines[0].end(), {"completed", "coverage"});
  for (const ResultRow& row : rows)
    for (const MetricSummary& s : row.metrics)
      if (std::ranges::find(columns, s.column) == columns.end())
        columns.push_back(s.column), lines[0].push_back(metric_label(s.metric, s.column));
  for (const ResultRow& row : rows) {
    std::vector<std::string>& line = lines.emplace_back(std::vector{row.scenario});
    for (const auto& [title, member] : naming) line.push_back(row.*member);
    line.insert(line.end(), {row.completed_text(), number_text(row.coverage_shown())});
    for (const std::string& column : columns) {
      const auto s = std::ranges::find(row.metrics, column, &MetricSummary::column);
      line.push_back(s == row.metrics.end() ? "-" : median_text(score::median(s->values), s->interval));
    }
  }
  return lines;
}

}  // namespace

std::string runs_table(const std::vector<RunData>& runs, TableFormat format) {
  const std::vector<ResultRow> rows = result_rows(runs);
  return written_table(format == TableFormat::csv ? exact_lines(runs, rows) : short_lines(rows), format,
                       "Medians over the runs [95 % interval of the median, with at least 6 runs].");
}

}  // namespace sim::pages
