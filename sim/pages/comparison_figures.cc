#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "sim/files/text.h"
#include "sim/pages/run_figures.h"
#include "sim/score/consistency.h"
#include "sim/score/run.h"
#include "sim/score/statistics.h"

namespace sim::pages {
namespace {

using Runs = std::vector<const RunData*>;
using OverTime = std::map<double, Column>;  // by time, a value of each run

/// The runs by a member, in the order of its first appearances.
std::vector<std::pair<std::string, Runs>> grouped(const Runs& runs, std::string RunData::*member) {
  std::vector<std::pair<std::string, Runs>> groups;
  for (const RunData* run : runs) {
    const std::string& name = run->*member;
    auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& g) { return g.first == name; });
    if (group == groups.end()) group = groups.insert(groups.end(), {name, {}});
    group->second.push_back(run);
  }
  return groups;
}

/// Calls add(estimator, role, its runs) for each estimator; the fifth has the color of the first again.
template <class Add>
void for_each_estimator(const Runs& runs, Add add) {
  constexpr std::array kRoles{Role::estimate, Role::first, Role::second, Role::third};
  std::size_t number = 0;
  for (const auto& [estimator, its_runs] : grouped(runs, &RunData::estimator))
    add(estimator, kRoles[number++ % kRoles.size()], its_runs);
}

OverTime over_time(const Runs& runs, Column Errors::*column, double factor = 1) {
  OverTime at;
  for (const RunData* run : runs)
    for (std::size_t i = 0; run->errors && i < run->errors->t.size(); ++i) {
      Column& values = at[run->errors->t[i]];  // without a value the line breaks
      if (const double value = ((*run->errors).*column)[i]; std::isfinite(value))
        values.push_back(factor * value);
    }
  return at;
}

template <class Pool>
Line pooled(const std::string& name, Role role, const OverTime& at, Pool pool) {
  Line line{name, role};
  for (const auto& [t, values] : at)
    line.x.push_back(t), line.y.push_back(values.empty() ? NAN : pool(values));
  return line;
}

Figure figure(const std::string& name, const std::string& scenario, const std::string& title, const char* x,
              const char* y) {
  return {name + "_" + scenario, scenario + ": " + title, x, y};
}

Figure paths(const std::string& scenario, const Runs& runs) {
  Figure f = figure("paths", scenario, "camera from above, first seed", "x [m]", "y [m]");
  f.equal_axes = true;
  const Path &plan = runs.front()->plan, &truth = runs.front()->truth;
  f.lines = {{"plan", Role::plan, plan.x, plan.y}, {"truth", Role::truth, truth.x, truth.y}};
  for_each_estimator(runs, [&](const std::string& estimator, Role role, const Runs& its_runs) {
    if (const auto& estimate = its_runs.front()->estimate)
      f.lines.push_back({its_runs.front()->alignment == "none"
                             ? estimator
                             : fmt::format("{} ({})", estimator, its_runs.front()->alignment),
                         role, estimate->x, estimate->y});
  });
  return f;
}

/// The figure of the runs with one alignment.
Figure errors_over_time(const std::string& scenario, const std::string& alignment, const Runs& runs) {
  const bool aligned = alignment != "none";
  Figure f = figure("error_over_time", scenario, "position error, median over seeds", "time [s]", "mm");
  if (aligned) f.name += "_after_" + alignment, f.title += ", after its " + alignment + " alignment";
  f.logarithmic = true;
  for_each_estimator(runs, [&](const std::string& estimator, Role role, const Runs& its_runs) {
    f.lines.push_back(pooled(estimator, role, over_time(its_runs, &Errors::distance, kMm), score::median));
  });
  return f;
}

using Value = std::function<std::optional<double>(const RunData&)>;

/// The values of all runs twice: as a box of each estimator, and as dots by seed.
void add_boxes_and_dots(std::vector<Figure>& figures, const char* name, const std::string& scenario,
                        const std::string& title, const char* unit, const Runs& runs, const Value& value) {
  Figure boxes = figure(name + std::string("_boxes"), scenario,
                        title + ", quartiles over seeds, a dot for each run", "", unit),
         dots = figure(name + std::string("_by_seed"), scenario, title + " of every run", "seed", unit);
  boxes.logarithmic = dots.logarithmic = dots.whole_x = true;
  for_each_estimator(runs, [&](const std::string& estimator, Role role, const Runs& its_runs) {
    Box& box = boxes.boxes.emplace_back(Box{estimator, role});
    Line& line = dots.lines.emplace_back(Line{estimator, role, {}, {}, true});
    for (const RunData* run : its_runs) {
      const std::optional<double> y = value(*run);
      if (!y) continue;
      box.values.push_back(*y);
      line.x.push_back(static_cast<double>(run->seed)), line.y.push_back(*y);
    }
  });
  figures.insert(figures.end(), {boxes, dots});
}

