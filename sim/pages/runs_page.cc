// The page about one or several runs: the sections of a run, and the tables of runs.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/pages/pages.h"
#include "sim/recording/image_file.h"
#include "sim/recording/recording_format.h"
#include "sim/result/limits.h"
#include "sim/scenario/keys.h"
#include "sim/scenario/scenario.h"
#include "sim/score/metrics.h"
#include "sim/score/statistics.h"

namespace sim::pages {
namespace {

constexpr std::size_t kPictures = 8;
constexpr std::size_t kLongText = 30;  // wraps in a column of some width

std::string view_command(const RunData& run) {
  return "tools/gaitslam view " + files::shell_word(run.folder.string());
}

std::string ellipse_svg(const slam::Search& search) {
  const Eigen::Vector3d shape = ellipse(search.S);
  std::string svg = fmt::format(
      "<ellipse class='{}' transform='translate({:.1f} {:.1f})rotate({:.1f})' rx='{:.1f}' ry='{:.1f}'/>",
      search.used ? "used" : "missed", search.pixel.x() + 0.5, search.pixel.y() + 0.5, kDeg * shape(2),
      shape(0), shape(1));
  if (search.used && search.match)
    svg += fmt::format("<rect class='used' x='{:.1f}' y='{:.1f}' width='11' height='11'/>",
                       search.match->x() - 5, search.match->y() - 5);
  return svg;
}

std::string picture_html(const Frame& frame, const cv::Mat& image, const Frame& first) {
  const double shown = std::round(10 * slam::seconds(frame.t - first.t)) / 10;
  std::string html = fmt::format(
      "<figure><svg class='picture' xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0} {1}' role='img' "
      "aria-label='head camera at {2} s'><image width='{0}' height='{1}' href='data:image/png;base64,{3}'/>",
      image.cols, image.rows, shown, base64(recording::encode_png(image)));
  if (frame.report)
    for (const slam::Search& search : frame.report->searched) html += ellipse_svg(search);
  return html + fmt::format("</svg><span class='soft'>{} s</span></figure>", shown);
}

/// Returns "passed", "missed a limit", or the ending if it is not allowed.
std::string verdict_of(const RunData& run) {
  const scenario::Scenario scenario = scenario::read_scenario(run.folder / "scenario.yaml").scenario;
  if (!result::is_allowed(scenario, run.ending)) return std::string(name_of(run.ending));
  return result::exit_code(scenario, run.ending, run.limits) == 0 ? "passed" : "missed a limit";
}

/// The sections of one run. Their ids start with the same prefix.
class RunSections {
 public:
  explicit RunSections(const RunData& run) : run_(run) {}

  std::string html(const std::string& prefix, const std::string& title) const {
    const std::string aligned =
        "<p>The truth contains only positions, in its own frame. It is drawn after SE(3) alignment with the "
        "estimate.</p>";
    const bool has = run_.errors.has_value();
    std::vector<Section> all{
        {"verdict", title, verdict()},
        {"paths", "Plan, truth and estimate",
         (run_.truth_aligned ? aligned : "") +
             figures({"from_above", "waist_from_above", "height", "correct", "map"})},
        {"errors", "Errors with 3-sigma envelopes", has ? images_text() + figures({"error_"}) : ""},
        {"consistency", "Consistency", figures({"nees", "nis"})},
        {"loop", "Loop closure", has ? closure_text() + figures({"closure", "matches"}) : ""},
        {"slip", "Slip of each step", figures({"slip"})},
        {"pictures", "Images of the head camera", picture_strip(run_, kPictures)},
        {"time", "Latency and dropped frames", figures({"latency"})},
        {"cpu", "CPU time", cpu()},
        {"metrics", "All metrics", metrics_table()},
        {"configuration", "Configuration", configuration()},
        {"again", "View it and run it again",
         fmt::format(
             "<p class='soft'>The view plays the run in a browser; append #t=SECONDS to its URL to open it "
             "at that time.</p><pre>{}</pre>{}",
             escaped(view_command(run_)), command_to_run())}};
    for (Section& section : all) section.id = prefix + section.id;
    return sections_html(all, true);
  }

 private:
  std::string cpu() const {
    if (!run_.estimate) return "";
    return fmt::format("<p>CPU time of the estimator per frame: mean {} ms, median {} ms, p99 {} ms.</p>",
                       number_text(run_.frame_cpu_ms_mean), number_text(run_.frame_cpu_ms_median),
                       number_text(run_.frame_cpu_ms_p99)) +
           figures({"cpu"});
  }

