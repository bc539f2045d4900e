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

Figure error(const char* name, const char* title, const std::string& unit, const Column& t,
             const Column& value, const Column& sigma, double factor) {
  Figure f{name, title, kTime, "estimate minus truth [" + unit + "]"};
  const Column three = scaled(sigma, 3 * factor);
  if (any_finite(three)) f.envelopes = {{"3 sigma", Role::estimate, t, scaled(three, -1), three}};
  f.lines = {{"error", Role::estimate, t, scaled(value, factor)}};
  f.levels = {{"none", 0}};
  return f;
}

void add_errors(std::vector<Figure>& figures, const Errors& e) {
  figures.insert(figures.end(), {error("error_x", "Position error in x", "mm", e.t, e.x, e.sigma_x, kMm),
                                 error("error_y", "Position error in y", "mm", e.t, e.y, e.sigma_y, kMm),
                                 error("error_z", "Position error in z", "mm", e.t, e.z, e.sigma_z, kMm),
                                 error("error_yaw", "Heading error", "deg", e.t, e.yaw, e.sigma_yaw, kDeg)});
  if (!any_finite(e.nees_position)) return;
  Figure nees{"nees", "Normalized error squared (3 expected; 95 % of a run's frames between the lines)",
              kTime, "NEES"};
  nees.logarithmic = true;
  nees.lines = {{"position", Role::first, e.t, e.nees_position},
                {"orientation", Role::second, e.t, e.nees_orientation}};
  nees.levels = {{"2.5 %", score::chi_square_quantile(0.025, 3)},
                 {"97.5 %", score::chi_square_quantile(0.975, 3)}};
  figures.push_back(nees);
}

// NIS by degrees of freedom, as the moving mean over a second.
Column smoothed_nis(const Table& frames, const std::string& sensor) {
  const Column nis = frames.numbers("nis_" + sensor), dof = frames.numbers("dof_" + sensor);
  Column out;
  const int last = static_cast<int>(nis.size()) - 1;
  for (int i = 0; i <= last; ++i) {
    double sum = 0;
    int count = 0;
    for (int k = std::max(0, i - kHalfSecond); k <= std::min(i + kHalfSecond, last); ++k)
      if (dof[k] > 0 && std::isfinite(nis[k])) sum += nis[k] / dof[k], ++count;
    out.push_back(count > 0 ? sum / count : NAN);
  }
  return out;
}

void add_filter(std::vector<Figure>& figures, const Table& frames) {
  const Column t = frames.seconds("timestamp");
  Figure nis{
      "nis",
      "Normalized innovation squared by degrees of freedom, mean over 1 s (1 expected; 95 % between the "
      "lines for three rows)",
      kTime, "NIS / dof"};
  nis.logarithmic = true;
  constexpr std::array kRoles{Role::estimate, Role::first, Role::plan, Role::second};
  static_assert(kRoles.size() == score::kSensors.size());
  for (std::size_t i = 0; i < kRoles.size(); ++i) {
    const std::string sensor(score::kSensors[i]);
    if (frames.has("nis_" + sensor))
      nis.lines.push_back({sensor == "plan_velocity" ? "velocity by legs or plan" : sensor, kRoles[i], t,
                           smoothed_nis(frames, sensor)});
  }
  const double rows = 3.0 * (2 * kHalfSecond + 1);  // of a sensor with three of them
  nis.levels = {{"expected", 1},
                {"2.5 % of three rows", score::chi_square_quantile(0.025, rows) / rows},
                {"97.5 % of three rows", score::chi_square_quantile(0.975, rows) / rows}};
  Figure matches{"matches", "Landmarks in the map, searched for and accepted", kTime, "count"};
  matches.whole_y = true;
  matches.lines = {{"in the map", Role::truth, t, frames.numbers("landmarks")},
                   {"measured", Role::first, t, frames.numbers("measured")},
                   {"accepted", Role::estimate, t, frames.numbers("accepted")}};
  figures.insert(figures.end(), {nis, matches});
}

void add_cpu(std::vector<Figure>& figures, const Table& times, const std::optional<Table>& frames) {
  const Column ms = times.numbers("filter");
  figures.push_back({"cpu", "CPU of the filter per frame", kTime, "ms"});
  figures.back().lines = {{"filter", Role::estimate, times.seconds("timestamp"), ms}};
  if (!frames) return;
  Column size = frames->numbers("landmarks");
  size.resize(ms.size(), NAN);
  figures.push_back({"cpu_by_map", "CPU of the filter by size of the map", "landmarks in the map", "ms"});
  figures.back().whole_x = true;
  figures.back().lines = {{"a frame", Role::estimate, size, ms, true}};
}

