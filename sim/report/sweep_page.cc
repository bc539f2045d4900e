#include "sim/report/sweep_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <sstream>
#include <vector>

#include "sim/files/json.h"
#include "sim/files/number.h"
#include "sim/files/printed_text.h"
#include "sim/files/text.h"
#include "sim/report/figure.h"
#include "sim/report/html.h"
#include "sim/scenario/keys.h"
#include "sim/score/evaluate.h"
#include "sim/score/statistics.h"

namespace sim::report {
namespace {

namespace fs = std::filesystem;
using files::Json;

/// The metrics that are shown where the sweep has them; the first one names the worst seeds.
constexpr std::array kMetrics{"ate_se3_rmse_m", "rmse_m", "end_position_error_m", "nees_position_mean",
                              "loop_landmarks"};

constexpr std::size_t kMostMappedKeys = 6;  // 15 heat maps of each metric
constexpr std::size_t kMostLineKeys = 20;   // a figure of each metric
constexpr std::size_t kMostDots = 2000;     // of a figure

/// One line of scores.jsonl.
struct SweepTrial {
  std::string scenario;
  std::vector<std::string> settings;  ///< the value of each key, as it is typed
  std::uint64_t seed = 0;
  std::string ending, cause;
  std::map<std::string, double> values;
};

/// The trials of one scenario.
struct SweepOf {
  std::string scenario;
  std::vector<std::string> keys;
  std::vector<std::vector<std::string>>
      at;  ///< of each key, its values in ascending order or that of the file
  std::vector<std::map<std::string, std::size_t>> place;  ///< of each key, where its values are in `at`
  std::vector<SweepTrial> trials;
};

std::string typed(const Json& value) {
  return value.value().is_string() ? value.text() : files::json_text(value.value());
}

SweepTrial trial_of(const Json& line, std::vector<std::string>& keys) {
  SweepTrial trial{line.at("scenario").text(), {}, line.at("seed").whole(), line.at("ending").text(), "", {}};
  if (const auto cause = line.find("cause")) trial.cause = cause->text();
  std::vector<std::string> names;
  for (const auto& [key, value] : line.at("settings").entries()) {
    names.push_back(key);
    trial.settings.push_back(typed(value));
  }
  if (keys.empty()) keys = names;
  if (keys != names) line.at("settings").fail("has other keys than the lines before");
  for (const auto& [name, value] : line.at("values").entries())
    if (value.value().is_number()) trial.values[name] = value.number();
  return trial;
}

/// Values in ascending order where all are numbers, else as they came.
std::vector<std::string> ordered(std::vector<std::string> values) {
  const auto number = [](const std::string& v) { return files::parse_number<double>(v); };
  if (std::all_of(values.begin(), values.end(), [&](const auto& v) { return number(v).has_value(); }))
    std::stable_sort(values.begin(), values.end(),
                     [&](const auto& a, const auto& b) { return *number(a) < *number(b); });
  return values;
}

void find_values(SweepOf& sweep) {
  for (std::size_t k = 0; k < sweep.keys.size(); ++k) {
    std::vector<std::string> values;
    std::map<std::string, std::size_t> place;
    for (const SweepTrial& trial : sweep.trials)
      if (place.emplace(trial.settings[k], 0).second) values.push_back(trial.settings[k]);
    sweep.at.push_back(ordered(std::move(values)));
    for (std::size_t i = 0; i < sweep.at[k].size(); ++i) place[sweep.at[k][i]] = i;
    sweep.place.push_back(std::move(place));
  }
}

/// By scenario, in the order of the file.
std::vector<SweepOf> read_sweep(const fs::path& folder) {
  const fs::path file = folder / "scores.jsonl";
  std::istringstream text(files::read_text(file));
  std::vector<SweepOf> all;
  std::vector<std::string> keys;
  for (std::string line; std::getline(text, line);) {
    SweepTrial trial = trial_of(Json(file, line), keys);
    auto found =
        std::find_if(all.begin(), all.end(), [&](const SweepOf& s) { return s.scenario == trial.scenario; });
    if (found == all.end()) found = all.insert(all.end(), {trial.scenario, {}, {}, {}, {}});
    found->trials.push_back(std::move(trial));
  }
  if (all.empty()) throw files::FileError(file, "has no trial");
  for (SweepOf& sweep : all) {
    sweep.keys = keys;
    find_values(sweep);
  }
  return all;
}

std::string with_unit(const std::string& key) {
  const std::string unit(scenario::unit_of(key));
  return unit.empty() ? key : fmt::format("{} [{}]", key, unit);
}

std::string metric_label(const std::string& name) {
  const score::MetricDefinition* defined = score::find_metric(name);
  return defined && defined->unit != "1" ? fmt::format("{} [{}]", name, defined->unit) : name;
}

bool is_counted(const std::string& name) { return name == "loop_landmarks"; }

/// Where the values of a key lie on an axis: at themselves where they are numbers, else at 1, 2, 3, ...
struct KeyAxis {
  std::vector<double> at;
  bool numbers = true, logarithmic = false;
};

KeyAxis axis_of_key(const std::vector<std::string>& values) {
  KeyAxis axis;
  for (const std::string& value : values) {
    const auto number = files::parse_number<double>(value);
    axis.numbers = axis.numbers && number.has_value();
    axis.at.push_back(number.value_or(0));
  }
  if (!axis.numbers)
    for (std::size_t i = 0; i < values.size(); ++i) axis.at[i] = static_cast<double>(i + 1);
  axis.logarithmic = axis.numbers && axis.at.front() > 0 && axis.at.back() > 8 * axis.at.front();
  return axis;
}

/// Whether the key has few values, as in a grid, and not one for each sample.
bool is_grid(const SweepOf& sweep, std::size_t k) { return sweep.at[k].size() <= 20; }

/// Whether the nth of so many trials has a dot. Multiples of the golden ratio are spread evenly modulo 1, and
/// so are those of every second, third, ... number: no value of a grid is left out.
bool is_drawn(std::size_t n, std::size_t trials) {
  const double multiple = std::numbers::phi * static_cast<double>(n);
  return trials <= kMostDots ||
         multiple - std::floor(multiple) < static_cast<double>(kMostDots) / static_cast<double>(trials);
}

Figure lines_figure(const SweepOf& sweep, std::size_t k, const std::string& metric) {
  const KeyAxis axis = axis_of_key(sweep.at[k]);
  Figure f{fmt::format("{}_{}_{}", sweep.scenario, metric, sweep.keys[k]),
           fmt::format("{} over {}", metric, sweep.keys[k]),
           axis.numbers ? with_unit(sweep.keys[k]) : sweep.keys[k] + ", by the order of its values below",
           metric_label(metric)};
  f.logarithmic_x = axis.logarithmic, f.whole_x = !axis.numbers, f.whole_y = is_counted(metric);
  std::vector<std::vector<double>> values(axis.at.size());
  Line dots{"a trial", Role::truth, {}, {}, true}, median{"median", Role::estimate};
  for (std::size_t n = 0; n < sweep.trials.size(); ++n) {
    const SweepTrial& trial = sweep.trials[n];
    const auto value = trial.values.find(metric);
    if (value == trial.values.end()) continue;
    const std::size_t i = sweep.place[k].at(trial.settings[k]);
    values[i].push_back(value->second);
    if (is_drawn(n, sweep.trials.size())) dots.x.push_back(axis.at[i]), dots.y.push_back(value->second);
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i].empty()) continue;
    median.x.push_back(axis.at[i]), median.y.push_back(score::median(values[i]));
  }
  if (sweep.trials.size() > kMostDots) {
    dots.name = fmt::format("{} of {} trials", dots.x.size(), sweep.trials.size());
    median.name = "median of all";
  }
  f.lines = {dots};
  if (is_grid(sweep, k)) f.lines.push_back(median);
  return f;
}

