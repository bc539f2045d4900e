#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "sim/files/json.h"
#include "sim/pages/html.h"
#include "sim/pages/pages.h"
#include "sim/score/consistency.h"
#include "sim/score/statistics.h"

namespace sim::pages {
namespace {

namespace fs = std::filesystem;
using files::Json;

/// tune.json and history.csv as read.
struct Tuning {
  Json json;
  std::string objective;
  std::vector<Json> parameters;
  std::vector<std::string> keys;
  std::vector<std::vector<double>> at;  ///< values of each key, one for each setting
  std::vector<double> value;            ///< the loss of each setting
};

Tuning read_tuning(const fs::path& folder) {
  const Json json = files::read_json(folder / "tune.json");
  const Table history(folder / "history.csv");
  Tuning tuning{json, json.at("objective").text(), json.at("parameters").items(), {}, {}, {}};
  for (const Json& parameter : tuning.parameters) tuning.keys.push_back(parameter.at("key").text());
  for (const std::string& key : tuning.keys) tuning.at.push_back(history.numbers(key));
  tuning.value = history.numbers(tuning.objective);
  if (tuning.value.empty()) throw files::FileError(folder / "history.csv", "has no setting");
  return tuning;
}

/// The largest loss that figures show, so that outliers do not compress the scale.
double largest_shown(const Tuning& t) {
  const double least = score::quantile(t.value, 0), middle = score::median(t.value), start = t.value.front();
  return std::max(middle, std::min(start, least + 10 * (middle - least))) + 0.5 * (middle - least);
}

Figure history_figure(const Tuning& t, double most) {
  Figure f{"history", "The search: the loss of each setting, and the least so far", "setting", t.objective};
  f.whole_x = true;
  Line tried{"setting", Role::truth, {}, {}, true}, best{"best so far", Role::estimate};
  double least = INFINITY;
  for (std::size_t i = 0; i < t.value.size(); ++i) {
    least = std::min(least, t.value[i]);
    tried.x.push_back(static_cast<double>(i)), tried.y.push_back(t.value[i] <= most ? t.value[i] : NAN);
    best.x.push_back(static_cast<double>(i)), best.y.push_back(least <= most ? least : NAN);
  }
  f.lines = {tried, best};
  return f;
}

std::string label(const Json& p) {
  const std::string key = p.at("key").text(), unit = p.at("unit").text();
  return unit.empty() ? key : key + " [" + unit + "]";
}

Figure slice_figure(const Tuning& t, std::size_t k, double most) {
  const Json& p = t.parameters[k];
  Figure f{"slice_" + t.keys[k], "Losses over " + t.keys[k], label(p), t.objective};
  f.logarithmic_x = p.at("scale").text() == "log";
  Line dots{"", Role::truth, {}, {}, true};
  for (std::size_t i = 0; i < t.value.size(); ++i)
    if (t.value[i] <= most) dots.x.push_back(t.at[k][i]), dots.y.push_back(t.value[i]);
  f.lines.push_back(dots);
  if (dots.x.empty()) return f;
  const auto [low, high] = std::ranges::minmax_element(dots.x);
  for (const char* which : {"start", "best"})
    if (const double at = p.at(which).number(); at >= *low && at <= *high) f.moments.push_back({which, at});
  return f;
}

std::string figures(const Tuning& t) {
  const double most = largest_shown(t);
  std::string html = figure_html(history_figure(t, most));
  for (std::size_t k = 0; k < t.keys.size(); ++k) html += figure_html(slice_figure(t, k, most));
  return figures_html(html);
}

std::string parameters_table(const Tuning& t) {
  std::vector<TableRow> rows;
  for (const Json& p : t.parameters) {
    const auto number = [&](const char* which) { return number_text(p.at(which).number()); };
    rows.push_back({{text_cell(label(p)),
                     {number("from") + " to " + number("to"), "number"},
                     {number("start"), "number"},
                     {number("best"), "number"}}});
  }
  return table_html("parameters",
                    {{"parameter"}, {"searched", "number"}, {"before", "number"}, {"after", "number"}}, rows);
}

/// The values of each run before and after, and their means. side: training or holdout.
std::string runs_table(const Json& side) {
  std::vector<TableCell> titles{{"run"}};
  std::vector<TableRow> rows;
  for (const Json& run : side.at("runs").items()) rows.push_back({{text_cell(run.text())}});
  rows.push_back({{{"mean"}}});
  for (const auto& [name, values] : side.at("values").entries())
    for (const auto& [which, words] : {std::pair{"start", "before"}, std::pair{"best", "after"}}) {
      titles.push_back(text_cell(fmt::format("{} {}", name, words), "number"));
      const std::vector<Json> all = values.at(which).items();
      std::vector<double> known;
      for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
        const auto value = i < all.size() ? all[i].number_or_null() : std::nullopt;
        rows[i].cells.push_back(number_cell(value));
        if (value) known.push_back(*value);
      }
      rows.back().cells.push_back(
          number_cell(known.empty() ? std::nullopt : std::optional(score::mean(known))));
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
    html +=
        fmt::format(" The mean of {} independent runs lies between {:.2f} and {:.2f} with 95 % confidence.",
                    runs, band.low, band.high);
  }
  return html + "</p>\n";
}

}  // namespace

bool is_tuning(const fs::path& folder) {
  return fs::exists(folder / "tune.json") && fs::exists(folder / "history.csv");
}

std::string tune_page(const fs::path& folder) {
  const Tuning t = read_tuning(folder);
  const bool accepted = t.json.at("accepted").flag();
  const std::string warning = t.json.at("holdout").at("runs").items().size() > 1
                                  ? ""
                                  : "<p class='warning'><b>The hold-out is one run.</b> Its result may be "
                                    "chance: list several seeds or "
                                    "other walks under <code>holdout</code>, and tune again.</p>\n";
  return html_page(
      "Tuning " + t.json.at("name").text(),
      fmt::format("<span class='verdict {}'>{}</span> {} settings, by {}", accepted ? "good" : "bad",
                  accepted ? "better on hold-out runs" : "rejected: worse on hold-out runs", t.value.size(),
                  escaped(t.objective)),
      warning + sections_html({{"parameters", "Parameters", parameters_table(t)},
                               {"sides", "Before and after", sides(t)},
                               {"figures", "Figures", figures(t)}}));
}

}  // namespace sim::pages