  std::string verdict() const {
    const std::string verdict = verdict_of(run_);
    std::string html =
        fmt::format("<p><span class='verdict {}'>{}</span> {}", verdict == "passed" ? "good" : "bad",
                    escaped(verdict), escaped(run_.about.cause));
    if (run_.about.counterfactual)
      html += fmt::format(" Counterfactual: {}.", escaped(*run_.about.counterfactual));
    if (run_.about.alignment == "none")
      html += " Its trajectory was scored without alignment.";
    else if (!run_.about.alignment.empty())
      html += fmt::format(" Its trajectory was aligned with the truth ({}) before it was scored.",
                          escaped(run_.about.alignment));
    html += "</p>";
    for (const std::string& remark : noise_remarks(run_))
      html += fmt::format("<p><b class='bad'>Inconsistent:</b> {}.</p>", escaped(remark));
    return html + cards() + limits_table();
  }

  std::string cards() const {
    std::string html = "<div class='cards'>";
    for (const std::string& name : shown_metrics(run_)) {
      const auto value = run_.value(name);
      if (!value) continue;
      const auto [title, unit, factor] = display_of(name, column_of(name, run_.alignment));
      html += fmt::format("<div class='card'><b>{} {}</b><span class='soft'>{}{}</span></div>",
                          number_text(factor * *value), unit, escaped(title),
                          name.starts_with("nees") ? " (3 expected)" : "");
    }
    return html + "</div>";
  }

  std::string limits_table() const {
    if (run_.limits.empty()) return "<p class='soft'>The scenario sets no limits.</p>";
    std::vector<TableRow> rows;
    for (const auto& [limit, value, passed, reason] : run_.limits) {
      TableCell verdict{"not judged"};
      if (passed) verdict = *passed ? TableCell{"passed", "good"} : TableCell{"MISSED", "bad"};
      rows.push_back({{text_cell(limit.metric), number_cell(value), {limit_text(limit), "number"}, verdict}});
    }
    return table_html("limits", {"limit on", "value", "limit", "verdict"}, rows);
  }

  std::string figures(std::initializer_list<std::string_view> prefixes) const {
    std::string html;
    for (const Figure& figure : figures_)
      if (std::ranges::any_of(prefixes, [&](auto p) { return figure.name.starts_with(p); }))
        html += figure_html(figure);
    return figures_html(html);
  }

  /// Returns no command for a result with an external program, because copying it would start that program.
  std::string command_to_run() const {
    if (scenario_.estimator.source != programs::Source::built_in)
      return "<p class='soft'>Its scenario.yaml names an external program as estimator; running it again "
             "would start that program.</p>";
    return "<pre>tools/gaitslam run " + escaped(files::shell_word((run_.folder / "scenario.yaml").string())) +
           " --out DIR</pre>";
  }

  std::string closure_text() const {
    const auto value = [&](const char* name) { return number_text(run_.value(name)); };
    if (run_.value("loop_time_s"))
      return fmt::format(
          "<p>The loop was closed at {} s by {} landmarks in total. The position error was {} m before the "
          "closure and {} m one second after it.</p>",
          value("loop_time_s"), value("loop_landmarks"), value("loop_error_before_m"),
          value("loop_error_after_m"));
    std::string why = "too few landmarks were recognized";
    for (const result::SeedMetric& metric : run_.metrics)
      if (metric.name == "loop_time_s" && !metric.reason.empty()) why = metric.reason;
    return fmt::format("<p class='soft'>The loop was not closed: {}.</p>", escaped(why));
  }

  std::string images_text() const {
    const auto ate = run_.value("ate_se3_rmse_m"), odometry = run_.value("odometry_ate_se3_rmse_m");
    if (!ate || !odometry) return "";
    return fmt::format(
        "<p>The ATE is {} mm. Without images, the same sensors (estimator odometry, the thin line) have {} "
        "mm, {:.1f} times as much.</p>",
        number_text(kMm * *ate), number_text(kMm * *odometry), *odometry / *ate);
  }

  std::string metrics_table() const {
    std::vector<TableRow> rows;
    std::map<std::string, std::vector<std::string>> undefined;  // metrics by the reason
    for (const result::SeedMetric& metric : run_.metrics) {
      const score::MetricDefinition* const known = score::find_metric(metric.name);
      if (!metric.value) {
        undefined[metric.reason].push_back(metric.name);
        continue;
      }
      rows.push_back({{code_cell(column_of(metric.name, run_.alignment)), number_cell(metric.value),
                       text_cell(metric.unit == "1" ? "" : metric.unit),
                       text_cell(known ? known->definition : "", "soft")}});
    }
    std::string html = table_html("metrics", {"metric", "value", "unit", "definition"}, rows);
    for (const auto& [reason, names] : undefined)
      html += fmt::format("<p class='soft'>Not defined here ({}): {}</p>", escaped(reason),
                          escaped(fmt::format("{}", fmt::join(names, ", "))));
    return html;
  }

