// The table of results: a row per estimator, controller, robot and setting, for pages, papers and
// spreadsheets.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "sim/files/csv.h"
#include "sim/files/text.h"
#include "sim/pages/pages.h"
#include "sim/recording/recording_format.h"
#include "sim/score/metrics.h"
#include "sim/score/statistics.h"

namespace sim::pages {
namespace {

constexpr std::size_t kInterval = 6;  // fewer values have no 95 % interval of the median
constexpr std::array kBrackets{"95 % confidence interval", "smallest and largest value"};
constexpr std::array kTitles{"scenario", "errors", "estimator", "controller", "robot", "setting"};
constexpr std::array kNames{&ResultRow::scenario,   &ResultRow::errors, &ResultRow::estimator,
                            &ResultRow::controller, &ResultRow::robot,  &ResultRow::setting};

/// Returns how far a sole moves on the ground from its landing to its lift-off, mean over the steps.
std::optional<double> slip_m(const RunData& run) {
  if (!run.feet) return std::nullopt;
  const Column x = run.feet->numbers("moved_x"), y = run.feet->numbers("moved_y");
  double moved = 0, steps = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const std::string& phase = run.feet->text("phase")[i];
    steps += phase == "support";
    if (phase == "landing" || phase == "support" || phase == "lift_off") moved += std::hypot(x[i], y[i]);
  }
  return steps > 0 ? std::optional(moved / steps) : std::nullopt;
}

/// Returns the sum over the joints of |torque x velocity|, mean over the recorded walk.
std::optional<double> power_w(const RunData& run) {
  const fs::path torques = run.recording / recording::recording_format::kTorques;
  if (run.recording.empty() || !fs::exists(torques)) return std::nullopt;
  files::CsvReader torque(torques), angle(run.recording / "mav0/encoders0/data.csv");
  double work = 0, begin = 0, last = 0;
  std::vector<double> before;
  while (torque.next() && angle.next()) {
    last = torque.number(0);
    std::vector<double> now;
    for (std::size_t i = 1; i < torque.fields(); ++i) now.push_back(angle.number(i));
    for (std::size_t i = 0; i < before.size(); ++i)
      work += std::abs(torque.number(i + 1) * (now[i] - before[i]));
    if (before.empty()) begin = last;
    before = now;
  }
  return last > begin ? std::optional(work / (1e-9 * (last - begin))) : std::nullopt;
}

/// title: as in papers. unit, of: of a metric that is not in score.json but computed for a table.
struct ShownMetric {
  std::string_view name, title;
  unsigned where = 0;
  std::string_view unit = "";
  std::optional<double> (*of)(const RunData&) = nullptr;
};
constexpr ShownMetric kShown[]{{"ate_se3_rmse_m", "ATE", kOfRuns | kOfSweeps | kOfEstimators | kOfWalks},
                               {"rmse_m", "RMSE", kOfRuns | kOfSweeps | kOfEstimators},
                               {"ate_sim3_rmse_m", "ATE Sim(3)", kOfRuns},
                               {"rpe_1m_m", "RPE 1 m", kOfSweeps},
                               {"rpe_1m_deg", "RPE 1 m"},
                               {"end_position_error_m", "end error", kOfRuns | kOfSweeps | kOfEstimators},
                               {"end_yaw_error_deg", "end heading", kOfRuns},
                               {"tracked_fraction", "tracked", kOfRuns},
                               {"nees_position_mean", "NEES", kOfRuns | kOfSweeps | kOfEstimators},
                               {"loop_landmarks", "loop landmarks", kOfRuns | kOfSweeps},
                               {"navigation_rmse_m", "path error", kOfRuns | kOfWalks},
                               {"navigation_end_position_error_m", "goal error", kOfRuns},
                               {"navigation_end_yaw_error_deg", "goal heading", kOfRuns | kOfWalks},
                               {"vibration_below_2hz_m_s2", "vibration < 2 Hz", kOfSweeps},
                               {"vibration_2_to_8hz_m_s2", "vibration 2-8 Hz", kOfSweeps},
                               {"vibration_from_8hz_m_s2", "vibration > 8 Hz", kOfSweeps},
                               {"step_slip_m", "slip per step", kOfWalks, "m", slip_m},
                               {"joint_power_w", "power", kOfWalks, "W", power_w},
                               {"frame_cpu_ms_median", "CPU per frame", 0, "ms",
                                [](const RunData& run) { return run.frame_cpu_ms_median; }}};

const ShownMetric* shown(std::string_view metric) {
  const auto* const found = std::ranges::find(kShown, metric, &ShownMetric::name);
  return found == std::end(kShown) ? nullptr : found;
}

std::string own_unit(const std::string& metric) {
  if (const auto* const known = score::find_metric(metric)) return known->unit;
  return shown(metric) ? std::string(shown(metric)->unit) : "";
}

std::optional<double> value_of(const RunData& run, const std::string& metric) {
  const ShownMetric* const known = shown(metric);
  return known && known->of ? known->of(run) : run.value(metric);
}

// The conditions of a row: runs in other conditions are not ranked against each other.
auto condition_of(const ResultRow& row) { return std::tie(row.scenario, row.errors); }
auto name_of(const ResultRow& row) {
  return std::tie(row.scenario, row.errors, row.estimator, row.controller, row.robot, row.setting);
}

void add_run(ResultRow& row, const RunData& run, std::size_t number,
             const std::vector<std::string>& metrics) {
  const bool completed = run.ending == scenario::Ending::completed;
  row.runs.push_back(number);
  ++row.endings[std::string(name_of(run.ending))];
  row.coverage += completed ? run.coverage().value_or(0) : 0;
  for (const std::string& metric : metrics) {
    const std::string column = column_of(metric, run.alignment);
    auto summary = std::ranges::find(row.metrics, column, &MetricSummary::column);
    if (summary == row.metrics.end()) summary = row.metrics.insert(row.metrics.end(), {metric, column});
    const auto value = completed ? value_of(run, metric) : std::nullopt;
    if (!value) continue;
    const auto loss = [&](double v) { return score::loss(v, score::direction_of(metric)); };
    if (summary->values.empty() || loss(*value) > loss(summary->worst))
      summary->worst = *value, summary->worst_run = number;
    summary->values.push_back(*value);
  }
}

double loss(const MetricSummary& s) {
  return s.values.empty() ? INFINITY : score::loss(s.over_seeds.center, score::direction_of(s.metric));
}

/// Returns whether a row is better than another one beyond doubt.
bool is_better(const ResultRow& row, const ResultRow& other, const std::string& column) {
  const double covered = std::round(100 * row.coverage) - std::round(100 * other.coverage);
  const MetricSummary &a = *row.find(column), &b = *other.find(column);
  if (covered != 0 || loss(a) >= loss(b)) return covered > 0;
  const auto [low, high] = a.over_seeds.spread.value_or(std::pair(-INFINITY, INFINITY));
  return std::min(a.values.size(), b.values.size()) >= kInterval &&
         (high < b.over_seeds.spread->first || b.over_seeds.spread->second < low);
}

void mark_best(std::vector<ResultRow>& rows) {
  for (ResultRow& row : rows)
    for (MetricSummary& s : row.metrics) {
      std::size_t others = 0, beaten = 0;
      for (const ResultRow& other : rows) {
        const MetricSummary* const its = other.find(s.column);
        if (&other != &row && condition_of(other) == condition_of(row) && its && !its->values.empty())
          ++others, beaten += is_better(row, other, s.column);
      }
      s.best = !s.values.empty() && others > 0 && beaten == others;
    }
}

/// Returns three significant digits, and all before the point.
std::string short_text(double value) {
  return std::abs(value) < 99.95 ? fmt::format("{:#.3g}", value) : fmt::format("{:.0f}", value);
}

/// Escapes a text for LaTeX or Markdown. breaks: lines may break within long words.
std::string literal(std::string_view text, bool tex, bool breaks = false) {
  static const std::map<char, const char*> kWords{{'\\', "\\textbackslash{}"},  {'~', "\\textasciitilde{}"},
                                                  {'^', "\\textasciicircum{}"}, {'<', "\\textless{}"},
                                                  {'>', "\\textgreater{}"},     {'|', "\\textbar{}"}};
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i], next = i + 1 < text.size() ? text[i + 1] : ' ';
    if (std::string_view(tex ? "&%$#_{}" : "|<*_").find(c) != std::string_view::npos) out += '\\';
    out += tex && kWords.contains(c) ? kWords.at(c) : std::string{c};
    if (breaks && std::string_view("._=/").find(c) != std::string_view::npos && (next > '9' || c != '.'))
      out += "\\allowbreak{}";
  }
  return out;
}

