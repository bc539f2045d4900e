#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "sim/files/text.h"
#include "sim/pages/pages.h"
#include "sim/score/consistency.h"
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
    auto group = std::ranges::find(groups, name, &decltype(groups)::value_type::first);
    if (group == groups.end()) group = groups.insert(groups.end(), {name, {}});
    group->second.push_back(run);
  }
  return groups;
}

/// Calls add(estimator, role, its runs) for each estimator; the fifth has the color of the first again.
void for_each_estimator(const Runs& runs, const auto& add) {
  constexpr std::array kRoles{Role::estimate, Role::first, Role::second, Role::third};
  std::size_t number = 0;
  for (const auto& [estimator, its_runs] : grouped(runs, &RunData::estimator))
    add(estimator, kRoles[number++ % kRoles.size()], its_runs);
}

/// The values of a column at the times of another. Without a value the line breaks.
void add_values(OverTime& at, const Column& t, const Column& values, double factor) {
  for (std::size_t i = 0; i < t.size(); ++i) {
    Column& all = at[t[i]];
    if (std::isfinite(values[i])) all.push_back(factor * values[i]);
  }
}

OverTime over_time(const Runs& runs, Column Errors::*column, double factor = 1) {
  OverTime at;
  for (const RunData* run : runs)
    if (run->errors) add_values(at, run->errors->t, (*run->errors).*column, factor);
  return at;
}

Line pooled(const std::string& name, Role role, const OverTime& at, const auto& pool) {
  Line line{name, role};
  for (const auto& [t, values] : at)
    line.x.push_back(t), line.y.push_back(values.empty() ? NAN : pool(values));
  return line;
}

/// Such a run has its own line.
bool have_odometry_run(const Runs& runs) {
  return std::ranges::any_of(runs, [](const RunData* run) { return run->estimator == "odometry"; });
}

Figure paths(const Runs& runs) {
  Figure f{"paths", "camera from above, first seed", "x [m]", "y [m]"};
  f.equal_axes = true;
  const Path &plan = runs.front()->plan, &truth = runs.front()->truth;
  f.lines = {{"plan", Role::plan, plan.x, plan.y}, {"truth", Role::truth, truth.x, truth.y}};
  if (const auto& odometry = runs.front()->odometry; odometry && !have_odometry_run(runs))
    f.lines.push_back({kOdometryName, Role::third, odometry->x, odometry->y, false, true});
  for_each_estimator(runs, [&](const std::string& estimator, Role role, const Runs& its_runs) {
    const RunData& run = *its_runs.front();
    const std::string name =
        run.alignment == "none" ? estimator : fmt::format("{} ({})", estimator, run.alignment);
    if (run.estimate) f.lines.push_back({name, role, run.estimate->x, run.estimate->y});
  });
  return f;
}

/// The figure of the runs with one alignment: the median, and of one estimator the whole range.
Figure errors_over_time(const std::string& alignment, const Runs& runs) {
  Figure f{"error_over_time", "position error, median over seeds", "time [s]", "mm"};
  if (alignment != "none")
    f.name += "_after_" + alignment, f.title += ", after its " + alignment + " alignment";
  f.logarithmic = true;
  for_each_estimator(runs, [&](const std::string& estimator, Role role, const Runs& its_runs) {
    const OverTime at = over_time(its_runs, &Errors::distance, kMm);
    const auto quantile = [&](double q) {
      return pooled(estimator, role, at, [q](const Column& v) { return score::quantile(v, q); });
    };
    const Line median = f.lines.emplace_back(quantile(0.5));
    f.envelopes = {{"minimum to maximum", role, median.x, quantile(0).y, quantile(1).y}};
  });
  if (f.lines.size() > 1) f.envelopes.clear();
  OverTime blind;
  for (const RunData* run : runs)
    if (run->odometry) add_values(blind, run->odometry->t, run->odometry_error, kMm);
  if (!blind.empty() && alignment == "none" && !have_odometry_run(runs))
    f.lines.push_back(pooled(kOdometryName, Role::third, blind, score::median)), f.lines.back().thin = true;
  return f;
}

/// A value of every run, as dots of each estimator by seed.
Figure by_seed(const char* name, const char* title, const char* unit, const Runs& runs,
               std::optional<double> (*value)(const RunData&)) {
  Figure f{name, title, "seed", unit};
  f.logarithmic = f.whole_x = true;
  for_each_estimator(runs, [&](const std::string& estimator, Role role, const Runs& its_runs) {
    Line& dots = f.lines.emplace_back(Line{estimator, role, {}, {}, true});
    for (const RunData* run : its_runs)
      if (const std::optional<double> y = value(*run))
        dots.x.push_back(static_cast<double>(run->seed)), dots.y.push_back(*y);
  });
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

/// Of the runs of one estimator; empty if fewer than two have a NEES.
std::optional<Figure> nees_over_seeds(const Runs& runs) {
  const OverTime position = over_time(runs, &Errors::nees_position),
                 orientation = over_time(runs, &Errors::nees_orientation);
  std::size_t most = 0;
  for (const auto& [t, values] : position) most = std::max(most, values.size());
  if (most < 2) return std::nullopt;
  Figure f{"nees_over_seeds",
           fmt::format("normalized error squared, mean of {} (3 expected). Frames after {:.0f} s in the 95 % "
                       "band: position {}, orientation {}",
                       files::counted(most, "run"), score::kSettled_s, share_text(position),
                       share_text(orientation)),
           "time [s]", "mean NEES"};
  f.logarithmic = true;
  f.lines = {pooled("position", Role::first, position, score::mean),
             pooled("orientation", Role::second, orientation, score::mean)};
  const score::Band band = score::mean_band(3, static_cast<int>(most));
  f.levels = {{"2.5 %", band.low}, {"97.5 %", band.high}};
  return f;
}

std::vector<Figure> scenario_figures(const std::string& scenario, const Runs& runs) {
  std::vector<Figure> figures{paths(runs)};
  const auto alignments = grouped(runs, &RunData::alignment);
  for (const auto& [alignment, its_runs] : alignments)
    figures.push_back(errors_over_time(alignment, its_runs));
  if (alignments.size() == 1 && grouped(runs, &RunData::estimator).size() == 1)
    if (const auto nees = nees_over_seeds(runs)) figures.push_back(*nees);
  const auto same_seed = [&](const RunData* run) { return run->seed == runs.front()->seed; };
  if (!std::ranges::all_of(runs, same_seed)) {
    const auto ate_mm = [](const RunData& run) {
      const auto value = run.value("ate_se3_rmse_m");
      return value ? std::optional(kMm * *value) : std::nullopt;
    };
    figures.push_back(by_seed("ate_by_seed", "ATE of every run after SE(3) alignment", "mm", runs, ate_mm));
    figures.push_back(by_seed("cpu_by_seed", "CPU time of a frame of every run (median)", "ms", runs,
                              [](const RunData& run) { return run.frame_cpu_ms_median; }));
  }
  for (Figure& f : figures) f.name += "_" + scenario, f.title = scenario + ": " + f.title;
  return figures;
}

}  // namespace

std::vector<std::pair<std::string, std::vector<Figure>>> comparison_figures(
    const std::vector<RunData>& runs) {
  Runs all;
  for (const RunData& run : runs) all.push_back(&run);
  std::vector<std::pair<std::string, std::vector<Figure>>> scenarios;
  for (const auto& [scenario, its_runs] : grouped(all, &RunData::scenario))
    scenarios.emplace_back(
        scenario, its_runs.size() > 1 ? scenario_figures(scenario, its_runs) : std::vector<Figure>{});
  return scenarios;
}

}  // namespace sim::pages
