// The pages about searches: the trials of a sweep, read from scores.jsonl, and a tuning.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <sstream>

#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/pages/pages.h"
#include "sim/scenario/keys.h"
#include "sim/scenario/scenario.h"
#include "sim/score/metrics.h"
#include "sim/score/statistics.h"

namespace sim::pages {
namespace {

using files::Json;

constexpr std::size_t kMostKeys = 6;     // keys with figures
constexpr std::size_t kMostDots = 2000;  // if there are more trials, only the medians are drawn
constexpr std::size_t kMostOfGrid = 20;  // values of a grid key; sampled keys have one for each sample

/// One line of scores.jsonl.
struct Trial {
  std::string scenario;
  std::vector<std::string> typed, settings;  ///< the value of each key, as typed and as shown
  std::uint64_t seed = 0;
  std::string ending, cause;
  std::map<std::string, double> values;

  /// Returns the value, or NaN if there is none.
  double value(const std::string& metric) const {
    const auto found = values.find(metric);
    return found == values.end() ? NAN : found->second;
  }
};
using Trials = std::vector<const Trial*>;

/// A swept key. values: numbers in ascending order, others in the given order. numbers: set if all are
/// numbers.
struct Key {
  std::string name;
  std::vector<std::string> values;
  std::vector<double> numbers;
  std::map<std::string, std::size_t> place;  ///< index of a value in `values`