std::string csv_text(const std::vector<RunData>& runs, const std::vector<ResultRow>& rows) {
  std::string text =
      "scenario,errors,estimator,controller,robot,setting,runs,completed,coverage,metric,unit,n,statistic,"
      "value,low,high,bracket,worst,worst_seed,best\n";
  for (const ResultRow& row : rows)
    for (const MetricSummary& s : row.metrics) {
      for (const auto member : kNames) text += files::neutral_field(row.*member) + ",";
      text += fmt::format("{},{},{},{},{},{},{},", row.runs.size(), row.completed(), row.coverage, s.column,
                          own_unit(s.metric), s.values.size(), statistic_of(s.metric));
      const auto& [center, spread] = s.over_seeds;
      text += s.values.empty()
                  ? ",,,,,,\n"
                  : fmt::format("{},{},{},{},{},{}\n", center,
                                spread ? fmt::format("{},{}", spread->first, spread->second) : ",",
                                spread ? kBrackets.at(s.values.size() < kInterval) : "", s.worst,
                                runs[s.worst_run].seed, s.best ? 1 : 0);
    }
  return text;
}

std::string markdown_text(const ResultTable& table) {
  std::vector<std::string> titles, dashes;
  for (const ResultTable::Column& column : table.columns) {
    titles.push_back(literal(with_unit(column.title, column.unit), false));
    dashes.emplace_back(column.is_number ? "---:" : "---");
  }
  std::string text = fmt::format("| {} |\n|{}|\n", fmt::join(titles, " | "), fmt::join(dashes, "|"));
  for (const auto& row : table.rows) {
    std::vector<std::string> cells;
    for (const ResultTable::Cell& cell : row) {
      const std::string shown = literal(files::one_line(cell.text), false);
      cells.push_back((cell.best ? "**" + shown + "**" : shown) +
                      (cell.small.empty() ? "" : " " + cell.small));
    }
    text += fmt::format("| {} |\n", fmt::join(cells, " | "));
  }
  return text + "\n" + literal(table.note, false) + "\n";
}

