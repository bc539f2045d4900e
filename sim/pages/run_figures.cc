#include "sim/pages/run_figures.h"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "sim/score/consistency.h"
#include "sim/score/run.h"

namespace sim::pages {
namespace {

constexpr int kHalfSecond = 15;  // frames
constexpr const char* kTime = "time [s]";

Column scaled(Column values, double factor) {
  for (double& value : values) value *= factor;
  return values;
}

bool any_finite(const Column& values) {
  return std::any_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

Line line(const std::string& name, Role role, const Column& x, const Column& y) { return {name, role, x, y}; }

Figure error(const std::string& name, const std::string& title, const std::string& unit, const Column& t,
             const Column& value, const Column& sigma, double factor) {
  Figure f{name, title, kTime, "estimate minus truth [" + unit + "]"};
  const Column three = scaled(sigma, 3 * factor);
  if (any_finite(three)) f.envelopes.push_back({"3 sigma", Role::estimate, t, scaled(three, -1), three});
  f.lines.push_back(line("error", Role::estimate, t, scaled(value, factor)));
  f.levels.push_back({"none", 0});
  return f;
}

void add_errors(std::vector<Figure>& figures, const Errors& e) {
  figures.push_back(error("error_x", "Position error in x", "mm", e.t, e.x, e.sigma_x, kMm));
  figures.push_back(error("error_y", "Position error in y", "mm", e.t, e.y, e.sigma_y, kMm));
  figures.push_back(error("error_z", "Position error in z", "mm", e.t, e.z, e.sigma_z, kMm));
  figures.push_back(error("error_yaw", "Heading error", "deg", e.t, e.yaw, e.sigma_yaw, kDeg));
}

Figure nees(const Errors& e) {
  Figure f{"nees", "Normalized error squared (3 expected; 95 % of a run's frames between the lines)", kTime,
           "NEES"};
  f.logarithmic = true;
  f.lines.push_back(line("position", Role::first, e.t, e.nees_position));
  f.lines.push_back(line("orientation", Role::second, e.t, e.nees_orientation));
  f.levels = {{"2.5 %", score::chi_square_quantile(0.025, 3)},
              {"97.5 %", score::chi_square_quantile(0.975, 3)}};
  return f;
}

// Moving mean over a second.
Column smoothed(const Column& values, int half) {
  Column out;
  for (int i = 0; i < static_cast<int>(values.size()); ++i) {
    double sum = 0;
    int count = 0;
    for (int k = std::max(0, i - half); k <= std::min<int>(i + half, static_cast<int>(values.size()) - 1);
         ++k) {
      if (!std::isfinite(values[k])) continue;
      sum += values[k];
      ++count;
    }
    out.push_back(count > 0 ? sum / count : NAN);
  }
  return out;
}

Column ratio(const Table& frames, const std::string& sensor) {
  const Column nis = frames.numbers("nis_" + sensor), dof = frames.numbers("dof_" + sensor);
  Column out;
  for (std::size_t i = 0; i < nis.size(); ++i) out.push_back(dof[i] > 0 ? nis[i] / dof[i] : NAN);
  return smoothed(out, kHalfSecond);
}

Figure nis(const Table& frames) {
  Figure f{"nis",
           "Normalized innovation squared by degrees of freedom, mean over 1 s (1 expected; 95 % between the "
           "lines for "
           "three rows)",
           kTime, "NIS / dof"};
  f.logarithmic = true;
  const Column t = frames.seconds("timestamp");
  constexpr std::array kRoles{Role::estimate, Role::first, Role::plan, Role::second};
  static_assert(kRoles.size() == score::kSensors.size());
  for (std::size_t i = 0; i < kRoles.size(); ++i) {
    const std::string sensor(score::kSensors[i]);
    if (!frames.has("nis_" + sensor)) continue;
    const std::string name = sensor == "plan_velocity" ? "velocity by legs or plan" : sensor;
    f.lines.push_back(line(name, kRoles[i], t, ratio(frames, sensor)));
  }
  const double rows = 3.0 * (2 * kHalfSecond + 1);  // of a sensor with three of them
  f.levels = {{"expected", 1},
              {"2.5 % of three rows", score::chi_square_quantile(0.025, rows) / rows},
              {"97.5 % of three rows", score::chi_square_quantile(0.975, rows) / rows}};
  return f;
}

Figure matches(const Table& frames) {
  Figure f{"matches", "Landmarks in the map, searched for and accepted", kTime, "count"};
  f.whole_y = true;
  const Column t = frames.seconds("timestamp");
  f.lines.push_back(line("in the map", Role::truth, t, frames.numbers("landmarks")));
  f.lines.push_back(line("measured", Role::first, t, frames.numbers("measured")));
  f.lines.push_back(line("accepted", Role::estimate, t, frames.numbers("accepted")));
  return f;
}

Figure cpu(const Table& times) {
  Figure f{"cpu", "CPU of the filter per frame", kTime, "ms"};
  f.lines.push_back(line("filter", Role::estimate, times.seconds("timestamp"), times.numbers("filter")));
  return f;
}

Figure cpu_by_map(const Table& times, const Table& frames) {
  Figure f{"cpu_by_map", "CPU of the filter by size of the map", "landmarks in the map", "ms"};
  f.whole_x = true;
  Column size = frames.numbers("landmarks"), ms = times.numbers("filter");
  const std::size_t count = std::min(size.size(), ms.size());
  size.resize(count), ms.resize(count);
  f.lines.push_back(line("a frame", Role::estimate, size, ms));
  f.lines.back().dots = true;
  return f;
}

// A dot at the start of each row of feet.csv in a phase: how far the foot moved or how much it turned.
Line feet_moved(const Table& feet, const std::string& phase, const std::string& name, Role role,
                bool turning) {
  const Column t = feet.seconds("begin"), x = feet.numbers("moved_x"), y = feet.numbers("moved_y"),
               yaw = feet.numbers("moved_yaw");
  Line dots{name, role};
  dots.dots = true;
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (feet.text("phase")[i] != phase) continue;
    dots.x.push_back(t[i]);
    dots.y.push_back(turning ? kDeg * yaw[i] : kMm * std::hypot(x[i], y[i]));
  }
  return dots;
}

void add_slip(std::vector<Figure>& figures, const Table& feet) {
  Figure slip{"slip", "Slip of each step: distance that a sole moved on the ground", kTime, "mm"};
  Figure turn{"slip_turn", "Slip of each step: angle that a sole turned on the ground", kTime, "deg"};
  for (Figure* f : {&slip, &turn})
    for (const auto& [phase, name, role] : {std::tuple{"landing", "landing", Role::first},
                                            std::tuple{"support", "carrying the robot", Role::estimate},
                                            std::tuple{"lift_off", "lifting off", Role::second}})
      f->lines.push_back(feet_moved(feet, phase, name, role, f == &turn));
  Figure landing{"landing", "Distance of each landing from its planned place", kTime, "mm"};
  landing.lines = {feet_moved(feet, "put_down", "foot", Role::plan, false)};
  figures.insert(figures.end(), {slip, turn, landing});
}

// Ten seconds around the loop closure.
std::optional<Figure> closure(const RunData& run) {
  const auto time = run.metric("loop_time_s");
  if (!time || !run.errors) return std::nullopt;
  Figure f{"closure", "Position error around the loop closure", kTime, "mm"};
  Line distance = line("error", Role::estimate, {}, {}), sigma = line("3 sigma", Role::first, {}, {});
  const Errors& e = *run.errors;
  for (std::size_t i = 0; i < e.t.size(); ++i) {
    if (std::abs(e.t[i] - *time) > 5) continue;
    distance.x.push_back(e.t[i]), sigma.x.push_back(e.t[i]);
    distance.y.push_back(kMm * e.distance[i]);
    sigma.y.push_back(3 * kMm * std::hypot(e.sigma_x[i], e.sigma_y[i], e.sigma_z[i]));
  }
  f.lines = {sigma, distance};
  f.moments = {{"loop closed", *time}};
  return f;
}

}  // namespace

Figure camera_from_above(const RunData& run) {
  Figure f{"from_above", "Camera from above", "x [m]", "y [m]"};
  f.equal_axes = true;
  f.lines.push_back(line("plan", Role::plan, run.plan.x, run.plan.y));
  f.lines.push_back(line("truth", Role::truth, run.truth.x, run.truth.y));
  if (run.estimate) f.lines.push_back(line("estimate", Role::estimate, run.estimate->x, run.estimate->y));
  return f;
}

// 1, 2 or 5 times a power of ten, at least 1.
double round_factor(double rough) {
  if (!(rough > 1)) return 1;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  return (rough >= 5 * power ? 5 : rough >= 2 * power ? 2 : 1) * power;
}

// Keeps the longest arrow below a quarter of the extent of the walk.
double arrow_factor(const Table& steps) {
  constexpr double kOfExtent = 0.25;
  const Column x = steps.numbers("expected_x"), y = steps.numbers("expected_y"),
               ahead = steps.numbers("ahead"), aside = steps.numbers("aside");
  double longest = 0;
  for (std::size_t i = 0; i < ahead.size(); ++i) longest = std::max(longest, std::hypot(ahead[i], aside[i]));
  if (x.empty() || longest == 0) return 1;
  const auto [left, right] = std::minmax_element(x.begin(), x.end());
  const auto [low, high] = std::minmax_element(y.begin(), y.end());
  return round_factor(kOfExtent * std::max(*right - *left, *high - *low) / longest);
}

// Arrows from the expected landing of each foot to the corrected one, enlarged by the factor in the legend.
Line correction_arrows(const Table& steps) {
  const double larger = arrow_factor(steps);
  Line arrows{larger > 1 ? fmt::format("corrections, {:.0f} times as large", larger) : "corrections",
              Role::second};
  const Column x = steps.numbers("expected_x"), y = steps.numbers("expected_y"),
               yaw = steps.numbers("expected_yaw"), ahead = steps.numbers("ahead"),
               aside = steps.numbers("aside");
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Eigen::Vector2d from(x[i], y[i]);
    const Eigen::Vector2d way = larger * (Eigen::Rotation2Dd(yaw[i]) * Eigen::Vector2d(ahead[i], aside[i]));
    const Eigen::Vector2d tip = from + way;
    const Eigen::Vector2d left = tip + Eigen::Rotation2Dd(2.6) * way / 4,
                          right = tip + Eigen::Rotation2Dd(-2.6) * way / 4;
    for (const Eigen::Vector2d& p : {from, tip, left, tip, right, Eigen::Vector2d(NAN, NAN)}) {
      arrows.x.push_back(p.x());
      arrows.y.push_back(p.y());
    }
  }
  return arrows;
}