  std::string configuration() const {
    std::vector<TableRow> rows;
    for (const auto& key : scenario::scenario_keys()) {
      if (!scenario::has_section(scenario_, key.name)) continue;
      const auto set_by = run_.about.set_by.find(key.name);
      rows.push_back({{code_cell(key.name), code_cell(key.print(scenario_)),
                       text_cell(scenario::unit_of(key.name).value_or("")),
                       text_cell(set_by == run_.about.set_by.end() ? "default" : set_by->second, "soft")}});
    }
    return fmt::format("<details><summary>{} keys and where each was set</summary>{}</details>", rows.size(),
                       table_html("configuration", {"key", "value", "unit", "from"}, rows));
  }

  const RunData& run_;
  scenario::Scenario scenario_ = scenario::read_scenario(run_.folder / "scenario.yaml").scenario;
  std::vector<Figure> figures_ = run_figures(run_);
};

constexpr std::size_t kInFull = 2;  // runs: about 1.3 MB each

/// The runs of a page and how they differ.
struct PageRuns {
  explicit PageRuns(const std::vector<RunData>& runs)
      : all(runs), in_full(runs.size(), runs.size() <= kInFull) {
    std::vector<const RunData*> each;
    for (const RunData& run : runs) each.push_back(&run);
    names = variants(each);
    std::map<std::string, int> count;
    const auto whole = [&](std::size_t i) { return runs[i].label() + ", " + names[i]; };
    for (std::size_t i = 0; i < runs.size(); ++i) ++count[runs[i].label()], ++count[whole(i)];
    std::map<std::pair<std::string, std::string>, std::size_t> worst;
    const auto ate = [&](std::size_t i) { return runs[i].value("ate_se3_rmse_m").value_or(INFINITY); };
    for (std::size_t i = 0; i < runs.size(); ++i) {
      labels.push_back((count[runs[i].label()] > 1 ? whole(i) : runs[i].label()) +
                       (count[whole(i)] > 1 ? ", " + runs[i].folder.string() : ""));
      std::size_t& so_far = worst.emplace(std::pair{runs[i].scenario, names[i]}, i).first->second;
      if (ate(i) > ate(so_far)) so_far = i;
    }
    for (const auto& [group, i] : worst) in_full[i] = true;
  }

  std::vector<std::size_t> of(const std::string& scenario) const {
    std::vector<std::size_t> numbers;
    for (std::size_t i = 0; i < all.size(); ++i)
      if (all[i].scenario == scenario) numbers.push_back(i);
    return numbers;
  }
  /// Returns a link to a run if the page shows it in full, otherwise the text.
  std::string link(std::size_t i, const std::string& text) const {
    return in_full[i] ? fmt::format("<a href='#run-{0}' data-run='run-{0}'>{1}</a>", i, escaped(text))
                      : escaped(text);
  }