/// Returns a table as wide as the text: names share the first column and wrap, and a condition (scenario and
/// errors) has a line above its rows.
std::string latex_text(const ResultTable& table) {
  const auto& columns = table.columns;
  const auto condition = static_cast<std::size_t>(std::ranges::count_if(
      columns, [](const auto& c) { return c.title == "scenario" || c.title == "errors"; }));
  const auto names =
      static_cast<std::size_t>(std::ranges::count(columns, false, &ResultTable::Column::is_number));
  const auto joined = [](const auto& row, std::size_t begin, std::size_t end, auto member) {
    std::vector<std::string> words;
    for (std::size_t i = begin; i < end; ++i)
      if (!(row[i].*member).empty()) words.push_back(literal(files::one_line(row[i].*member), true, true));
    return fmt::format("{}", fmt::join(words, ", "));
  };
  std::string text =
      "% needs \\usepackage{booktabs,tabularx}\n\\par\\begingroup\\small\\setlength{\\tabcolsep}{4pt}%\n"
      "\\newcommand{\\two}[2]{\\begin{tabular}[t]{@{}r@{}}#1\\\\\\scriptsize#2\\end{tabular}}%\n"
      "\\noindent\\begin{tabularx}{\\linewidth}{@{}>{\\raggedright\\arraybackslash}X" +
      std::string(columns.size() - names, 'r') + "@{}}\n\\toprule\n" +
      joined(columns, condition, names, &ResultTable::Column::title);
  for (std::size_t i = names; i < columns.size(); ++i)
    text += fmt::format(" & \\two{{{}}}{{{}}}", literal(columns[i].title, true),
                        columns[i].unit.empty() ? "" : "[" + literal(columns[i].unit, true) + "]");
  std::string last;
  for (const auto& row : table.rows) {
    const std::string now = joined(row, 0, condition, &ResultTable::Cell::text);
    text += &row == &table.rows[0] || now != last ? " \\\\\n\\midrule\n" : " \\\\\n\\addlinespace[2pt]\n";
    if (now != last)
      text +=
          fmt::format("\\multicolumn{{{}}}{{@{{}}p{{\\linewidth}}@{{}}}}{{\\raggedright\\emph{{{}}}}} \\\\\n",
                      columns.size() - names + 1, now);
    last = now;
    text += joined(row, condition, names, &ResultTable::Cell::text);
    for (std::size_t i = names; i < row.size(); ++i) {
      const std::string shown = literal(row[i].text, true);
      text += fmt::format(" & \\two{{{}}}{{{}}}", row[i].best ? "\\textbf{" + shown + "}" : shown,
                          literal(row[i].small, true));
    }
  }
  return text + " \\\\\n\\bottomrule\n\\end{tabularx}\n\\par\\smallskip\\footnotesize\\noindent " +
         literal(table.note, true) + "\\par\\endgroup\n";
}