  bool is_grid() const { return values.size() <= kMostOfGrid; }
  std::string label() const { return with_unit(name, scenario::unit_of(name).value_or("")); }
};

/// The trials of one scenario.
struct Sweep {
  std::string scenario;
  std::vector<Trial> trials;
  std::vector<Key> keys;
};

Trial trial_of(const Json& line, std::vector<std::string>& keys) {
  Trial trial{line.at("scenario").text(), {}, {}, line.at("seed").whole(), line.at("ending").text(), "", {}};
  if (const auto cause = line.find("cause")) trial.cause = cause->text();
  std::vector<std::string> names;
  const auto labels = line.find("labels");
  for (const auto& [key, value] : line.at("settings").entries()) {
    names.push_back(key);
    trial.typed.push_back(value.value().is_string() ? value.text() : files::json_text(value.value()));
    const auto label = labels ? labels->find(key) : std::nullopt;
    trial.settings.push_back(label ? label->text() : trial.typed.back());
  }
  if (keys.empty()) keys = names;
  if (keys != names) line.at("settings").fail("has different keys than the previous lines");
  for (const auto& [name, value] : line.at("values").entries())
    if (value.value().is_number()) trial.values[name] = value.number();
  return trial;
}

Key key_of(const std::string& name, std::size_t k, const std::vector<Trial>& trials) {
  Key key{name, {}, {}, {}};
  for (const Trial& trial : trials)
    if (key.place.emplace(trial.settings[k], 0).second) key.values.push_back(trial.settings[k]);
  const auto number = [](const std::string& value) { return files::parse_number<double>(value); };
  if (std::ranges::all_of(key.values, [&](const auto& v) { return !!number(v); })) {
    std::ranges::stable_sort(key.values, {}, [&](const std::string& v) { return *number(v); });
    for (const std::string& value : key.values) key.numbers.push_back(*number(value));
  }
  for (std::size_t i = 0; i < key.values.size(); ++i) key.place[key.values[i]] = i;
  return key;
}

std::vector<Sweep> read_sweep(const fs::path& folder) {
  const fs::path file = folder / "scores.jsonl";
  std::istringstream text(files::read_text(file));
  std::vector<Sweep> all;
  std::vector<std::string> keys;
  for (std::string line; std::getline(text, line);) {
    Trial trial = trial_of(Json(file, line), keys);
    auto found = std::ranges::find(all, trial.scenario, &Sweep::scenario);
    if (found == all.end()) found = all.insert(all.end(), {trial.scenario, {}, {}});
    found->trials.push_back(std::move(trial));
  }
  if (all.empty()) throw files::FileError(file, "has no trial");
  for (Sweep& sweep : all)
    for (std::size_t k = 0; k < keys.size(); ++k) sweep.keys.push_back(key_of(keys[k], k, sweep.trials));
  return all;
}

/// Returns the shown metrics that the sweep has, and walk metrics only if a key changes the walk. The first
/// one determines the worst seeds.
std::vector<std::string> metrics_of(const Sweep& sweep) {
  std::vector<std::string> shown = shown_metrics(kOfSweeps);
  const bool walks_differ =
      std::ranges::any_of(sweep.keys, [](const Key& key) { return scenario::shapes_recording(key.name); });
  std::erase_if(shown, [&](const std::string& metric) {
    if (!walks_differ && score::find_metric(metric)->needs == score::Needs::walk) return true;
    return std::ranges::none_of(sweep.trials, [&](const Trial& t) { return t.values.contains(metric); });
  });
  return shown;
}

std::vector<double> values_of(const Trials& trials, const std::string& metric) {
  std::vector<double> values;
  for (const Trial* trial : trials)
    if (const double value = trial->value(metric); !std::isnan(value)) values.push_back(value);
  return values;
}

double center_of(const Trials& trials, const std::string& metric) {
  const std::vector<double> values = values_of(trials, metric);
  return values.empty() ? NAN : over_seeds(metric, values).center;
}

constexpr std::array kRoles{Role::estimate, Role::first, Role::second, Role::third, Role::plan, Role::truth};

/// Returns the values of the keys other than the k-th, such as "filter, 2". words_only: only non-numeric
/// keys, such as estimators.
std::string others_of(const Sweep& sweep, std::size_t k, const Trial& trial, bool words_only) {
  std::vector<std::string> values;
  for (std::size_t i = 0; i < sweep.keys.size(); ++i) {
    const Key& key = sweep.keys[i];
    if (i == k || key.values.size() < 2 || (words_only && !key.numbers.empty())) continue;
    values.push_back(key.numbers.empty() ? trial.settings[i]
                                         : fmt::format("{} {}", key.name, trial.settings[i]));
  }
  return fmt::format("{}", fmt::join(values, ", "));
}

/// Returns the names of the lines over a key, and sets the name of each trial: the values of the other keys
/// if there are enough colors, otherwise only of non-numeric keys, otherwise "median" for all trials.
std::vector<std::string> line_names(const Sweep& sweep, std::size_t k, std::vector<std::string>& of_trials) {
  for (const bool words_only : {false, true}) {
    std::vector<std::string> names;
    of_trials.clear();
    for (const Trial& trial : sweep.trials) {
      of_trials.push_back(others_of(sweep, k, trial, words_only));
      if (std::ranges::find(names, of_trials.back()) == names.end()) names.push_back(of_trials.back());
    }
    if (names.size() > 1 && names.size() <= kRoles.size() && sweep.keys[k].is_grid()) return names;
  }
  of_trials.assign(sweep.trials.size(), "median");
  return {"median"};
}

/// Draws medians over a numeric key: a line with its interval for each combination of the other keys' values,
/// or a single line with the trials as dots.
Figure lines_figure(const Sweep& sweep, std::size_t k, const std::string& metric) {
  const Key& key = sweep.keys[k];
  Figure f{fmt::format("{}_{}_{}", sweep.scenario, metric, key.name),
           fmt::format("{} over {}", metric, key.name), key.label(), metric_label(metric)};
  f.logarithmic_x = key.numbers.front() > 0 && key.numbers.back() > 8 * key.numbers.front();
  f.whole_y = metric == "loop_landmarks";
  std::vector<std::string> of_trials;
  const std::vector<std::string> names = line_names(sweep, k, of_trials);
  std::map<std::string, std::map<double, Trials>> groups;  // by line and value of the key
  Line dots{"a trial", Role::truth, {}, {}, true};
  for (std::size_t i = 0; i < sweep.trials.size(); ++i) {
    const double x = key.numbers[key.place.at(sweep.trials[i].settings[k])];
    groups[of_trials[i]][x].push_back(&sweep.trials[i]);
    if (const double y = sweep.trials[i].value(metric); !std::isnan(y)) dots.add(x, y);
  }
  const bool single = names.size() == 1;
  if (single && sweep.trials.size() <= kMostDots) f.lines = {dots};
  if (!key.is_grid() && !f.lines.empty()) return f;
  for (std::size_t g = 0; g < names.size(); ++g) {
    Line center{names[g] == "median" ? statistic_of(metric) : names[g], kRoles[g]};
    Envelope interval{"", kRoles[g]};
    for (const auto& [x, trials] : groups[names[g]]) {
      const std::vector<double> values = values_of(trials, metric);
      if (values.empty()) continue;
      const OverSeeds over = over_seeds(metric, values);
      center.add(x, over.center);
      if (!single && over.spread) interval.add(x, over.spread->first, over.spread->second);
    }
    if (interval.x.size() == center.x.size()) f.envelopes.push_back(interval);
    f.lines.push_back(center);
  }
  if (!f.envelopes.empty())
    f.remarks.push_back(fmt::format("areas: 95 % interval of the {}, below 6 seeds smallest to largest",
                                    statistic_of(metric)));
  return f;
}

/// Returns the figures over each numeric key and for each metric. If there are many keys, only the first ones
/// have figures, so that a browser can still open the page.
std::string figures_of(const Sweep& sweep) {
  std::string html, figures;
  std::vector<std::size_t> varied;
  for (std::size_t k = 0; k < sweep.keys.size(); ++k)
    if (sweep.keys[k].values.size() > 1) varied.push_back(k);
  if (varied.size() > kMostKeys) {
    html = fmt::format("<p>There are figures for the first {} of {} keys with several values.</p>\n",
                       kMostKeys, varied.size());
    varied.resize(kMostKeys);
  }
  for (const std::string& metric : metrics_of(sweep))
    for (const std::size_t k : varied)
      if (!sweep.keys[k].numbers.empty()) figures += figure_html(lines_figure(sweep, k, metric));
  return html + figures_html(figures);
}

std::vector<Trials> by_setting(const Sweep& sweep) {
  std::vector<Trials> groups;
  std::map<std::vector<std::string>, std::size_t> group_of;
  for (const Trial& trial : sweep.trials) {
    const std::size_t group = group_of.emplace(trial.settings, group_of.size()).first->second;
    groups.resize(group_of.size());
    groups[group].push_back(&trial);
  }
  return groups;
}

/// Returns a trial that did not complete, if any, otherwise the trial with the worst value of the metric.
const Trial& worst_of(const Trials& trials, const std::string& metric) {
  const auto badness = [&](const Trial* trial) {
    const double value = trial->value(metric);
    return std::pair(trial->ending != "completed",
                     std::isnan(value) ? INFINITY : score::loss(value, score::direction_of(metric)));
  };
  return **std::ranges::max_element(trials, {}, badness);
}

/// Returns the command that runs a trial, unless it would start a program named in the sweep.
std::string command_of(const Sweep& sweep, const Trial& trial, const fs::path& folder) {
  const fs::path file = folder / "scenarios" / (trial.scenario + ".yaml");
  std::string command = "tools/gaitslam run " + files::shell_word(file.string());
  scenario::Changes changes;
  for (std::size_t k = 0; k < sweep.keys.size(); ++k) {
    changes.overrides.push_back(fmt::format("{}={}", sweep.keys[k].name, trial.typed[k]));
    command += " " + files::shell_word(changes.overrides.back());
  }
  try {
    const auto read = scenario::read_scenario(file, changes);
    if (read.scenario.estimator.source != programs::Source::built_in)
      return "its scenario names an external program as estimator";
  } catch (const std::exception&) {  // nor does the command run
  }
  return fmt::format("{} seed={}", command, trial.seed);
}

std::string settings_table(const Sweep& sweep, const fs::path& folder) {
  const std::vector<std::string> metrics = metrics_of(sweep);
  const std::string first = metrics.empty() ? "" : metrics.front();
  std::vector<std::string> titles;
  for (const Key& key : sweep.keys) titles.push_back(key.label());
  titles.insert(titles.end(), {"completed", "worst seed"});
  for (const std::string& metric : metrics)
    titles.push_back(statistic_of(metric) + " " + metric_label(metric));
  std::vector<TableRow> rows;
  for (const Trials& trials : by_setting(sweep)) {
    TableRow& row = rows.emplace_back();
    for (const std::string& value : trials.front()->settings) row.cells.push_back(text_cell(value));
    const auto completed = std::ranges::count(trials, std::string("completed"), &Trial::ending);
    row.cells.push_back({fmt::format("{} of {}", completed, trials.size()), "number"});
    const Trial& worst = worst_of(trials, first);
    const double value = worst.ending == "completed" ? worst.value(first) : NAN;
    row.cells.push_back(
        {fmt::format("<details><summary>seed {}: {}</summary>{}<pre>{}</pre></details>", worst.seed,
                     std::isnan(value) ? escaped(worst.ending) : number_text(value), escaped(worst.cause),
                     escaped(command_of(sweep, worst, folder)))});
    for (const std::string& metric : metrics) row.cells.push_back(number_cell(center_of(trials, metric)));
  }
  return table_html("settings", titles, rows);
}

struct Tuning {
  Json json;
  Table history;
  std::string objective = json.at("objective").text();
  std::vector<Json> parameters = json.at("parameters").items();
  Column value = history.numbers(objective);  ///< loss of each setting
};

Tuning read_tuning(const fs::path& folder) {
  Tuning tuning{files::read_json(folder / "tune.json"), Table(folder / "history.csv")};
  if (tuning.value.empty()) throw files::FileError(folder / "history.csv", "has no setting");
  return tuning;
}

/// Returns the largest loss shown in figures, so that outliers do not compress the scale.
double largest_shown(const Tuning& t) {
  std::vector<double> known = t.value;
  std::erase_if(known, [](double value) { return !std::isfinite(value); });
  if (known.empty()) return NAN;
  const double least = std::ranges::min(known), middle = score::median(known), start = t.value.front();
  return std::max(middle, std::min(start, least + 10 * (middle - least))) + 0.5 * (middle - least);
}

/// Returns a dot for each setting, at the upper edge if its loss is unknown or off the scale.
std::vector<Line> setting_dots(const Tuning& t, const Column& at, double most) {
  Line tried{"setting", Role::truth, {}, {}, true}, above{"", Role::second, {}, {}, true};
  for (std::size_t i = 0; i < t.value.size(); ++i)
    (t.value[i] <= most ? tried : above).add(at[i], std::fmin(t.value[i], most));
  if (above.x.empty()) return {tried};
  above.name = fmt::format("{} of {} above {:.4g}, or failed", above.x.size(), t.value.size(), most);
  return {tried, above};
}

Figure history_figure(const Tuning& t, double most) {
  Column numbers(t.value.size());
  std::iota(numbers.begin(), numbers.end(), 0);
  Figure f{"history", "The search: the loss of each setting, and the lowest so far", "setting", t.objective,
           setting_dots(t, numbers, most)};
  f.whole_x = true;
  Line& best = f.lines.emplace_back(Line{"best so far", Role::estimate});
  double least = INFINITY;
  for (std::size_t i = 0; i < t.value.size(); ++i) {
    best.add(numbers[i], least <= most ? least : NAN);  // a step
    least = std::fmin(least, t.value[i]);
    best.add(numbers[i], least <= most ? least : NAN);
  }
  return f;
}

std::string label(const Json& p) { return with_unit(p.at("key").text(), p.at("unit").text()); }

Figure slice_figure(const Tuning& t, const Json& p, double most) {
  const std::string key = p.at("key").text();
  Figure f{"slice_" + key, "Losses over " + key, label(p), t.objective,
           setting_dots(t, t.history.numbers(key), most)};
  f.logarithmic_x = p.at("scale").text() == "log";
  if (f.lines[0].x.empty()) return f;
  const auto [low, high] = std::ranges::minmax_element(f.lines[0].x);
  for (const char* which : {"start", "best"})
    if (const double x = p.at(which).number(); x >= *low && x <= *high) f.moments.push_back({which, x});
  return f;
}

constexpr std::size_t kBins = 8, kLeastInBin = 3;

/// Returns the rank of each value; non-finite values come last.
std::vector<double> ranks_of(const Column& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::size_t i) {
    return std::isfinite(values[i]) ? values[i] : std::numeric_limits<double>::infinity();
  });
  std::vector<double> ranks(values.size());
  for (std::size_t k = 0; k < order.size(); ++k) ranks[order[k]] = static_cast<double>(k);
  return ranks;
}

