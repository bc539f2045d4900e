#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "sim/files/text.h"
#include "sim/pages/html.h"
#include "sim/pages/pages.h"
#include "sim/pages/run_figures.h"
#include "sim/pages/run_sections.h"

namespace sim::pages {
namespace {

constexpr std::size_t kInFull = 12;  // runs

/// The runs that a page shows in full: of many, the first and the worst one of each scenario and estimator.
std::vector<bool> runs_in_full(const std::vector<RunData>& runs) {
  std::vector<bool> in_full(runs.size(), runs.size() <= kInFull);
  std::map<std::pair<std::string, std::string>, std::size_t> worst;
  const auto ate = [&](std::size_t i) { return runs[i].metric("ate_se3_rmse_m").value_or(INFINITY); };
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const auto [found, is_first] = worst.emplace(std::pair{runs[i].scenario, runs[i].estimator}, i);
    if (is_first) in_full[i] = true;
    if (ate(i) > ate(found->second)) found->second = i;
  }
  for (const auto& [group, i] : worst) in_full[i] = true;
  return in_full;
}

/// Compares several runs: a table and figures for each scenario, with links to the runs shown in full.
class Comparison {
 public:
  Comparison(const std::vector<RunData>& runs, const std::vector<bool>& in_full)
      : runs_(runs), in_full_(in_full), figures_(comparison_figures(runs)) {
    for (const RunData& run : runs)
      if (std::find(scenarios_.begin(), scenarios_.end(), run.scenario) == scenarios_.end())
        scenarios_.push_back(run.scenario);
  }

  std::string title() const {
    return fmt::format("{}: {}", fmt::join(scenarios_, ", "), files::counted(runs_.size(), "run"));
  }

  std::string html() const {
    if (scenarios_.size() == 1) return section_html("runs", "All runs", inside(scenarios_[0]));
    std::vector<std::pair<std::string, std::string>> sections;  // id and title
    std::string html;
    for (const std::string& scenario : scenarios_) {
      sections.emplace_back(fmt::format("scenario-{}", sections.size()), scenario + ": all runs");
      html += section_html(sections.back().first, sections.back().second, inside(scenario));
    }
    return navigation_html(sections) + html;
  }

 private:
  std::string link(std::size_t i, const std::string& words) const {
    return in_full_[i] ? fmt::format("<a href='#run-{0}' data-run='run-{0}'>{1}</a>", i, escaped(words))
                       : escaped(words);
  }

  std::string inside(const std::string& scenario) const {
    std::string html = table(scenario), shown;
    for (const Figure& figure : figures_) {
      std::string links;
      bool here = false;
      for (std::size_t i = 0; i < runs_.size(); ++i) {
        if (std::find(figure.runs.begin(), figure.runs.end(), runs_[i].folder.string()) == figure.runs.end())
          continue;
        here = here || runs_[i].scenario == scenario;
        links += link(i, runs_[i].label().substr(runs_[i].scenario.size() + 2)) + " ";
      }
      if (here) shown += figure_html(figure, "<p class='soft no-print'>runs: " + links + "</p>");
    }
    return html + figures_html(shown);
  }

  std::string table(const std::string& scenario) const {
    std::vector<std::string> names;
    for (const RunData& run : runs_)
      for (const RunMetric& metric : run.metrics)
        if (const std::string column = column_of(metric.name, run.alignment);
            run.scenario == scenario && metric.value &&
            std::find(names.begin(), names.end(), column) == names.end())
          names.push_back(column);
    std::vector<TableCell> titles{{"run"}, {"verdict"}, {"ending"}};
    for (std::string name : names) {
      std::replace(name.begin(), name.end(), '_', ' ');
      titles.push_back(text_cell(name, "number"));
    }
    std::vector<TableRow> rows;
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      const RunData& run = runs_[i];
      if (run.scenario != scenario) continue;
      const bool alike = std::count_if(runs_.begin(), runs_.end(), [&](const RunData& other) {
                           return other.label() == run.label();
                         }) > 1;
      TableRow row{{{link(i, run.label() + (alike ? ", " + run.folder.string() : ""))},
                    text_cell(verdict_of(run).text),
                    text_cell(run.ending)}};
      std::map<std::string, std::optional<double>> values;
      for (const RunMetric& metric : run.metrics)
        values[column_of(metric.name, run.alignment)] = metric.value;
      for (const std::string& name : names) row.cells.push_back(number_cell(values[name]));
      rows.push_back(row);
    }
    return table_html("runs", titles, rows, true);
  }

  const std::vector<RunData>& runs_;
  const std::vector<bool>& in_full_;
  std::vector<Figure> figures_;
  std::vector<std::string> scenarios_;
};

std::string subtitle(const result::About& about) {
  const auto known = [](const std::string& text) { return text.empty() ? "?" : escaped(text); };
  return fmt::format("{} {}, revision {}", known(about.program), known(about.version), known(about.revision));
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
  const auto left = std::count(in_full.begin(), in_full.end(), false);
  return fmt::format(
             "<p class='no-print'>Shown below: <select id='run' aria-label='run shown below'>{}</select></p>",
             options) +
         (left == 0 ? ""
                    : fmt::format("<p class='soft'>The first and the worst run of each scenario are shown in "
                                  "full; {} more: tools/gaitslam report "
                                  "FOLDER.</p>",
                                  left)) +
         html;
}

}  // namespace

std::string runs_page(const std::vector<RunData>& runs) {
  const std::vector<bool> in_full = runs_in_full(runs);
  const Comparison comparison(runs, in_full);
  return html_page(runs.size() == 1 ? runs[0].label() : comparison.title(), subtitle(runs[0].about),
                   (runs.size() == 1 ? "" : comparison.html()) + runs_in_detail(runs, in_full),
                   {page_script(), map_script()});
}

}  // namespace sim::pages