Figure waist_from_above(const RunData& run) {
  Figure f{"waist_from_above", "Waist from above: planned and walked", "x [m]", "y [m]"};
  f.equal_axes = true;
  f.lines.push_back(line("plan", Role::plan, run.waist_plan.x, run.waist_plan.y));
  f.lines.push_back(line("truth", Role::truth, run.waist_truth.x, run.waist_truth.y));
  if (run.waist_desired)
    f.lines.push_back(line("desired", Role::first, run.waist_desired->x, run.waist_desired->y));
  if (run.waist_estimate)
    f.lines.push_back(line("estimate", Role::estimate, run.waist_estimate->x, run.waist_estimate->y));
  if (run.corrected_steps) f.lines.push_back(correction_arrows(*run.corrected_steps));
  return f;
}

// How far and how much each step was corrected.
void add_corrections(std::vector<Figure>& figures, const Table& steps) {
  const Column t = steps.seconds("time");
  Figure moved{"corrections", "Corrections of footsteps", kTime, "moved [mm]"},
      turned{"corrected_turns", "Corrections of the footsteps' heading", kTime, "turned [deg]"};
  moved.lines = {line("ahead", Role::first, t, scaled(steps.numbers("ahead"), kMm)),
                 line("aside", Role::second, t, scaled(steps.numbers("aside"), kMm))};
  turned.lines = {line("turn", Role::first, t, scaled(steps.numbers("turn"), kDeg))};
  for (Figure* figure : {&moved, &turned})
    for (Line& values : figure->lines) values.dots = true;
  figures.insert(figures.end(), {moved, turned});
}

