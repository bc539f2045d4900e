#include "sim/pages/tune_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "sim/files/json.h"
#include "sim/pages/figure.h"
#include "sim/pages/html.h"
#include "sim/pages/table.h"
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
  std::vector<Json> parameters, profiles;  ///< profiles: of none or each of the parameters
  std::vector<std::string> keys;
  std::vector<std::vector<double>> at;  ///< values of each key, one for each setting
  std::vector<double> value, complete;  ///< of each setting: its loss, and 1 where it was not aborted
};

Tuning read_tuning(const fs::path& folder) {
  const Json json = files::read_json(folder / "tune.json");
  const Table history(folder / "history.csv");
  Tuning tuning{json,
                json.at("objective").text(),
                json.at("parameters").items(),
                json.at("profiles").items(),
                {},
                {},
                {},
                {}};
  if (tuning.profiles.size() > tuning.parameters.size())
    json.at("profiles").fail("has more items than there are parameters");
  for (const Json& parameter : tuning.parameters) tuning.keys.push_back(parameter.at("key").text());
  for (const std::string& key : tuning.keys) tuning.at.push_back(history.numbers(key));
  tuning.value = history.numbers(tuning.objective);
  tuning.complete = history.numbers("complete");
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

Figure history_figure(const Tuning& t) {
  Figure f{"history", "The search: the loss of each setting, and the least so far", "setting", t.objective};
  f.whole_x = true;
  const double most = largest_shown(t), none = std::nan("");
  Line tried{"setting", Role::truth, {}, {}, true}, ended{"aborted", Role::third, {}, {}, true},
      best{"best so far", Role::estimate, {}, {}};
  double least = INFINITY;
  for (std::size_t i = 0; i < t.value.size(); ++i) {
    const double value = t.value[i] <= most ? t.value[i] : none;
    if (t.complete[i] > 0) least = std::min(least, t.value[i]);
    Line& line = t.complete[i] > 0 ? tried : ended;
    line.x.push_back(static_cast<double>(i)), line.y.push_back(value);
    best.x.push_back(static_cast<double>(i)), best.y.push_back(least <= most ? least : none);
  }
  f.lines = {tried, ended, best};
  return f;
}

bool logarithmic(const Json& parameter) { return parameter.at("scale").text() == "log"; }

/// Where a value lies in its range, 0 to 1.
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

Figure slice_figure(const Tuning& t, std::size_t k) {
  const Json& p = t.parameters[k];
  Figure f{"slice_" + t.keys[k], "Losses over " + t.keys[k], label(p), t.objective};
  f.logarithmic_x = logarithmic(p);
  const double most = largest_shown(t);
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

Figure profile_figure(const Json& profile, const Json& p) {
  const std::string key = profile.at("key").text();
  Figure f{"profile_" + key,
           "Profile of " + key +
               (profile.at("identifiable").flag() ? "" : ": not identifiable from these recordings"),
           label(p), "rise above the least loss"};
  f.logarithmic_x = logarithmic(p);
  const std::vector<double> at = numbers(profile.at("at")), rises = numbers(profile.at("rises"));
  if (at.size() != rises.size()) profile.at("rises").fail("has another number of items than 'at'");
  f.lines.push_back({"the others at their best", Role::estimate, at, rises});
  f.lines.push_back({"", Role::estimate, at, rises, true});
  if (const auto threshold = profile.find("threshold"))
    f.levels.push_back({"95 % interval ends", threshold->number()});
  for (const char* end : {"low", "high"})
    if (const auto bound = profile.find(end)) f.moments.push_back({"95 %", bound->number()});
  return f;
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

Figure nees_figure(const std::string& part, const Json& holdout) {
  const std::string metric = "nees_" + part + "_mean";
  Figure f = runs_figure(metric, "Consistency of the " + part + " on hold-out runs, before and after",
                         holdout, metric);
  f.logarithmic = true;
  f.levels.push_back({"expected", 3});
  return f;
}

std::vector<Figure> figures(const Tuning& t) {
  std::vector<Figure> all{history_figure(t)};
  all.push_back(parallel_figure(t));
  for (std::size_t k = 0; k < t.keys.size(); ++k) all.push_back(slice_figure(t, k));
  for (std::size_t k = 0; k < t.profiles.size(); ++k)
    all.push_back(profile_figure(t.profiles[k], t.parameters[k]));
  const Json training = t.json.at("training"), holdout = t.json.at("holdout");
  all.push_back(runs_figure("training", "Training runs, before and after", training, t.objective));
  all.push_back(runs_figure("holdout", "Hold-out runs, before and after", holdout, t.objective));
  for (const char* part : {"position", "orientation"}) all.push_back(nees_figure(part, holdout));
  return all;
}

constexpr const char* kTableBegin =
    "<div class='scroll' tabindex='0' role='region' aria-label='table'><table class='named-rows'>";
constexpr const char* kTableEnd = "</table></div>\n";

std::string number(const Json& value) { return fmt::format("{:.4g}", value.number()); }

std::string row(const std::vector<std::string>& cells, const char* tag) {
  std::string html = "<tr>";
  for (std::size_t i = 0; i < cells.size(); ++i)
    html += fmt::format("<{0}{2}>{1}</{0}>", tag, escaped(cells[i]), i == 0 ? "" : " class='number'");
  return html + "</tr>\n";
}

std::string parameters_table(const Tuning& t) {
  std::string html = kTableBegin + row({"parameter", "searched", "before", "after", "95 % interval"}, "th");
  for (std::size_t k = 0; k < t.keys.size(); ++k) {
    const Json& p = t.parameters[k];
    std::string interval = "-";
    if (k < t.profiles.size()) {
      const Json& profile = t.profiles[k];
      const auto end = [&](const char* which) {
        const auto bound = profile.find(which);
        return bound ? number(*bound) : "?";
      };
      interval =
          fmt::format("{} to {}{}", end("low"), end("high"),
                      profile.at("identifiable").flag() ? "" : " (not identifiable from these recordings)");
    }
    html += row({label(p), number(p.at("from")) + " to " + number(p.at("to")), number(p.at("start")),
                 number(p.at("best")), interval},
                "td");
  }
  return html + kTableEnd;
}

std::string mean_of(const Json& list) {
  std::vector<double> known;
  for (const double value : numbers(list))
    if (std::isfinite(value)) known.push_back(value);
  return known.empty() ? "-" : fmt::format("{:.4g}", score::mean(known));
}

std::string sides_table(const Tuning& t) {
  const Json training = t.json.at("training"), holdout = t.json.at("holdout");
  std::string html =
      kTableBegin + row({"mean over runs", "training: before", "after", "hold-out: before", "after"}, "th");
  for (const auto& [name, values] : holdout.at("values").entries()) {
    const Json there = training.at("values").at(name);
    html += row({name, mean_of(there.at("start")), mean_of(there.at("best")), mean_of(values.at("start")),
                 mean_of(values.at("best"))},
                "td");
  }
  html += std::string(kTableEnd) + "<p class='soft'>The expected NEES of position and orientation is 3.";
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

/// One hold-out run says little: it may be better or worse by chance.
std::string warning(const Tuning& t) {
  if (t.json.at("holdout").at("runs").items().size() > 1) return "";
  return "<p class='warning'><b>The hold-out is one run.</b> That it is better or worse there may be chance: "
         "name "
         "several seeds, or other walks, under <code>holdout</code>, and tune again.</p>\n";
}

/// The place in the page of a run; side: "training" or "holdout".
std::string run_anchor(const std::string& side, std::size_t i) { return fmt::format("{}-{}", side, i + 1); }

/// The runs by the numbers that figures give them, with their losses.
std::string runs_list(const Tuning& t, const std::string& side) {
  const Json of = t.json.at(side);
  const std::vector<Json> runs = of.at("runs").items();
  const Json losses = of.at("values").at(t.objective);
  const std::vector<double> before = numbers(losses.at("start")), after = numbers(losses.at("best"));
  const auto shown = [](const std::vector<double>& all, std::size_t i) {
    return i < all.size() && std::isfinite(all[i]) ? fmt::format("{:.4g}", all[i]) : std::string("-");
  };
  std::string html = fmt::format("<details open id='runs-{}'><summary>{}</summary><ol>\n", side,
                                 side == "holdout" ? "Hold-out runs" : "Training runs");
  for (std::size_t i = 0; i < runs.size(); ++i)
    html += fmt::format("<li id='{}'>{}: {} {} before, {} after</li>\n", run_anchor(side, i),
                        escaped(runs[i].text()), escaped(t.objective), shown(before, i), shown(after, i));
  return html + "</ol></details>\n";
}

/// Where a reader finds what a figure shows: its runs, or the row of its parameter.
std::string link_of(const Figure& figure) {
  if (figure.name == "training") return "<a href='#runs-training'>which runs these are</a>";
  if (figure.name == "holdout" || figure.name.starts_with("nees_"))
    return "<a href='#runs-holdout'>which runs these are</a>";
  return "<a href='#parameters'>the parameters in numbers</a>";
}

std::string figure_html(const Figure& figure) {
  constexpr double kWidth = 640, kHeight = 300;
  return fmt::format("<figure id='{}'><figcaption>{}</figcaption>{}<p class='soft'>{}</p></figure>\n",
                     escaped(figure.name), escaped(figure.title), to_svg(figure, kWidth, kHeight),
                     link_of(figure));
}

}  // namespace

std::string tune_page(const fs::path& folder) {
  const Tuning t = read_tuning(folder);
  const bool accepted = t.json.at("accepted").flag();
  const std::string name = t.json.at("name").text();
  std::string html = html_head("tuning " + name, "\n#parallel .line.truth{stroke-opacity:.2}");
  html += fmt::format("<h1>Tuning {}</h1>\n<p><span class=\"verdict {}\">{}</span> {} settings, by {}</p>\n",
                      escaped(name), accepted ? "good" : "bad",
                      accepted ? "better on hold-out runs" : "refused: worse on hold-out runs",
                      t.value.size(), escaped(t.objective));
  html += warning(t) + "<section id='parameters'>" + parameters_table(t) + "</section>\n";
  html += "<h2>Before and after</h2>\n" + sides_table(t);
  for (const char* side : {"training", "holdout"}) html += runs_list(t, side);
  html += "<h2>Figures</h2>\n<div class='figures'>\n";
  for (const Figure& figure : figures(t)) html += figure_html(figure);
  return html + "</div>\n" + kHtmlEnd;
}

}  // namespace sim::pages