/// Returns the fraction of the variance of the losses' ranks that one parameter explains, with its values in
/// bins of equal counts: omega squared (Hays 1963), which averages 0 without influence. nullopt with too few
/// settings.
std::optional<double> importance(const Tuning& t, const std::string& key) {
  const std::vector<double> places = ranks_of(t.history.numbers(key)), losses = ranks_of(t.value);
  const std::size_t n = losses.size(), bins = std::min(kBins, n / kLeastInBin);
  if (bins < 2) return std::nullopt;
  std::vector<std::vector<double>> of_bin(bins);
  for (std::size_t i = 0; i < n; ++i)
    of_bin[static_cast<std::size_t>(places[i]) * bins / n].push_back(losses[i]);
  const double mean = score::mean(losses);
  double between = 0, within = 0;
  for (const std::vector<double>& bin : of_bin) {
    const double middle = score::mean(bin);
    between += static_cast<double>(bin.size()) * (middle - mean) * (middle - mean);
    for (const double loss : bin) within += (loss - middle) * (loss - middle);
  }
  const double noise = within / static_cast<double>(n - bins);
  return std::max(0.0, (between - static_cast<double>(bins - 1) * noise) / (between + within + noise));
}

/// Returns a line for the settings of each group by the rank of their loss, the lowest losses last.
std::vector<Line> lines_by_loss(const Tuning& t, const std::function<void(Line&, std::size_t)>& add) {
  std::vector<Line> lines{
      {"higher losses", Role::truth}, {"lower half", Role::first}, {"lowest tenth", Role::estimate}};
  const std::vector<double> ranks = ranks_of(t.value);
  for (std::size_t i = 0; i < ranks.size(); ++i) {
    const double place = (ranks[i] + 1) / static_cast<double>(ranks.size());
    add(lines[place <= 0.1 ? 2 : place <= 0.5 ? 1 : 0], i);
  }
  return lines;
}

