#include "sim/pages/run_figures.h"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "sim/files/number.h"
#include "sim/pages/units.h"
#include "sim/score/consistency.h"
#include "sim/score/run.h"
#include "sim/score/statistics.h"

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
  Figure f{"nees", "Normalised error squared (3 expected; 95 % of a run's frames between the lines)", kTime,
           "NEES"};
  f.logarithmic = true;
  f.lines.push_back(line("position", Role::first, e.t, e.nees_position));
  f.lines.push_back(line("orientation", Role::second, e.t, e.nees_orientation));
  f.levels = {{"2.5 %", score::chi_square_quantile(0.025, 3)},
              {"97.5 %", score::chi_square_quantile(0.975, 3)}};
  return f;
}

// The moving mean over a second takes the flicker out of single frames.
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
           "Normalised innovation squared by degrees of freedom, mean over 1 s (1 expected; 95 % between the "
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

// Dots at the begin of each row of feet.csv of a phase: how far (or how much about the vertical) the foot
// moved.
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
  Figure slip{"slip", "Slip, step by step: how far a sole moved on the ground", kTime, "mm"};
  Figure turn{"slip_turn", "Slip, step by step: how much a sole turned on the ground", kTime, "deg"};
  for (Figure* f : {&slip, &turn})
    for (const auto& [phase, name, role] : {std::tuple{"landing", "landing", Role::first},
                                            std::tuple{"support", "carrying the robot", Role::estimate},
                                            std::tuple{"lift_off", "lifting off", Role::second}})
      f->lines.push_back(feet_moved(feet, phase, name, role, f == &turn));
  Figure landing{"landing", "How far beside its planned place a foot was put down", kTime, "mm"};
  landing.lines = {feet_moved(feet, "put_down", "foot", Role::plan, false)};
  figures.insert(figures.end(), {slip, turn, landing});
}

// Ten seconds around the closing of the loop.
std::optional<Figure> closure(const RunData& run) {
  const auto time = run.metric("loop_time_s");
  if (!time || !run.errors) return std::nullopt;
  Figure f{"closure", "Position error around the closing of the loop", kTime, "mm"};
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

Figure error_over_seeds(const std::map<double, Column>& at) {
  Figure f{"error_over_seeds", "Position error over seeds: minimum, median and maximum", kTime, "mm"};
  Line median = line("median", Role::estimate, {}, {});
  Envelope spread{"minimum to maximum", Role::estimate, {}, {}, {}};
  for (const auto& [t, values] : at) {
    median.x.push_back(t), spread.x.push_back(t);
    median.y.push_back(score::quantile(values, 0.5));
    spread.low.push_back(score::quantile(values, 0));
    spread.high.push_back(score::quantile(values, 1));
  }
  f.lines = {median};
  f.envelopes = {spread};
  return f;
}

// By time, one NEES of each run.
using Moments = std::map<double, Column>;

Moments moments(const std::vector<RunData>& runs, Column Errors::*nees) {
  Moments all;
  for (const RunData& run : runs)
    for (std::size_t i = 0; run.errors && i < run.errors->t.size(); ++i)
      if (const double value = ((*run.errors).*nees)[i]; std::isfinite(value))
        all[run.errors->t[i]].push_back(value);
  return all;
}

Line mean_line(const std::string& name, Role role, const Moments& moments) {
  Line means{name, role};
  for (const auto& [t, values] : moments) {
    means.x.push_back(t);
    means.y.push_back(score::mean(values));
  }
  return means;
}

std::string share_text(const Moments& moments) {
  std::vector<Column> settled;
  for (auto at = moments.lower_bound(score::kSettled_s); at != moments.end(); ++at)
    settled.push_back(at->second);
  const auto share = score::band_fractions(settled, 3);
  return share ? fmt::format("{:.0f} % (below it {:.0f} %)", 100 * share->inside, 100 * share->below)
               : "none";
}

Figure nees_over_seeds(const std::vector<RunData>& runs) {
  const Moments position = moments(runs, &Errors::nees_position),
                orientation = moments(runs, &Errors::nees_orientation);
  std::size_t most = 0;
  for (const auto& [t, values] : position) most = std::max(most, values.size());
  Figure f{"nees_over_seeds",
           fmt::format("Normalised error squared, mean of {} (3 expected)", files::counted(most, "run")),
           kTime, "mean NEES"};
  f.logarithmic = true;
  f.lines = {mean_line("position", Role::first, position),
             mean_line("orientation", Role::second, orientation)};
  if (most < 2) return f;  // one run has no band
  f.title += fmt::format(". Frames after {:.0f} s that are within the 95 % band: position {}, orientation {}",
                         score::kSettled_s, share_text(position), share_text(orientation));
  const score::Band band = score::mean_band(3, static_cast<int>(most));
  f.levels = {{"2.5 %", band.low}, {"97.5 %", band.high}};
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

// So that the longest arrow is a quarter of the walk's extent at most.
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

// From where each foot would have landed, by the estimate, to where it was sent; both barbs of the head are a
// quarter as long. Drawn larger, since corrections are some mm, by a factor that the legend names.
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
  if (run.frames && run.errors) {
    figures.push_back(nis(*run.frames));
    figures.push_back(matches(*run.frames));
  }
  if (const auto around = closure(run)) figures.push_back(*around);
  if (run.corrected_steps && run.corrected_steps->rows() > 0) add_corrections(figures, *run.corrected_steps);
  if (run.feet && run.feet->rows() > 0) add_slip(figures, *run.feet);
  if (run.frame_times && run.errors) figures.push_back(cpu(*run.frame_times));
  if (run.frame_times && run.frames && run.errors)
    figures.push_back(cpu_by_map(*run.frame_times, *run.frames));
  return figures;
}

std::vector<Figure> of_runs(std::vector<Figure> figures, const std::vector<RunData>& runs) {
  for (Figure& figure : figures)
    for (const RunData& run : runs) figure.runs.push_back(run.folder.string());
  return figures;
}

std::vector<Figure> batch_figures(const std::vector<RunData>& runs) {
  std::map<double, Column> at;
  Figure walks{"walks", "Where the walks led: truth of every run", "x [m]", "y [m]"};
  walks.equal_axes = true;
  for (const RunData& run : runs) {
    const bool first = walks.lines.empty();  // one name for all
    walks.lines.push_back(line(first ? "truth" : "", Role::truth, run.waist_truth.x, run.waist_truth.y));
    if (!run.errors) continue;
    for (std::size_t i = 0; i < run.errors->t.size(); ++i)
      at[run.errors->t[i]].push_back(kMm * run.errors->distance[i]);
  }
  if (runs.size() < 2) return {};
  walks.lines.push_back(line("plan", Role::plan, runs[0].waist_plan.x, runs[0].waist_plan.y));
  std::vector<Figure> figures{walks};
  const auto scored = std::count_if(runs.begin(), runs.end(), [](const RunData& r) { return !!r.errors; });
  if (scored < 2) return of_runs(figures, runs);
  figures.push_back(error_over_seeds(at));
  if (const Figure nees = nees_over_seeds(runs); !nees.lines[0].x.empty()) figures.push_back(nees);
  return of_runs(figures, runs);
}

}  // namespace sim::pages
