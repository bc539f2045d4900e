#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "sim/files/json.h"
#include "sim/pages/figure.h"
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
  std::vector<double> sorted = t.value;
  std::sort(sorted.begin(), sorted.end());
  const double least = sorted.front(), middle = sorted[sorted.size() / 2], start = t.value.front();
  return std::max(middle, std::min(start, least + 10 * (middle - least))) + 0.5 * (middle - least);
}

Figure history_figure(const Tuning& t, double most) {
  Figure f{"history", "The search: the loss of each setting, and the least so far", "setting", t.objective};
  f.whole_x = true;
  const double none = std::nan("");
  Line tried{"setting", Role::truth, {}, {}, true}, best{"best so far", Role::estimate, {}, {}};
  double least = INFINITY;
  for (std::size_t i = 0; i < t.value.size(); ++i) {
    least = std::min(least, t.value[i]);
    tried.x.push_back(static_cast<double>(i)), tried.y.push_back(t.value[i] <= most ? t.value[i] : none);
    best.x.push_back(static_cast<double>(i)), best.y.push_back(least <= most ? least : none);
  }
  f.lines = {tried, best};
  return f;
}

bool logarithmic(const Json& parameter) { return parameter.at("scale").text() == "log"; }

/// Position of a value in its range, 0 to 1.
double part(const Json& p, double value) {
  const double low = p.at("from").number(), high = p.at("to").number();
  return logarithmic(p) ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
}

Figure parallel_figure(const Tuning& t) {
  Figure f{"parallel", "Parallel coordinates: the best tenth of the settings and the others",
           "parameter, by its row in the table above", "position in its range"};
  f.whole_x = true;
  std::vector<std::size_t> order(t.value.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return t.value[a] > t.value[b]; });
  const std::size_t good = order.size() - std::max<std::size_t>(1, order.size() / 10);
  for (std::size_t i = order.size() > 300 ? order.size() - 300 : 0; i < order.size(); ++i) {
    Line line{"", i < good ? Role::truth : Role::estimate, {}, {}};
    if (i + 1 == order.size()) line.name = "the best tenth";
    for (std::size_t k = 0; k < t.keys.size(); ++k) {
      line.x.push_back(static_cast<double>(k + 1));
      line.y.push_back(part(t.parameters[k], t.at[k][order[i]]));
    }
    if (t.keys.size() == 1) line.dots = true;
    f.lines.push_back(line);
  }
  return f;
}

std::string label(const Json& p) {
  const std::string key = p.at("key").text(), unit = p.at("unit").text();
  return unit.empty() ? key : key + " [" + unit + "]";
}

Figure slice_figure(const Tuning& t, std::size_t k, double most) {
  const Json& p = t.parameters[k];
  Figure f{"slice_" + t.keys[k], "Losses over " + t.keys[k], label(p), t.objective};
  f.logarithmic_x = logarithmic(p);
  Line dots{"", Role::truth, {}, {}, true};
  for (std::size_t i = 0; i < t.value.size(); ++i)
    if (t.value[i] <= most) dots.x.push_back(t.at[k][i]), dots.y.push_back(t.value[i]);
  f.lines.push_back(dots);
  if (dots.x.empty()) return f;
  const auto [low, high] = std::minmax_element(dots.x.begin(), dots.x.end());
  for (const char* which : {"start", "best"})
    if (const double at = p.at(which).number(); at >= *low && at <= *high) f.moments.push_back({which, at});
  return f;
}

std::vector<double> numbers(const Json& list) {
  std::vector<double> all;
  for (const Json& item : list.items()) all.push_back(item.number_or_null().value_or(std::nan("")));
  return all;
}

// Start and best of each run, one beside the other.
Figure runs_figure(const std::string& name, const std::string& title, const Json& side,
                   const std::string& of) {
  Figure f{name, title, "run, by its number in the list of runs", of};
  f.whole_x = true;
  for (const auto& [which, words, role] :
       {std::tuple{"start", "before", Role::plan}, std::tuple{"best", "after", Role::estimate}}) {
    const std::vector<double> y = numbers(side.at("values").at(of).at(which));
    std::vector<double> x(y.size());
    std::iota(x.begin(), x.end(), 1.0);
    f.lines.push_back({words, role, x, y, true});
  }
  return f;
}

std::vector<Figure> figures(const Tuning& t) {
  const double most = largest_shown(t);
  std::vector<Figure> all{history_figure(t, most), parallel_figure(t)};
  for (std::size_t k = 0; k < t.keys.size(); ++k) all.push_back(slice_figure(t, k, most));
  const Json training = t.json.at("training"), holdout = t.json.at("holdout");
  all.push_back(runs_figure("training", "Training runs, before and after", training, t.objective));
  all.push_back(runs_figure("holdout", "Hold-out runs, before and after", holdout, t.objective));
  for (const std::string part : {"position", "orientation"}) {
    const std::string metric = "nees_" + part + "_mean";
    all.push_back(runs_figure(metric, "Consistency of the " + part + " on hold-out runs, before and after",
                              holdout, metric));
    all.back().logarithmic = true;
    all.back().levels = {{"expected", 3}};
  }
  return all;
}