/// The place in the page of the trials of one setting.
std::string anchor(const SweepOf& sweep, const std::vector<std::string>& settings) {
  std::string name = "setting-" + sweep.scenario;
  for (std::size_t k = 0; k < settings.size(); ++k)
    name += fmt::format("-{}", sweep.place[k].at(settings[k]) + 1);
  return name;
}

Figure heat_figure(const SweepOf& sweep, std::size_t a, std::size_t b, const std::string& metric) {
  Figure f{fmt::format("{}_{}_{}_{}", sweep.scenario, metric, sweep.keys[a], sweep.keys[b]),
           fmt::format("{}: median over {}; dark is worse", metric_label(metric),
                       sweep.keys.size() > 2 ? "seeds and the other keys" : "seeds"),
           with_unit(sweep.keys[a]), with_unit(sweep.keys[b])};
  f.columns = sweep.at[a], f.rows = sweep.at[b];
  struct Cell {
    std::string href;  // of its first trial
    std::vector<double> values;
  };
  std::map<std::pair<std::size_t, std::size_t>, Cell> cells;
  for (const SweepTrial& trial : sweep.trials) {
    Cell& cell = cells[{sweep.place[a].at(trial.settings[a]), sweep.place[b].at(trial.settings[b])}];
    if (cell.href.empty()) cell.href = "#" + anchor(sweep, trial.settings);
    if (const auto v = trial.values.find(metric); v != trial.values.end()) cell.values.push_back(v->second);
  }
  for (const auto& [at, cell] : cells) {
    const double value = cell.values.empty() ? NAN : score::median(cell.values);
    f.cells.push_back(
        {at.first, at.second, value, score::loss(value, score::direction_of(metric)), cell.href});
  }
  return f;
}

