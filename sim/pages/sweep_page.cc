#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "sim/files/text.h"
#include "sim/pages/html.h"
#include "sim/pages/pages.h"
#include "sim/pages/sweep.h"
#include "sim/scenario/scenario.h"
#include "sim/score/metrics.h"
#include "sim/score/statistics.h"

namespace sim::pages {
namespace {

namespace fs = std::filesystem;

/// The trials of each setting, in the order of the file.
std::vector<std::vector<const SweepTrial*>> by_setting(const ScenarioSweep& sweep) {
  std::vector<std::vector<const SweepTrial*>> groups;
  std::map<std::vector<std::string>, std::size_t> group_of;
  for (const SweepTrial& trial : sweep.trials) {
    const auto [group, is_new] = group_of.emplace(trial.settings, groups.size());
    if (is_new) groups.emplace_back();
    groups[group->second].push_back(&trial);
  }
  return groups;
}

/// The trial that did not complete, else the one with the worst value of the metric.
const SweepTrial& worst_of(const std::vector<const SweepTrial*>& trials, const std::string& metric) {
  const auto badness = [&](const SweepTrial* trial) {
    const auto value = trial->values.find(metric);
    return value == trial->values.end() ? INFINITY : score::loss(value->second, score::direction_of(metric));
  };
  return **std::max_element(trials.begin(), trials.end(), [&](const SweepTrial* a, const SweepTrial* b) {
    const bool a_failed = a->ending != "completed", b_failed = b->ending != "completed";
    return a_failed != b_failed ? b_failed : badness(a) < badness(b);
  });
}

/// The command of a trial, unless it would start a program that the sweep names.
std::string command_of(const ScenarioSweep& sweep, const SweepTrial& trial, const fs::path& folder) {
  std::string command =
      "tools/gaitslam run " + files::shell_word((folder / "scenarios" / (trial.scenario + ".yaml")).string());
  for (std::size_t k = 0; k < sweep.keys.size(); ++k)
    command += " " + files::shell_word(fmt::format("{}={}", sweep.keys[k], trial.settings[k]));
  scenario::Changes changes;
  for (std::size_t k = 0; k < sweep.keys.size(); ++k)
    changes.overrides.push_back(fmt::format("{}={}", sweep.keys[k], trial.settings[k]));
  try {
    const auto read = scenario::read_scenario(folder / "scenarios" / (trial.scenario + ".yaml"), changes);
    if (read.scenario.estimator.source != estimators::Source::built_in)
      return "its scenario names an external program as estimator";
  } catch (const std::exception&) {  // nor does the command run
  }
  return fmt::format("{} seed={}", command, trial.seed);
}

std::string value_text(const SweepTrial& trial, const std::string& metric) {
  const auto found = trial.values.find(metric);
  return found == trial.values.end() ? "-" : fmt::format("{:.4g}", found->second);
}

std::string median_text(const std::vector<const SweepTrial*>& trials, const std::string& metric) {
  std::vector<double> values;
  for (const SweepTrial* trial : trials)
    if (const auto v = trial->values.find(metric); v != trial->values.end()) values.push_back(v->second);
  return values.empty() ? "-" : fmt::format("{:.4g}", score::median(values));
}

/// Medians of the trials of one setting, their worst seed, and the command that runs that one.
TableRow setting_row(const ScenarioSweep& sweep, const std::vector<const SweepTrial*>& trials,
                     const std::vector<std::string>& metrics, const fs::path& folder) {
  TableRow row{{}, anchor(sweep, trials.front()->settings)};
  for (const std::string& value : trials.front()->settings) row.cells.push_back(text_cell(value));
  const auto completed = std::count_if(trials.begin(), trials.end(),
                                       [](const SweepTrial* t) { return t->ending == "completed"; });
  row.cells.push_back({fmt::format("{} of {}", completed, trials.size()), "number"});
  const SweepTrial& worst = worst_of(trials, metrics.empty() ? "" : metrics.front());
  const bool failed = worst.ending != "completed" || metrics.empty();
  row.cells.push_back(
      {fmt::format("<details><summary>seed {}: {}</summary>{}<pre>{}</pre></details>", worst.seed,
                   escaped(failed ? worst.ending : value_text(worst, metrics.front())), escaped(worst.cause),
                   escaped(command_of(sweep, worst, folder)))});
  for (const std::string& metric : metrics) row.cells.push_back({median_text(trials, metric), "number"});
  return row;
}

std::string settings_table(const ScenarioSweep& sweep, const fs::path& folder) {
  const std::vector<std::string> metrics = metrics_of(sweep);
  std::vector<TableCell> titles;
  for (const std::string& key : sweep.keys) titles.push_back(text_cell(with_unit(key)));
  titles.insert(titles.end(), {{"completed", "number"}, {"worst seed"}});
  for (const std::string& metric : metrics) titles.push_back(text_cell(metric_label(metric), "number"));
  std::vector<TableRow> rows;
  for (const auto& trials : by_setting(sweep)) rows.push_back(setting_row(sweep, trials, metrics, folder));
  return table_html("settings", titles, rows);
}

/// The worst trials, each with a link to the row of its setting.
std::string worst_list(const ScenarioSweep& sweep) {
  constexpr std::size_t kNamed = 5;
  const std::vector<std::string> metrics = metrics_of(sweep);
  if (metrics.empty()) return "";
  const std::string& metric = metrics.front();
  std::vector<const SweepTrial*> all;
  for (const SweepTrial& trial : sweep.trials) all.push_back(&trial);
  std::string html = fmt::format("<p>The worst trials by {}: ", escaped(metric));
  for (std::size_t n = 0; n < std::min(kNamed, sweep.trials.size()); ++n) {
    const SweepTrial* const worst = &worst_of(all, metric);
    all.erase(std::find(all.begin(), all.end(), worst));
    std::string name;
    for (std::size_t k = 0; k < sweep.keys.size(); ++k)
      name += fmt::format("{}={}, ", sweep.keys[k].substr(sweep.keys[k].rfind('.') + 1), worst->settings[k]);
    html += fmt::format("{}<a href='#{}'>{}seed {}</a> ({})", n == 0 ? "" : " · ",
                        escaped(anchor(sweep, worst->settings)), escaped(name), worst->seed,
                        escaped(worst->ending == "completed" ? value_text(*worst, metric) : worst->ending));
  }
  return html + ".</p>\n";
}

std::string order_of_values(const ScenarioSweep& sweep) {
  std::string html;
  for (std::size_t k = 0; k < sweep.keys.size(); ++k) {
    if (axis_of_key(sweep.at[k]).numbers) continue;
    html += fmt::format("<p>Values of {}:", escaped(sweep.keys[k]));
    for (std::size_t i = 0; i < sweep.at[k].size(); ++i)
      html += fmt::format(" {}: <code>{}</code>", i + 1, escaped(sweep.at[k][i]));
    html += "</p>\n";
  }
  return html;
}

std::string inside_of(const ScenarioSweep& sweep, const fs::path& folder) {
  std::string figures;
  for (const Figure& figure : sweep_figures(sweep)) figures += figure_html(figure, "", 320);
  return worst_list(sweep) + about_left_out(sweep) + figures_html(figures) + order_of_values(sweep) +
         "<h3>Settings, and the worst seed of each with the command that runs it</h3>\n" +
         settings_table(sweep, folder);
}

}  // namespace

bool is_sweep(const fs::path& folder) {
  return fs::exists(folder / "scores.jsonl") && fs::exists(folder / "trials.jsonl");
}

std::string sweep_page(const fs::path& folder) {
  const std::vector<ScenarioSweep> all = read_sweep(folder);
  std::size_t trials = 0;
  for (const ScenarioSweep& sweep : all) trials += sweep.trials.size();
  std::vector<std::pair<std::string, std::string>> sections;
  std::string html;
  for (const ScenarioSweep& sweep : all) {
    sections.emplace_back("scenario-" + sweep.scenario, sweep.scenario);
    html += section_html(sections.back().first, sweep.scenario, inside_of(sweep, folder));
  }
  return html_page(
      "Sweep " + folder.filename().string(),
      fmt::format("{} of {}. A cell of a heat map opens the row of its setting in the table below.",
                  files::counted(trials, "trial"), files::counted(all.size(), "scenario")),
      (all.size() > 1 ? navigation_html(sections) : "") + html);
}

}  // namespace sim::pages