Figure camera_height(const RunData& run) {
  Figure f{"height", "Camera height", kTime, "z [m]"};
  f.lines.push_back(line("plan", Role::plan, run.plan.t, run.plan.z));
  f.lines.push_back(line("truth", Role::truth, run.truth.t, run.truth.z));
  if (run.estimate) f.lines.push_back(line("estimate", Role::estimate, run.estimate->t, run.estimate->z));
  return f;
}

std::vector<Figure> run_figures(const RunData& run) {
  std::vector<Figure> figures{camera_from_above(run), waist_from_above(run), camera_height(run)};
  if (run.errors) {
    add_errors(figures, *run.errors);
    if (any_finite(run.errors->nees_position)) figures.push_back(nees(*run.errors));
  }
  if (run.filter_frames && run.errors) {
    figures.push_back(nis(*run.filter_frames));
    figures.push_back(matches(*run.filter_frames));
  }
  if (const auto around = closure(run)) figures.push_back(*around);
  if (run.corrected_steps && run.corrected_steps->rows() > 0) add_corrections(figures, *run.corrected_steps);
  if (run.feet && run.feet->rows() > 0) add_slip(figures, *run.feet);
  if (run.frame_times && run.errors) figures.push_back(cpu(*run.frame_times));
  if (run.frame_times && run.filter_frames && run.errors)
    figures.push_back(cpu_by_map(*run.frame_times, *run.filter_frames));
  return figures;
}

}  // namespace sim::pages