/// Returns each setting as a line through its values, each between the ends of what was searched.
Figure parallel_figure(const Tuning& t) {
  Figure f{"parallel", "Settings by loss", "parameter", "place in the searched range"};
  std::vector<Column> places;
  for (const Json& p : t.parameters) {
    const std::string key = p.at("key").text();
    const bool logarithmic = p.at("scale").text() == "log";
    const auto scaled = [&](double value) { return logarithmic ? std::log(value) : value; };
    const double low = scaled(p.at("from").number()), range = scaled(p.at("to").number()) - low;
    Column& of = places.emplace_back(t.history.numbers(key));
    for (double& value : of) value = (scaled(value) - low) / range;
    f.moments.push_back({key, static_cast<double>(places.size())});
  }
  f.lines = lines_by_loss(t, [&](Line& line, std::size_t i) {
    for (std::size_t k = 0; k < places.size(); ++k) line.add(static_cast<double>(k + 1), places[k][i]);
    line.add(static_cast<double>(places.size() + 1), NAN);  // space for the last name
  });
  f.lines[0].thin = f.whole_x = true;
  return f;
}

/// Returns the settings in the plane of the two parameters that explain the most.
Figure plane_figure(const Tuning& t) {
  std::vector<Json> order = t.parameters;
  std::ranges::stable_sort(order, std::greater{},
                           [&](const Json& p) { return importance(t, p.at("key").text()).value_or(0); });
  Figure f{"plane", "Losses over the two most important parameters", label(order[0]), label(order[1])};
  const Column x = t.history.numbers(order[0].at("key").text()),
               y = t.history.numbers(order[1].at("key").text());
  f.lines = lines_by_loss(t, [&](Line& line, std::size_t i) { line.dots = true, line.add(x[i], y[i]); });
  f.logarithmic_x = order[0].at("scale").text() == "log",
  f.logarithmic = order[1].at("scale").text() == "log";
  return f;
}

