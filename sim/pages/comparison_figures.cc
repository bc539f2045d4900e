#include "sim/pages/comparison_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "sim/pages/run_figures.h"
#include "sim/pages/units.h"
#include "sim/score/statistics.h"

namespace sim::pages {
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

/// A box of the runs of each estimator.
template <class Value>
Figure boxes(Figure f, const Runs& runs, Value value) {
  std::size_t number = 0;
  for (const auto& [estimator, of_it] : grouped(runs, estimator_of)) {
    Box box{estimator, role_of(number++)};
    for (const RunData* run : of_it)
      if (const std::optional<double> y = value(*run)) box.values.push_back(*y);
    f.boxes.push_back(std::move(box));
  }
  return f;
}

std::optional<double> ate_mm(const RunData& run) {
  const auto value = run.metric("ate_se3_rmse_m");
  return value ? std::optional(kMm * *value) : std::nullopt;
}

/// Over the seeds: ATE and CPU time, as boxes of each estimator and as dots by seed.
void add_seeds(const std::string& scenario, const Runs& runs, std::vector<Figure>& figures) {
  constexpr const char* kBoxes = "quartiles over seeds, a dot for each run";
  Figure ates = figure("ate_boxes", scenario, fmt::format("ATE after SE(3) alignment, {}", kBoxes), "", "mm");
  ates.logarithmic = true;
  figures.push_back(boxes(std::move(ates), runs, ate_mm));
  const auto cpu_ms = [](const RunData& run) { return run.frame_cpu_ms_median; };
  Figure costs =
      figure("cpu_boxes", scenario, fmt::format("CPU time of a frame (median), {}", kBoxes), "", "ms");
  costs.logarithmic = true;
  figures.push_back(boxes(std::move(costs), runs, cpu_ms));
  Figure ate = figure("ate_by_seed", scenario, "ATE after SE(3) alignment of every run", "seed", "mm");
  ate.logarithmic = ate.whole_x = true;
  figures.push_back(dots(std::move(ate), runs, ate_mm));
  Figure cpu = figure("cpu_by_seed", scenario, "CPU time of a frame (median) of every run", "seed", "ms");
  cpu.logarithmic = cpu.whole_x = true;
  figures.push_back(dots(std::move(cpu), runs, cpu_ms));
}

std::vector<Figure> scenario_figures(const std::string& scenario, const Runs& runs) {
  std::vector<Figure> figures{paths(scenario, runs), errors_over_time(scenario, runs)};
  const auto same_seed = [&](const RunData* run) { return seed_of(*run) == seed_of(*runs.front()); };
  if (!std::all_of(runs.begin(), runs.end(), same_seed)) add_seeds(scenario, runs, figures);
  for (Figure& f : figures)
    for (const RunData* run : runs) f.runs.push_back(run->folder.string());
  return figures;
}

}  // namespace

std::vector<Figure> comparison_figures(const std::vector<RunData>& runs) {
  Runs all;
  for (const RunData& run : runs) all.push_back(&run);
  const auto scenarios = grouped(all, scenario_of);
  if (scenarios.size() < 2 && grouped(all, estimator_of).size() < 2) return batch_figures(runs);
  std::vector<Figure> figures;
  for (const auto& [scenario, of_it] : scenarios) {
    if (of_it.size() < 2) continue;
    const std::vector<Figure> more = scenario_figures(scenario, of_it);
    figures.insert(figures.end(), more.begin(), more.end());
  }
  return figures;
}

}  // namespace sim::pages
