#include "sim/report/comparison_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "sim/report/run_figures.h"
#include "sim/report/units.h"
#include "sim/score/statistics.h"

namespace sim::report {
namespace {

using Runs = std::vector<const RunData*>;

std::string text_of(const RunData& run, const char* key, const char* otherwise) {
  return run.score.value(key, std::string(otherwise));
}
std::string scenario_of(const RunData& run) { return text_of(run, "scenario", "?"); }
std::string estimator_of(const RunData& run) { return text_of(run, "estimator", "filter"); }
double seed_of(const RunData& run) { return static_cast<double>(run.score.value("seed", std::uint64_t{0})); }

/// The runs by what of() says of them, in the order in which that first appears.
template <class Of>
std::vector<std::pair<std::string, Runs>> grouped(const Runs& runs, Of of) {
  std::vector<std::pair<std::string, Runs>> groups;
  for (const RunData* run : runs) {
    const std::string name = of(*run);
    auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& g) { return g.first == name; });
    if (group == groups.end()) group = groups.insert(groups.end(), {name, {}});
    group->second.push_back(run);
  }
  return groups;
}

/// There are as many colours; further estimators begin anew.
Role role_of(std::size_t estimator) {
  constexpr std::array kRoles{Role::estimate, Role::first, Role::second, Role::third};
  return kRoles[estimator % kRoles.size()];
}

Figure figure(const std::string& name, const std::string& scenario, const std::string& title, const char* x,
              const char* y) {
  Figure f{name + "_" + scenario, scenario + ": " + title, x, y};
  return f;
}

Figure paths(const std::string& scenario, const Runs& runs) {
  Figure f = figure("paths", scenario, "camera from above, first seed", "x [m]", "y [m]");
  f.equal_axes = true;
  const Path &plan = runs.front()->plan, &truth = runs.front()->truth;
  f.lines.push_back({"plan", Role::plan, plan.x, plan.y});
  f.lines.push_back({"truth", Role::truth, truth.x, truth.y});
  std::size_t number = 0;
  for (const auto& [estimator, of_it] : grouped(runs, estimator_of)) {
    const Role role = role_of(number++);
    if (const auto& estimate = of_it.front()->estimate)
      f.lines.push_back({estimator, role, estimate->x, estimate->y});
  }
  return f;
}

Line median_over_time(const std::string& name, Role role, const Runs& runs) {
  std::map<double, std::vector<double>> at;
  for (const RunData* run : runs)
    for (std::size_t i = 0; run->errors && i < run->errors->t.size(); ++i)
      at[run->errors->t[i]].push_back(kMm * run->errors->distance[i]);
  Line line{name, role};
  for (const auto& [t, values] : at) {
    line.x.push_back(t);
    line.y.push_back(score::median(values));
  }
  return line;
}

Figure errors_over_time(const std::string& scenario, const Runs& runs) {
  Figure f = figure("error_over_time", scenario, "position error, median over seeds", "time [s]", "mm");
  f.logarithmic = true;
  std::size_t number = 0;
  for (const auto& [estimator, of_it] : grouped(runs, estimator_of))
    f.lines.push_back(median_over_time(estimator, role_of(number++), of_it));
  return f;
}

/// A dot for each run, by its seed.
template <class Value>
Figure dots(Figure f, const Runs& runs, Value value) {
  std::size_t number = 0;
  for (const auto& [estimator, of_it] : grouped(runs, estimator_of)) {
    Line line{estimator, role_of(number++)};
    line.dots = true;
    for (const RunData* run : of_it)
      if (const std::optional<double> y = value(*run)) line.x.push_back(seed_of(*run)), line.y.push_back(*y);
    f.lines.push_back(std::move(line));
  }
  return f;
}

void add_scenario(const std::string& scenario, const Runs& runs, std::vector<Figure>& figures) {
  figures.push_back(paths(scenario, runs));
  figures.push_back(errors_over_time(scenario, runs));
  if (std::all_of(runs.begin(), runs.end(),
                  [&](const RunData* run) { return seed_of(*run) == seed_of(*runs.front()); }))
    return;
  Figure ate = figure("ate_by_seed", scenario, "ATE after SE(3) alignment of every run", "seed", "mm");
  ate.logarithmic = true;
  figures.push_back(dots(std::move(ate), runs, [](const RunData& run) -> std::optional<double> {
    const auto value = run.metric("ate_se3_rmse_m");
    return value ? std::optional(kMm * *value) : std::nullopt;
  }));
  Figure cpu = figure("cpu_by_seed", scenario, "CPU time of a frame (median) of every run", "seed", "ms");
  cpu.logarithmic = true;
  figures.push_back(dots(std::move(cpu), runs, [](const RunData& run) { return run.frame_cpu_ms_median; }));
}

}  // namespace

std::vector<Figure> comparison_figures(const std::vector<RunData>& runs) {
  Runs all;
  for (const RunData& run : runs) all.push_back(&run);
  const auto scenarios = grouped(all, scenario_of);
  if (scenarios.size() < 2 && grouped(all, estimator_of).size() < 2) return batch_figures(runs);
  std::vector<Figure> figures;
  for (const auto& [scenario, of_it] : scenarios)
    if (of_it.size() > 1) add_scenario(scenario, of_it, figures);
  return figures;
}

}  // namespace sim::report