bool has(const SweepOf& sweep, const std::string& metric) {
  return std::any_of(sweep.trials.begin(), sweep.trials.end(),
                     [&](const SweepTrial& trial) { return trial.values.contains(metric); });
}

std::vector<std::string> metrics_of(const SweepOf& sweep) {
  std::vector<std::string> shown;
  for (const char* metric : kMetrics)
    if (has(sweep, metric)) shown.emplace_back(metric);
  return shown;
}

/// The keys that have several values.
std::vector<std::size_t> varied_keys(const SweepOf& sweep) {
  std::vector<std::size_t> keys;
  for (std::size_t k = 0; k < sweep.keys.size(); ++k)
    if (sweep.at[k].size() > 1) keys.push_back(k);
  return keys;
}

/// Those of a grid.
std::vector<std::size_t> grid_keys(const SweepOf& sweep) {
  std::vector<std::size_t> keys = varied_keys(sweep);
  std::erase_if(keys, [&](std::size_t k) { return !is_grid(sweep, k); });
  return keys;
}

std::vector<std::size_t> first(std::vector<std::size_t> keys, std::size_t most) {
  keys.resize(std::min(keys.size(), most));
  return keys;
}

/// Which of the keys have figures, where not all have. what: the figures.
std::string about_left_out(const SweepOf& sweep, const std::string& what,
                           const std::vector<std::size_t>& keys, std::size_t most) {
  if (keys.size() <= most) return "";
  std::string names;
  for (const std::size_t k : first(keys, most)) names += (names.empty() ? "" : ", ") + escaped(sweep.keys[k]);
  return fmt::format("<p>{} are drawn of the first {} of {} keys with several values: {}.</p>\n", what, most,
                     keys.size(), names);
}

std::string about_left_out(const SweepOf& sweep) {
  return about_left_out(sweep, "Heat maps", grid_keys(sweep), kMostMappedKeys) +
         about_left_out(sweep, "Lines and dots", varied_keys(sweep), kMostLineKeys);
}

std::vector<Figure> figures_of(const SweepOf& sweep) {
  std::vector<Figure> all;
  const std::vector<std::size_t> mapped = first(grid_keys(sweep), kMostMappedKeys),
                                 lined = first(varied_keys(sweep), kMostLineKeys);
  for (const std::string& metric : metrics_of(sweep)) {
    const std::size_t before = all.size();
    for (std::size_t a = 0; a < mapped.size(); ++a)
      for (std::size_t b = a + 1; b < mapped.size(); ++b)
        all.push_back(heat_figure(sweep, mapped[a], mapped[b], metric));
    if (sweep.keys.size() == 2 && all.size() > before) continue;  // it has both keys already
    for (const std::size_t k : lined) all.push_back(lines_figure(sweep, k, metric));
  }
  return all;
}