  const std::vector<RunData>& all;
  std::vector<std::string> names;   ///< the variant of each
  std::vector<std::string> labels;  ///< unique: with the variant if needed, and the folder if that is not
                                    ///< enough
  std::vector<bool> in_full;        ///< shown in full: all, or the worst of each scenario and variant
};

std::string table(const PageRuns& runs, const std::string& scenario) {
  std::vector<std::string> titles{"run", "verdict", "ending"};
  std::map<std::size_t, std::map<std::string, std::optional<double>>> values;  // by run and column
  for (const std::size_t i : runs.of(scenario))
    for (const std::string& metric : shown_metrics(runs.all[i])) {
      const auto [title, unit, factor] = display_of(metric, column_of(metric, runs.all[i].alignment));
      const std::string column = with_unit(title, unit);
      const auto value = runs.all[i].value(metric);
      if (!value) continue;
      values[i][column] = factor * *value;
      if (std::ranges::find(titles, column) == titles.end()) titles.push_back(column);
    }
  std::vector<TableRow> rows;
  for (auto& [i, of_run] : values) {
    const RunData& run = runs.all[i];
    TableRow& row = rows.emplace_back(TableRow{
        {{runs.link(i, runs.labels[i])}, text_cell(verdict_of(run)), text_cell(name_of(run.ending))}});
    for (std::size_t k = 3; k < titles.size(); ++k) row.cells.push_back(number_cell(of_run[titles[k]]));
  }
  return table_html("runs", titles, rows, true);
}

TableCell result_cell(const PageRuns& runs, const ResultTable::Cell& cell) {
  std::string html =
      (cell.best ? "<b class='good'>" + cell.text + "</b> " : escaped(cell.text) + " ") + escaped(cell.small);
  if (!cell.of) return {html};
  const MetricSummary& s = *cell.of;
  const RunData& run = runs.all[s.worst_run];
  const auto t = worst_instant(run, s.metric);
  const std::string worst = fmt::format("seed {}{}", run.seed, t ? fmt::format(", {:.2f} s", *t) : "");
  return {fmt::format("{}<br><small>worst {}: {}</small>", html,
                      number_text(display_of(s.metric).factor * s.worst), runs.link(s.worst_run, worst))};
}

std::string results_html(const PageRuns& runs, const std::string& scenario,
                         const std::vector<std::string>& metrics) {
  std::vector<ResultRow> rows = result_rows(runs.all, metrics);
  std::erase_if(rows, [&](const ResultRow& row) { return row.scenario != scenario; });
  const ResultTable table = result_table(rows);
  std::vector<std::string> titles;
  for (const ResultTable::Column& column : table.columns)
    titles.push_back(with_unit(column.title, column.unit));
  std::vector<TableRow> lines;
  for (const auto& row : table.rows) {
    TableRow& line = lines.emplace_back();
    for (const ResultTable::Cell& cell : row) {
      line.cells.push_back(result_cell(runs, cell));
      const bool is_number = table.columns[line.cells.size() - 1].is_number;
      line.cells.back().style = is_number ? "number" : cell.text.size() > kLongText ? "long" : "";
    }
  }
  return "<h3>Results</h3>" + table_html("settings", titles, lines, true) +
         fmt::format(
             "<p class='soft'>{} The best row of each kind of errors comes first: by coverage, the fraction "
             "of "
             "true poses with an estimate, then by the first metric.</p>",
             escaped(table.note));
}

constexpr std::size_t kMostCompared = 4;  // variants that are compared with the first

/// Returns the seed that got worse by the most in a row, and how to view both runs at its worst instant.
std::string worst_html(const ChangeTable::Row& row, const std::vector<const RunData*>& a,
                       const std::vector<const RunData*>& b) {
  const auto of = [&](const auto& runs) {
    return std::ranges::find_if(runs, [&](const RunData* run) { return run->seed == row.worst_seed; });
  };
  if (!row.worst_seed || of(a) == a.end() || of(b) == b.end()) return "-";
  const auto t = worst_instant(**of(b), row.metric);
  const std::string at = t ? fmt::format("{:.2f}", *t) : "";
  return fmt::format("<details><summary>seed {}{}</summary><pre>{} {}{}</pre></details>", *row.worst_seed,
                     t ? ", " + at + " s" : "", escaped(view_command(**of(a))),
                     escaped(files::shell_word((*of(b))->folder.string())),
                     t ? "\nand #t=" + at + " after its address" : "");
}

std::string changes_html(const PageRuns& runs, const std::string& scenario) {
  std::vector<std::string> order;
  std::map<std::string, std::vector<const RunData*>> groups;
  std::map<std::string, std::vector<result::SeedScore>> scores;
  for (const std::size_t i : runs.of(scenario)) {
    const std::string& name = runs.names[i];
    if (!groups.contains(name)) order.push_back(name);
    groups[name].push_back(&runs.all[i]), scores[name].push_back(runs.all[i]);
  }
  std::string html;
  for (std::size_t k = 1; k < std::min(order.size(), 1 + kMostCompared); ++k) {
    const auto &a = groups[order[0]], &b = groups[order[k]];
    ChangeTable table = changes({a[0], b[0]}, scores[order[0]], scores[order[k]]);
    table.titles.emplace_back("worst for B");
    std::vector<TableRow> rows;
    for (const ChangeTable::Row& row : table.rows) {
      TableRow& line = rows.emplace_back();
      for (const std::string& cell : row.cells) line.cells.push_back(text_cell(cell));
      if (!row.remark.empty()) line.cells.back().html += " <small>" + escaped(row.remark) + "</small>";
      line.cells.push_back({worst_html(row, a, b)});
    }
    html += fmt::format("<h3>A: {}<br>B: {}</h3>{}", escaped(order[0]), escaped(order[k]),
                        table_html("changes", table.titles, rows, true));
  }
  if (order.size() > 1 + kMostCompared)
    html += fmt::format("<p class='soft'>{} more variants are not compared with the first.</p>",
                        order.size() - 1 - kMostCompared);
  return html;
}

/// Returns a scatter plot of a scenario's runs over two metrics, drawn by web/pages.js; empty for fewer than
/// two runs.
std::string scatter_html(const PageRuns& runs, const std::string& scenario) {
  const std::vector<std::size_t> of_scenario = runs.of(scenario);
  if (of_scenario.size() < 2) return "";
  nlohmann::ordered_json settings = nlohmann::ordered_json::object(), metrics;
  for (const std::string& name : shown_metrics(kOfRuns))
    metrics.push_back(with_unit(display_of(name).title, display_of(name).unit));
  for (const std::size_t i : of_scenario) {
    nlohmann::ordered_json values;
    for (const std::string& name : shown_metrics(kOfRuns)) {
      const auto value = runs.all[i].value(name);
      values.push_back(value ? nlohmann::ordered_json(display_of(name).factor * *value) : nullptr);
    }
    settings[files::sanitize(runs.names[i])].push_back(values);
  }
  const nlohmann::ordered_json all{{"metrics", metrics}, {"settings", settings}};
  return fmt::format("<div class='scatter' data-runs='{}'></div>", escaped(files::json_text(all)));
}

/// Returns all runs in detail. One is visible at a time; web/pages.js selects which.
std::string runs_in_detail(const PageRuns& runs) {
  std::string options, html;
  const bool several = runs.all.size() > 1;
  for (std::size_t i = 0; i < runs.all.size(); ++i) {
    if (!runs.in_full[i]) continue;
    const std::string id = fmt::format("run-{}", i);
    options += fmt::format("<option value='{}'>{}</option>", id, escaped(runs.labels[i]));
    html += fmt::format("<div class='run' id='{}'{}>", id, html.empty() ? "" : " hidden") +
            run_sections(runs.all[i], id + "-", several ? runs.labels[i] : "Verdict") + "</div>\n";
  }
  if (!several) return html;
  std::string head = "<p class='no-print'>Shown below: <select id='run' aria-label='run shown below'>" +
                     options + "</select></p>";
  if (const auto left = std::ranges::count(runs.in_full, false); left > 0)
    head += fmt::format(
        "<p class='soft'>Only the worst run of each scenario and variant is shown in full; for the other {}, "
        "use tools/gaitslam report FOLDER.</p>",
        left);
  return head + html;
}

}  // namespace

std::string picture_strip(const RunData& run, std::size_t count) {
  if (run.recording.empty()) return "";
  const Pictures pictures(run.recording);
  const std::vector<std::string> files = pictures.files(run.frames);
  std::vector<std::size_t> seen;
  for (std::size_t i = 0; i < files.size(); ++i)
    if (!files[i].empty()) seen.push_back(i);
  if (seen.empty()) return "";
  std::string html =
      "<p class='soft'>Ellipses are the search regions of landmarks (3 sigma): green, with the matched 11 x "
      "11 patch, if the match was used; yellow otherwise.</p><div class='strip'>";
  const rig::RigSensor head = recording::head_camera(pictures.setup());
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = seen[k * (seen.size() - 1) / (count - 1)];
    html += picture_html(run.frames[i], pictures.read(head, files[i]).image, run.frames[seen[0]]);
  }
  return html + "</div>";
}