/// True if all true poses of the completed runs have estimates, or none as without an estimator.
bool is_covered(const ResultRow& row) {
  return row.coverage == 0 ||
         row.coverage * static_cast<double>(row.runs.size()) >= 0.995 * static_cast<double>(row.completed());
}

ResultTable::Cell cell_of(const ResultRow& row, const std::string& column) {
  const MetricSummary* const s = row.find(column);
  if (!s || s->values.empty()) return {"-"};
  const double factor = display_of(s->metric).factor;
  const auto& [center, spread] = s->over_seeds;
  std::string small = spread ? fmt::format("[{}, {}]", short_text(factor * spread->first),
                                           short_text(factor * spread->second))
                             : "";
  if (s->values.size() != row.completed()) small += fmt::format(" n = {}", s->values.size());
  return {short_text(factor * center), small, s->best, s};
}

/// True if all rows have the same number of runs, and all of these completed.
bool is_uniform(const std::vector<ResultRow>& rows) {
  return std::ranges::all_of(rows, [&](const ResultRow& row) {
    return row.completed() == row.runs.size() && row.runs.size() == rows[0].runs.size();
  });
}

/// Returns the sentences below a table: what a value and its bracket are.
std::string note_of(const std::vector<ResultRow>& rows) {
  std::set<std::string> statistics;
  std::set<std::string_view> brackets;
  bool best = false;
  for (const ResultRow& row : rows)
    for (const MetricSummary& s : row.metrics) {
      if (!s.values.empty()) statistics.insert(statistic_of(s.metric));
      if (s.over_seeds.spread) brackets.insert(kBrackets.at(s.values.size() < kInterval));
      best |= s.best;
    }
  return fmt::format("{} of {} completed runs{}.{}",
                     statistics.size() > 1         ? "Median (NEES, NIS: mean)"
                     : statistics.contains("mean") ? "Mean"
                                                   : "Median",
                     is_uniform(rows) ? fmt::format("n = {}", rows[0].runs.size()) : "the n",
                     brackets.empty() ? "" : fmt::format(" [{}]", fmt::join(brackets, "; for n < 6 ")),
                     best ? " Bold: the best, if its interval overlaps no other." : "");
}

}  // namespace