/// The trials of each setting, in the order of the file.
std::vector<std::vector<const SweepTrial*>> by_setting(const SweepOf& sweep) {
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

/// The changes that make the trial a run of its scenario's file.
std::string command_of(const SweepOf& sweep, const SweepTrial& trial, const fs::path& folder) {
  std::string command =
      "tools/gaitslam run " + files::shell_word((folder / "scenarios" / (trial.scenario + ".yaml")).string());
  for (std::size_t k = 0; k < sweep.keys.size(); ++k)
    command += " " + files::shell_word(fmt::format("{}={}", sweep.keys[k], trial.settings[k]));
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

std::string cell(const std::string& text, bool number) {
  return fmt::format("<td{}>{}</td>", number ? " class='number'" : "", escaped(text));
}

std::string titles_row(const SweepOf& sweep, const std::vector<std::string>& metrics) {
  std::string html = "<tr>";
  for (const std::string& key : sweep.keys) html += fmt::format("<th>{}</th>", escaped(with_unit(key)));
  html += "<th class='number'>completed</th><th>worst seed</th>";
  for (const std::string& metric : metrics)
    html += fmt::format("<th class='number'>{}</th>", escaped(metric_label(metric)));
  return html + "</tr>";
}

/// Medians of the trials of one setting, their worst seed, and the command that runs that one.
std::string setting_row(const SweepOf& sweep, const std::vector<const SweepTrial*>& trials,
                        const std::vector<std::string>& metrics, const fs::path& folder) {
  std::string html = fmt::format("<tr id='{}'>", escaped(anchor(sweep, trials.front()->settings)));
  for (const std::string& value : trials.front()->settings) html += cell(value, false);
  const auto completed = std::count_if(trials.begin(), trials.end(),
                                       [](const SweepTrial* t) { return t->ending == "completed"; });
  html += cell(fmt::format("{} of {}", completed, trials.size()), true);
  const SweepTrial& worst = worst_of(trials, metrics.empty() ? "" : metrics.front());
  const bool failed = worst.ending != "completed" || metrics.empty();
  html += fmt::format("<td><details><summary>seed {}: {}</summary>{}<pre>{}</pre></details></td>", worst.seed,
                      escaped(failed ? worst.ending : value_text(worst, metrics.front())),
                      escaped(worst.cause), escaped(command_of(sweep, worst, folder)));
  for (const std::string& metric : metrics) html += cell(median_text(trials, metric), true);
  return html + "</tr>\n";
}

std::string settings_table(const SweepOf& sweep, const fs::path& folder) {
  const std::vector<std::string> metrics = metrics_of(sweep);
  std::string html =
      "<div class='scroll' tabindex='0' role='region' aria-label='settings'><table "
      "class='named-rows'><thead>" +
      titles_row(sweep, metrics) + "</thead><tbody>\n";
  for (const auto& trials : by_setting(sweep)) html += setting_row(sweep, trials, metrics, folder);
  return html + "</tbody></table></div>\n";
}

/// The settings whose worst seed is worst, each a link to its row.
std::string worst_list(const SweepOf& sweep) {
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

std::string order_of_values(const SweepOf& sweep) {
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

std::string section_of(const SweepOf& sweep, const fs::path& folder) {
  constexpr double kWidth = 640, kHeight = 320;
  std::string html = fmt::format("<h2 id='scenario-{0}'>{0}</h2>\n", escaped(sweep.scenario));
  html += worst_list(sweep) + about_left_out(sweep) + "<div class='figures'>\n";
  for (const Figure& figure : figures_of(sweep))
    html += fmt::format("<figure id='{}'><figcaption>{}</figcaption>{}</figure>\n", escaped(figure.name),
                        escaped(figure.title), to_svg(figure, kWidth, kHeight));
  html += "</div>\n" + order_of_values(sweep);
  html += "<h3>Settings, and the worst seed of each with the command that runs it</h3>\n";
  return html + settings_table(sweep, folder);
}

}  // namespace

bool is_sweep(const fs::path& folder) {
  return fs::exists(folder / "scores.jsonl") && fs::exists(folder / "trials.jsonl");
}

std::string sweep_page(const fs::path& folder) {
  const std::vector<SweepOf> all = read_sweep(folder);
  std::size_t trials = 0;
  for (const SweepOf& sweep : all) trials += sweep.trials.size();
  const std::string name = folder.filename().string();
  std::string html = html_head("sweep " + name, "");
  html += fmt::format(
      "<h1>Sweep {}</h1>\n<p class='soft'>{} of {}. A cell of a heat map opens the row of its "
      "setting in the table below.</p>\n",
      escaped(name), files::counted(trials, "trial"), files::counted(all.size(), "scenario"));
  if (all.size() > 1) {
    html += "<nav aria-label='scenarios'>";
    for (const SweepOf& sweep : all)
      html += fmt::format("<a href='#scenario-{0}'>{0}</a>", escaped(sweep.scenario));
    html += "</nav>\n";
  }
  for (const SweepOf& sweep : all) html += section_of(sweep, folder);
  return html + kHtmlEnd;
}

}  // namespace sim::report
