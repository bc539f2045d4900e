#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "sim/files/text.h"
#include "sim/pages/html.h"
#include "sim/pages/pages.h"

namespace sim::pages {
namespace {

constexpr std::size_t kInFull = 12;  // runs

/// The runs that a page shows in full: of many, the worst one of each scenario and estimator.
std::vector<bool> runs_in_full(const std::vector<RunData>& runs) {
  std::vector<bool> in_full(runs.size(), runs.size() <= kInFull);
  std::map<std::pair<std::string, std::string>, std::size_t> worst;
  const auto ate = [&](std::size_t i) { return runs[i].value("ate_se3_rmse_m").value_or(INFINITY); };
  for (std::size_t i = 0; i < runs.size(); ++i) {
    std::size_t& so_far = worst.emplace(std::pair{runs[i].scenario, runs[i].estimator}, i).first->second;
    if (ate(i) > ate(so_far)) so_far = i;
  }
  for (const auto& [group, i] : worst) in_full[i] = true;
  return in_full;
}

/// The runs of a scenario with their shown metrics, and links to those in full.
std::string table(const std::vector<RunData>& runs, const std::vector<bool>& in_full,
                  const std::string& scenario) {
  std::vector<std::string> columns;
  std::map<std::size_t, std::map<std::string, std::optional<double>>> values;  // by run and column
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (runs[i].scenario != scenario) continue;
    for (const char* const metric : kShownMetrics) {
      const std::string column = column_of(metric, runs[i].alignment);
      const auto value = values[i][column] = runs[i].value(metric);
      if (value && std::ranges::find(columns, column) == columns.end()) columns.push_back(column);
    }
  }
  std::vector<TableCell> titles{{"run"}, {"verdict"}, {"ending"}};
  for (std::string column : columns) {
    std::replace(column.begin(), column.end(), '_', ' ');
    titles.push_back(text_cell(column, "number"));
  }
  std::vector<TableRow> rows;
  for (auto& [i, of_run] : values) {
    const RunData& run = runs[i];
    const auto same = [&](const RunData& other) { return other.label() == run.label(); };
    const bool alike = std::ranges::count_if(runs, same) > 1;
    std::string link = escaped(run.label() + (alike ? ", " + run.folder.string() : ""));
    if (in_full[i]) link = fmt::format("<a href='#run-{0}' data-run='run-{0}'>{1}</a>", i, link);
    TableRow row{{{link}, text_cell(verdict_of(run)), text_cell(name_of(run.ending))}};
    for (const std::string& column : columns) row.cells.push_back(number_cell(of_run[column]));
    rows.push_back(row);
  }
  return table_html("runs", titles, rows);
}

/// One run is visible at a time; web/pages.js changes which.
std::string runs_in_detail(const std::vector<RunData>& runs, const std::vector<bool>& in_full) {
  std::string options, html;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!in_full[i]) continue;
    const std::string id = fmt::format("run-{}", i);
    options += fmt::format("<option value='{}'>{}</option>", id, escaped(runs[i].label()));
    html += fmt::format("<div class='run' id='{}'{}>", id, html.empty() ? "" : " hidden") +
            run_sections(runs[i], id + "-", runs.size() > 1 ? runs[i].label() : "Verdict") + "</div>\n";
  }
  if (runs.size() == 1) return html;
  std::string head = "<p class='no-print'>Shown below: <select id='run' aria-label='run shown below'>" +
                     options + "</select></p>";
  if (const auto left = std::ranges::count(in_full, false); left > 0)
    head += fmt::format(
        "<p class='soft'>The worst run of each scenario is shown in full; {} more: tools/gaitslam report "
        "FOLDER.</p>",
        left);
  return head + html;
}

}  // namespace

std::string runs_page(const std::vector<RunData>& runs) {
  const std::vector<bool> in_full = runs_in_full(runs);
  std::vector<std::string> scenarios;
  std::vector<Section> sections;
  for (const auto& [scenario, figures] : comparison_figures(runs)) {
    std::string shown;
    for (const Figure& figure : figures) shown += figure_html(figure);
    scenarios.push_back(scenario);
    sections.push_back({fmt::format("scenario-{}", sections.size()), scenario + ": all runs",
                        table(runs, in_full, scenario) + figures_html(shown)});
  }
  const auto known = [](const std::string& text) { return text.empty() ? "?" : escaped(text); };
  const result::About& about = runs[0].about;
  return html_page(
      runs.size() == 1
          ? runs[0].label()
          : fmt::format("{}: {}", fmt::join(scenarios, ", "), files::counted(runs.size(), "run")),
      fmt::format("{} {}, revision {}", known(about.program), known(about.version), known(about.revision)),
      (runs.size() == 1 ? "" : sections_html(sections, true)) + runs_in_detail(runs, in_full),
      {page_script(), map_script()});
}

}  // namespace sim::pages