// A dot at the start of each row of feet.csv in a phase: how far the foot moved or how much it turned.
Line feet_moved(const Table& feet, const std::string& phase, const std::string& name, Role role,
                bool turning) {
  const Column t = feet.seconds("begin"), x = feet.numbers("moved_x"), y = feet.numbers("moved_y"),
               yaw = feet.numbers("moved_yaw");
  Line dots{name, role, {}, {}, true};
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
void add_closure(std::vector<Figure>& figures, const Errors& e, double time) {
  Figure f{"closure", "Position error around the loop closure", kTime, "mm"};
  Line distance{"error", Role::estimate}, sigma{"3 sigma", Role::first};
  for (std::size_t i = 0; i < e.t.size(); ++i) {
    if (std::abs(e.t[i] - time) > 5) continue;
    distance.x.push_back(e.t[i]), sigma.x.push_back(e.t[i]);
    distance.y.push_back(kMm * e.distance[i]);
    sigma.y.push_back(3 * kMm * std::hypot(e.sigma_x[i], e.sigma_y[i], e.sigma_z[i]));
  }
  f.lines = {sigma, distance};
  f.moments = {{"loop closed", time}};
  figures.push_back(f);
}

// 1, 2 or 5 times a power of ten, at least 1.
double round_factor(double rough) {
  if (!(rough > 1)) return 1;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  return (rough >= 5 * power ? 5 : rough >= 2 * power ? 2 : 1) * power;
}

// Arrows from the expected landing of each foot to the corrected one. The factor in the legend enlarges them
// so that the longest is below a quarter of the extent of the walk.
Line correction_arrows(const Table& steps) {
  const Column x = steps.numbers("expected_x"), y = steps.numbers("expected_y"),
               yaw = steps.numbers("expected_yaw"), ahead = steps.numbers("ahead"),
               aside = steps.numbers("aside");
  Eigen::AlignedBox2d extent;
  double longest = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    extent.extend(Eigen::Vector2d(x[i], y[i]));
    longest = std::max(longest, std::hypot(ahead[i], aside[i]));
  }
  const double larger = longest > 0 ? round_factor(0.25 * extent.sizes().maxCoeff() / longest) : 1;
  Line arrows{larger > 1 ? fmt::format("corrections, {:.0f} times as large", larger) : "corrections",
              Role::second};
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Eigen::Vector2d from(x[i], y[i]);
    const Eigen::Vector2d way = larger * (Eigen::Rotation2Dd(yaw[i]) * Eigen::Vector2d(ahead[i], aside[i]));
    const Eigen::Vector2d tip = from + way, left = tip + Eigen::Rotation2Dd(2.6) * way / 4,
                          right = tip + Eigen::Rotation2Dd(-2.6) * way / 4;
    for (const Eigen::Vector2d& p : {from, tip, left, tip, right, Eigen::Vector2d(NAN, NAN)})
      arrows.x.push_back(p.x()), arrows.y.push_back(p.y());
  }
  return arrows;
}

void add_corrections(std::vector<Figure>& figures, const Table& steps) {
  const Column t = steps.seconds("time");
  Figure moved{"corrections", "Corrections of footsteps", kTime, "moved [mm]"},
      turned{"corrected_turns", "Corrections of the footsteps' heading", kTime, "turned [deg]"};
  moved.lines = {{"ahead", Role::first, t, scaled(steps.numbers("ahead"), kMm), true},
                 {"aside", Role::second, t, scaled(steps.numbers("aside"), kMm), true}};
  turned.lines = {{"turn", Role::first, t, scaled(steps.numbers("turn"), kDeg), true}};
  figures.insert(figures.end(), {moved, turned});
}

}  // namespace

Figure camera_from_above(const RunData& run) {
  Figure f{"from_above", "Camera from above", "x [m]", "y [m]"};
  f.equal_axes = true;
  f.lines = {{"plan", Role::plan, run.plan.x, run.plan.y}, {"truth", Role::truth, run.truth.x, run.truth.y}};
  if (run.estimate) f.lines.push_back({"estimate", Role::estimate, run.estimate->x, run.estimate->y});
  return f;
}

Figure waist_from_above(const RunData& run) {
  Figure f{"waist_from_above", "Waist from above: planned and walked", "x [m]", "y [m]"};
  f.equal_axes = true;
  f.lines = {{"plan", Role::plan, run.waist_plan.x, run.waist_plan.y},
             {"truth", Role::truth, run.waist_truth.x, run.waist_truth.y}};
  if (run.waist_desired)
    f.lines.push_back({"desired", Role::first, run.waist_desired->x, run.waist_desired->y});
  if (run.waist_estimate)
    f.lines.push_back({"estimate", Role::estimate, run.waist_estimate->x, run.waist_estimate->y});
  if (run.corrected_steps) f.lines.push_back(correction_arrows(*run.corrected_steps));
  return f;
}

Figure camera_height(const RunData& run) {
  Figure f{"height", "Camera height", kTime, "z [m]"};
  f.lines = {{"plan", Role::plan, run.plan.t, run.plan.z}, {"truth", Role::truth, run.truth.t, run.truth.z}};
  if (run.estimate) f.lines.push_back({"estimate", Role::estimate, run.estimate->t, run.estimate->z});
  return f;
}

std::vector<Figure> run_figures(const RunData& run) {
  std::vector<Figure> figures{camera_from_above(run), waist_from_above(run), camera_height(run)};
  if (run.errors) {
    add_errors(figures, *run.errors);
    if (run.filter_frames) add_filter(figures, *run.filter_frames);
    if (const auto time = run.metric("loop_time_s")) add_closure(figures, *run.errors, *time);
  }
  if (run.corrected_steps && run.corrected_steps->rows() > 0) add_corrections(figures, *run.corrected_steps);
  if (run.feet && run.feet->rows() > 0) add_slip(figures, *run.feet);
  if (run.frame_times && run.errors) add_cpu(figures, *run.frame_times, run.filter_frames);
  return figures;
}

}  // namespace sim::pages