std::vector<std::string> shown_metrics(Shown where) {
  std::vector<std::string> names;
  for (const ShownMetric& metric : kShown)
    if (metric.where & where) names.emplace_back(metric.name);
  return names;
}

std::vector<std::string> shown_metrics(const RunData& run) {
  std::vector<std::string> names = shown_metrics(kOfRuns);
  if (!run.waist_desired)
    std::erase_if(names, [](const auto& name) { return name.starts_with("navigation"); });
  return names;
}

std::vector<std::string> table_metrics() {
  std::vector<std::string> names;
  for (const score::MetricDefinition& metric : score::metric_definitions()) names.push_back(metric.name);
  for (const ShownMetric& metric : kShown)
    if (metric.of) names.emplace_back(metric.name);
  return names;
}

MetricDisplay display_of(const std::string& metric, const std::string& column) {
  const std::string unit = own_unit(metric);
  std::string title(shown(metric) ? shown(metric)->title : metric.substr(0, metric.rfind("_" + unit)));
  std::ranges::replace(title, '_', ' ');
  if (column.size() > metric.size()) title += " (" + column.substr(metric.size() + 7) + ")";  // _after_sim3
  const bool error = unit == "m" && score::direction_of(metric).worst != score::Worst::smallest;
  return {title, error ? "mm" : unit == "1" ? "" : unit, error ? kMm : 1};
}

std::string with_unit(const std::string& name, std::string_view unit) {
  return unit.empty() || unit == "1" ? name : fmt::format("{} [{}]", name, unit);
}

std::string metric_label(const std::string& metric) {
  const auto* const known = score::find_metric(metric);
  return with_unit(metric, known ? known->unit : "");
}

std::string limit_text(const scenario::MetricLimit& limit) {
  return (limit.bound == scenario::Bound::at_most ? "≤ " : "≥ ") + number_text(limit.value);
}

std::string statistic_of(const std::string& metric) {
  return score::direction_of(metric).worst == score::Worst::farthest_from_expected ? "mean" : "median";
}

OverSeeds over_seeds(const std::string& metric, const std::vector<double>& values) {
  const bool mean = statistic_of(metric) == "mean";
  OverSeeds over{mean ? score::mean(values) : score::median(values)};
  if (values.size() < 2) return over;
  if (values.size() < kInterval) {
    const auto [least, most] = std::ranges::minmax(values);
    over.spread = {least, most};
  } else if (!mean) {
    over.spread = score::median_interval(values);
  } else if (const auto test = score::t_test(values)) {
    over.spread = {test->low, test->high};
  }
  return over;
}

const MetricSummary* ResultRow::find(const std::string& column) const {
  const auto found = std::ranges::find(metrics, column, &MetricSummary::column);
  return found == metrics.end() ? nullptr : &*found;
}

std::size_t ResultRow::completed() const {
  const auto found = endings.find("completed");
  return found == endings.end() ? 0 : found->second;
}