std::string parameters_table(const Tuning& t) {
  std::vector<TableRow> rows;
  for (std::size_t k = 0; k < t.keys.size(); ++k) {
    const Json& p = t.parameters[k];
    const auto number = [&](const char* which) { return number_text(p.at(which).number()); };
    rows.push_back({{text_cell(label(p)),
                     {number("from") + " to " + number("to"), "number"},
                     {number("start"), "number"},
                     {number("best"), "number"}}});
  }
  return table_html("parameters",
                    {{"parameter"}, {"searched", "number"}, {"before", "number"}, {"after", "number"}}, rows);
}

TableCell mean_of(const Json& list) {
  std::vector<double> known;
  for (const double value : numbers(list))
    if (std::isfinite(value)) known.push_back(value);
  return number_cell(known.empty() ? std::nullopt : std::optional(score::mean(known)));
}

std::string sides_table(const Tuning& t) {
  const Json training = t.json.at("training"), holdout = t.json.at("holdout");
  std::vector<TableRow> rows;
  for (const auto& [name, values] : holdout.at("values").entries()) {
    const Json there = training.at("values").at(name);
    rows.push_back({{text_cell(name), mean_of(there.at("start")), mean_of(there.at("best")),
                     mean_of(values.at("start")), mean_of(values.at("best"))}});
  }
  std::string html = table_html("before and after",
                                {{"mean over runs"},
                                 {"training: before", "number"},
                                 {"after", "number"},
                                 {"hold-out: before", "number"},
                                 {"after", "number"}},
                                rows) +
                     "<p class='soft'>The expected NEES of position and orientation is 3.";
  const auto runs = static_cast<int>(holdout.at("runs").items().size());
  if (runs == 0) holdout.at("runs").fail("is empty, expected the names of the hold-out runs");
  if (runs > 1) {
    const score::Band band = score::mean_band(3, runs);
    html +=
        fmt::format(" The mean of {} independent runs lies between {:.2f} and {:.2f} with 95 % confidence.",
                    runs, band.low, band.high);
  }
  return html + "</p>\n";
}

std::string warning(const Tuning& t) {
  if (t.json.at("holdout").at("runs").items().size() > 1) return "";
  return "<p class='warning'><b>The hold-out is one run.</b> Its result may be chance: list several seeds or "
         "other walks under <code>holdout</code>, and tune again.</p>\n";
}

/// The runs by the numbers that figures give them, with their losses.
std::string runs_list(const Tuning& t, const std::string& side) {
  const Json of = t.json.at(side);
  const std::vector<Json> runs = of.at("runs").items();
  const Json losses = of.at("values").at(t.objective);
  const std::vector<double> before = numbers(losses.at("start")), after = numbers(losses.at("best"));
  const auto shown = [](const std::vector<double>& all, std::size_t i) {
    return number_text(i < all.size() ? std::optional(all[i]) : std::nullopt);
  };
  std::string html = fmt::format("<details open id='runs-{}'><summary>{}</summary><ol>\n", side,
                                 side == "holdout" ? "Hold-out runs" : "Training runs");
  for (std::size_t i = 0; i < runs.size(); ++i)
    html += fmt::format("<li id='{}-{}'>{}: {} {} before, {} after</li>\n", side, i + 1,
                        escaped(runs[i].text()), escaped(t.objective), shown(before, i), shown(after, i));
  return html + "</ol></details>\n";
}

/// A link from a figure to its runs or parameters.
std::string link_of(const Figure& figure) {
  if (figure.name == "training") return "<a href='#runs-training'>which runs these are</a>";
  if (figure.name == "holdout" || figure.name.starts_with("nees_"))
    return "<a href='#runs-holdout'>which runs these are</a>";
  return "<a href='#parameters'>the parameters in numbers</a>";
}

}  // namespace

bool is_tuning(const fs::path& folder) {
  return fs::exists(folder / "tune.json") && fs::exists(folder / "history.csv");
}

std::string tune_page(const fs::path& folder) {
  const Tuning t = read_tuning(folder);
  const bool accepted = t.json.at("accepted").flag();
  std::string runs, shown;
  for (const char* side : {"training", "holdout"}) runs += runs_list(t, side);
  for (const Figure& figure : figures(t))
    shown += figure_html(figure, "<p class='soft'>" + link_of(figure) + "</p>");
  return html_page(
      "Tuning " + t.json.at("name").text(),
      fmt::format("<span class='verdict {}'>{}</span> {} settings, by {}", accepted ? "good" : "bad",
                  accepted ? "better on hold-out runs" : "rejected: worse on hold-out runs", t.value.size(),
                  escaped(t.objective)),
      warning(t) + section_html("parameters", "Parameters", parameters_table(t)) +
          section_html("sides", "Before and after", sides_table(t) + runs) +
          section_html("figures", "Figures", figures_html(shown)));
}

}  // namespace sim::pages