std::vector<Figure> scenario_figures(const std::string& scenario, const Runs& runs) {
  std::vector<Figure> figures{paths(scenario, runs)};
  for (const auto& [alignment, its_runs] : grouped(runs, &RunData::alignment))
    figures.push_back(errors_over_time(scenario, alignment, its_runs));
  const auto same_seed = [&](const RunData* run) { return run->seed == runs.front()->seed; };
  if (std::all_of(runs.begin(), runs.end(), same_seed)) return figures;
  add_boxes_and_dots(figures, "ate", scenario, "ATE after SE(3) alignment", "mm", runs,
                     [](const RunData& run) -> std::optional<double> {
                       const auto value = run.metric("ate_se3_rmse_m");
                       return value ? std::optional(kMm * *value) : std::nullopt;
                     });
  add_boxes_and_dots(figures, "cpu", scenario, "CPU time of a frame (median)", "ms", runs,
                     [](const RunData& run) { return run.frame_cpu_ms_median; });
  return figures;
}

Figure walks(const Runs& runs) {
  Figure f{"walks", "True path of every run", "x [m]", "y [m]"};
  f.equal_axes = true;
  for (const RunData* run : runs)
    f.lines.push_back({f.lines.empty() ? "truth" : "", Role::truth, run->waist_truth.x, run->waist_truth.y});
  const Path& plan = runs.front()->waist_plan;
  f.lines.push_back({"plan", Role::plan, plan.x, plan.y});
  return f;
}

Figure error_over_seeds(const Runs& runs) {
  Figure f{"error_over_seeds", "Position error over seeds: minimum, median and maximum", "time [s]", "mm"};
  const OverTime at = over_time(runs, &Errors::distance, kMm);
  const auto quantile = [&](double q) {
    return pooled("median", Role::estimate, at, [q](const Column& v) { return score::quantile(v, q); });
  };
  f.lines = {quantile(0.5)};
  f.envelopes = {{"minimum to maximum", Role::estimate, f.lines[0].x, quantile(0).y, quantile(1).y}};
  return f;
}

std::string share_text(const OverTime& nees) {
  std::vector<Column> settled;
  for (auto at = nees.lower_bound(score::kSettled_s); at != nees.end(); ++at)
    if (!at->second.empty()) settled.push_back(at->second);
  const auto share = score::band_fractions(settled, 3);
  return share ? fmt::format("{:.0f} % (below it {:.0f} %)", 100 * share->inside, 100 * share->below)
               : "none";
}

std::optional<Figure> nees_over_seeds(const Runs& runs) {
  const OverTime position = over_time(runs, &Errors::nees_position),
                 orientation = over_time(runs, &Errors::nees_orientation);
  std::size_t most = 0;
  for (const auto& [t, values] : position) most = std::max(most, values.size());
  if (most == 0) return std::nullopt;
  Figure f{"nees_over_seeds",
           fmt::format("Normalized error squared, mean of {} (3 expected)", files::counted(most, "run")),
           "time [s]", "mean NEES"};
  f.logarithmic = true;
  f.lines = {pooled("position", Role::first, position, score::mean),
             pooled("orientation", Role::second, orientation, score::mean)};
  if (most < 2) return f;  // one run has no band
  f.title += fmt::format(". Frames after {:.0f} s in the 95 % band: position {}, orientation {}",
                         score::kSettled_s, share_text(position), share_text(orientation));
  const score::Band band = score::mean_band(3, static_cast<int>(most));
  f.levels = {{"2.5 %", band.low}, {"97.5 %", band.high}};
  return f;
}

std::vector<Figure> seed_figures(const Runs& runs) {
  std::vector<Figure> figures{walks(runs)};
  const auto scored = std::count_if(runs.begin(), runs.end(), [](const RunData* r) { return !!r->errors; });
  if (scored < 2) return figures;
  figures.push_back(error_over_seeds(runs));
  if (const auto nees = nees_over_seeds(runs)) figures.push_back(*nees);
  return figures;
}

}  // namespace

std::vector<Figure> comparison_figures(const std::vector<RunData>& runs) {
  Runs all;
  for (const RunData& run : runs) all.push_back(&run);
  const bool one_estimator =
      grouped(all, &RunData::estimator).size() < 2 && grouped(all, &RunData::alignment).size() < 2;
  const auto scenarios = grouped(all, &RunData::scenario);
  std::vector<Figure> figures;
  for (const auto& [scenario, its_runs] : scenarios) {
    if (its_runs.size() < 2) continue;
    std::vector<Figure> more =
        scenarios.size() < 2 && one_estimator ? seed_figures(its_runs) : scenario_figures(scenario, its_runs);
    for (Figure& f : more)
      for (const RunData* run : its_runs) f.runs.push_back(run->folder.string());
    figures.insert(figures.end(), more.begin(), more.end());
  }
  return figures;
}

}  // namespace sim::pages