std::string run_sections(const RunData& run, const std::string& prefix, const std::string& title) {
  return RunSections(run).html(prefix, title);
}

std::string runs_page(const std::vector<RunData>& all, const std::vector<std::string>& metrics) {
  const PageRuns runs(all);
  std::vector<std::string> scenarios;
  std::vector<Section> sections;
  for (const auto& [scenario, figures] : comparison_figures(all)) {
    std::string shown;
    for (const Figure& figure : figures) shown += figure_html(figure);
    scenarios.push_back(scenario);
    sections.push_back({fmt::format("scenario-{}", sections.size()), scenario + ": all runs",
                        results_html(runs, scenario, metrics) + changes_html(runs, scenario) +
                            "<h3>Runs</h3>" + table(runs, scenario) +
                            figures_html(shown + scatter_html(runs, scenario))});
  }
  const auto known = [](const std::string& text) { return text.empty() ? "?" : escaped(text); };
  const result::About& about = all[0].about;
  const bool several = all.size() > 1;
  return html_page(
      several ? fmt::format("{}: {}", fmt::join(scenarios, ", "), files::counted(all.size(), "run"))
              : all[0].label(),
      fmt::format("{} {}, revision {}", known(about.program), known(about.version), known(about.revision)),
      (several ? sections_html(sections, true) : "") + runs_in_detail(runs));
}

}  // namespace sim::pages