std::string figures(const Tuning& t) {
  const double most = largest_shown(t);
  std::string html = figure_html(history_figure(t, most));
  for (const Json& parameter : t.parameters) html += figure_html(slice_figure(t, parameter, most));
  if (t.parameters.size() > 1) html += figure_html(parallel_figure(t)) + figure_html(plane_figure(t));
  return figures_html(html);
}

std::string parameters_table(const Tuning& t) {
  std::vector<TableRow> rows;
  for (const Json& p : t.parameters) {
    const auto number = [&](const char* which) { return number_text(p.at(which).number()); };
    rows.push_back({{text_cell(label(p)),
                     {number("from") + " to " + number("to"), "number"},
                     {number("start"), "number"},
                     {number("best"), "number"},
                     number_cell(importance(t, p.at("key").text()))}});
  }
  return table_html("parameters", {"parameter", "searched", "before", "after", "importance"}, rows, true) +
         "<p class='soft'>importance: the fraction of the variance of the losses' ranks that the parameter "
         "explains without interactions (omega squared over up to eight groups of its values, from all "
         "settings of this search, which are not evenly spread).</p>\n";
}

std::optional<double> mean_of(const std::vector<std::optional<double>>& values) {
  std::vector<double> known;
  for (const auto& value : values)
    if (value) known.push_back(*value);
  return known.empty() ? std::nullopt : std::optional(score::mean(known));
}