std::vector<ResultRow> result_rows(const std::vector<RunData>& runs,
                                   const std::vector<std::string>& metrics) {
  std::vector<const RunData*> all;
  for (const RunData& run : runs) all.push_back(&run);
  const std::vector<std::string> settings = other_settings(all), errors = changed_errors(all);
  std::vector<ResultRow> rows;
  std::vector<std::string> scenarios;  // in the given order
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (std::ranges::find(scenarios, runs[i].scenario) == scenarios.end())
      scenarios.push_back(runs[i].scenario);
    ResultRow own{runs[i].scenario,
                  errors[i],
                  runs[i].estimator,
                  runs[i].setting("walk.controller"),
                  runs[i].setting("world.robot"),
                  settings[i]};
    auto row =
        std::ranges::find_if(rows, [&](const ResultRow& other) { return name_of(other) == name_of(own); });
    if (row == rows.end()) row = rows.insert(rows.end(), own);
    add_run(*row, runs[i], i, metrics.empty() ? shown_metrics(runs[i]) : metrics);
  }
  for (ResultRow& row : rows) {
    row.coverage /= static_cast<double>(row.runs.size());
    if (metrics.empty()) std::erase_if(row.metrics, [](const auto& s) { return s.values.empty(); });
    for (MetricSummary& s : row.metrics)
      if (!s.values.empty()) s.over_seeds = over_seeds(s.metric, s.values);
  }
  const std::string first = metrics.empty() ? shown_metrics(kOfRuns).front() : metrics.front();
  std::ranges::stable_sort(rows, {}, [&](const ResultRow& row) {
    const auto found = std::ranges::find(row.metrics, first, &MetricSummary::metric);
    return std::tuple(std::ranges::find(scenarios, row.scenario), row.errors, -std::round(100 * row.coverage),
                      found == row.metrics.end() ? INFINITY : loss(*found));
  });
  mark_best(rows);
  return rows;
}

ResultTable result_table(const std::vector<ResultRow>& rows) {
  ResultTable table{{}, {}, note_of(rows)};
  std::vector<std::string ResultRow::*> names;
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (std::ranges::any_of(rows, [&](const auto& row) { return row.*kNames[i] != rows[0].*kNames[i]; }))
      table.columns.push_back({kTitles[i]}), names.push_back(kNames[i]);
  if (names.empty()) table.columns.push_back({"estimator"}), names.push_back(&ResultRow::estimator);
  const bool uniform = is_uniform(rows), covered = std::ranges::all_of(rows, is_covered);
  if (!uniform) table.columns.push_back({"completed", "", true});
  if (!covered) table.columns.push_back({"coverage", "", true});
  std::vector<std::string> columns;
  for (const ResultRow& row : rows)
    for (const MetricSummary& s : row.metrics)
      if (std::ranges::find(columns, s.column) == columns.end()) {
        const MetricDisplay shown = display_of(s.metric, s.column);
        columns.push_back(s.column), table.columns.push_back({shown.title, shown.unit, true});
      }
  for (const ResultRow& row : rows) {
    auto& line = table.rows.emplace_back();
    for (const auto member : names) line.push_back({row.*member});
    std::vector<std::string> other;
    for (const auto& [ending, count] : row.endings)
      if (ending != "completed") other.push_back(fmt::format("{} {}", count, ending));
    if (!uniform)
      line.push_back({fmt::format("{} of {}", row.completed(), row.runs.size()),
                      other.empty() ? "" : fmt::format("({})", fmt::join(other, ", "))});
    if (!covered) line.push_back({row.coverage > 0 ? short_text(row.coverage) : "-"});
    for (const std::string& column : columns) line.push_back(cell_of(row, column));
  }
  return table;
}

TableFormat table_format(const fs::path& file) {
  for (const auto& [ending, format] :
       {std::pair{".csv", TableFormat::csv}, {".md", TableFormat::markdown}, {".tex", TableFormat::latex}})
    if (file.extension() == ending) return format;
  throw std::invalid_argument(fmt::format("{}: expected a name ending in .csv, .md or .tex", file.string()));
}

std::string runs_table(const std::vector<RunData>& runs, TableFormat format,
                       const std::vector<std::string>& metrics) {
  const bool walks = std::ranges::any_of(runs, [&](const RunData& run) {
    return run.setting("walk.controller") != runs[0].setting("walk.controller") ||
           run.setting("world.robot") != runs[0].setting("world.robot");
  });
  const std::vector<ResultRow> rows =
      result_rows(runs, metrics.empty() ? shown_metrics(walks ? kOfWalks : kOfEstimators) : metrics);
  if (format == TableFormat::csv) return csv_text(runs, rows);
  return format == TableFormat::markdown ? markdown_text(result_table(rows)) : latex_text(result_table(rows));
}

}  // namespace sim::pages