/// Returns a row for each metric: its means before and after, the mean change per run, and its values in each
/// run. side: training or holdout.
std::string runs_table(const Json& side) {
  std::vector<std::string> titles{"metric", "mean before", "mean after",
                                  "mean change per run [95 % interval, t-test]"};
  for (const Json& run : side.at("runs").items()) titles.push_back(run.text());
  std::vector<TableRow> rows;
  for (const auto& [name, values] : side.at("values").entries()) {
    const auto numbers = [&, &of_metric = values](const char* which) {
      std::vector<std::optional<double>> all;
      for (const Json& value : of_metric.at(which).items()) all.push_back(value.number_or_null());
      all.resize(titles.size() - 4);
      return all;
    };
    const auto before = numbers("start"), after = numbers("best");
    if (!mean_of(before) && !mean_of(after)) continue;
    TableRow& row = rows.emplace_back(TableRow{
        {text_cell(metric_label(name)), number_cell(mean_of(before)), number_cell(mean_of(after)), {}}});
    std::vector<double> changes;
    for (std::size_t i = 0; i < before.size(); ++i) {
      row.cells.push_back({number_text(before[i]) + " → " + number_text(after[i]), "number"});
      if (before[i] && after[i]) changes.push_back(*after[i] - *before[i]);
    }
    const auto test = score::t_test(changes);
    row.cells[3] = {test ? fmt::format("{} [{}, {}]", number_text(score::mean(changes)),
                                       number_text(test->low), number_text(test->high))
                         : "-",
                    "number"};
  }
  return table_html("before and after", titles, rows);
}

std::string sides(const Tuning& t) {
  const Json holdout = t.json.at("holdout");
  const auto runs = static_cast<int>(holdout.at("runs").items().size());
  if (runs == 0) holdout.at("runs").fail("is empty, expected the names of the hold-out runs");
  std::string html = "<h3>Hold-out runs</h3>\n" + runs_table(holdout) + "<h3>Training runs</h3>\n" +
                     runs_table(t.json.at("training")) +
                     "<p class='soft'>The expected NEES of position and orientation is 3.";
  if (runs > 1) {
    const score::Band band = score::mean_band(3, runs);
    html += fmt::format(
        " For a consistent filter, the mean of {} independent runs lies between {:.2f} and {:.2f} in 95 % of "
        "cases.",
        runs, band.low, band.high);
  }
  return html + "</p>\n";
}

}  // namespace

bool is_sweep(const fs::path& folder) {
  return fs::exists(folder / "scores.jsonl") && fs::exists(folder / "trials.jsonl");
}

std::string sweep_page(const fs::path& folder) {
  const std::vector<Sweep> all = read_sweep(folder);
  std::size_t trials = 0;
  std::vector<Section> sections;
  for (const Sweep& sweep : all) {
    trials += sweep.trials.size();
    sections.push_back({"scenario-" + sweep.scenario, sweep.scenario,
                        figures_of(sweep) +
                            "<h3>Settings, and the worst seed of each with the command to run it</h3>\n" +
                            settings_table(sweep, folder)});
  }
  return html_page(
      "Sweep " + folder.filename().string(),
      fmt::format("{} of {}", files::counted(trials, "trial"), files::counted(all.size(), "scenario")),
      sections_html(sections, true));
}

bool is_tuning(const fs::path& folder) {
  return fs::exists(folder / "tune.json") && fs::exists(folder / "history.csv");
}

std::string tune_page(const fs::path& folder) {
  const Tuning t = read_tuning(folder);
  const Json change = t.json.at("change");
  const std::string verdict = change.at("verdict").text();
  return html_page("Tuning " + t.json.at("name").text(),
                   fmt::format("<span class='verdict {}'>{}</span> {} settings. {}.",
                               t.json.at("accepted").flag() ? "good"
                               : verdict == "worse"         ? "bad"
                                                            : "",
                               escaped(verdict), t.value.size(), escaped(change.at("text").text())),
                   sections_html({{"parameters", "Parameters", parameters_table(t)},
                                  {"sides", "Before and after", sides(t)},
                                  {"figures", "Figures", figures(t)}}));
}

}  // namespace sim::pages
