#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/pages/pages.h"
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
  return std::ranges::any_of(values, [](double value) { return std::isfinite(value); });
}

void add_errors(std::vector<Figure>& figures, const RunData& run) {
  const Errors& e = *run.errors;
  Figure distance{"error_distance", "Position error", kTime, "distance from the truth [mm]"};
  distance.logarithmic = true;
  distance.lines = {{"estimate", Role::estimate, e.t, scaled(e.distance, kMm)}};
  if (run.odometry)
    distance.lines.push_back(
        {kOdometryName, Role::third, run.odometry->t, scaled(run.odometry_error, kMm), false, true});
  figures.push_back(distance);
  constexpr std::array kAxes{"x", "y", "z", "yaw"};
  for (std::size_t i = 0; i < kAxes.size(); ++i) {
    const bool turning = i == 3;
    const double factor = turning ? kDeg : kMm;
    Figure f{std::string("error_") + kAxes[i],
             turning ? "Heading error" : std::string("Position error in ") + kAxes[i], kTime,
             turning ? "estimate minus truth [deg]" : "estimate minus truth [mm]"};
    const Column three = scaled(e.sigma[i], 3 * factor);
    if (any_finite(three)) f.envelopes = {{"3 sigma", Role::estimate, e.t, scaled(three, -1), three}};
    f.lines = {{"error", Role::estimate, e.t, scaled(e.error[i], factor)}};
    f.levels = {{"none", 0}};
    figures.push_back(f);
  }
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

void add_filter(std::vector<Figure>& figures, const RunData& run) {
  const Table& frames = *run.filter_frames;
  const Column t = frames.seconds("timestamp");
  Figure nis{
      "nis",
      "Normalized innovation squared by degrees of freedom, mean over 1 s (1 expected; gray: 95 % with three "
      "rows)",
      kTime, "NIS / dof"};
  nis.logarithmic = true;
  constexpr std::array kRoles{Role::estimate, Role::first, Role::plan, Role::second};
  static_assert(kRoles.size() == score::kSensors.size());
  for (std::size_t i = 0; i < kRoles.size(); ++i) {
    const std::string sensor(score::kSensors[i]);
    if (!frames.has("nis_" + sensor)) continue;
    const std::string name = sensor == "plan_velocity" ? "velocity by legs or plan" : sensor;
    nis.lines.push_back({name, kRoles[i], t, smoothed_nis(frames, sensor)});
    if (const auto mean = run.value("nis_" + sensor + "_mean"))
      nis.remarks.push_back(fmt::format("{} {:.2g}: {}", name, *mean, score::nis_verdict(*mean)));
  }
  const score::Band band = score::mean_band(3, 2 * kHalfSecond + 1);  // of a sensor with three rows
  nis.envelopes = {{"95 %", Role::truth, t, Column(t.size(), band.low / 3), Column(t.size(), band.high / 3)}};
  nis.levels = {{"expected", 1}};
  Figure matches{"matches", "Landmarks in the map, searched for and accepted", kTime, "count"};
  matches.whole_y = true;
  matches.lines = {{"in the map", Role::truth, t, frames.numbers("landmarks")},
                   {"measured", Role::first, t, frames.numbers("measured")},
                   {"accepted", Role::estimate, t, frames.numbers("accepted")}};
  figures.insert(figures.end(), {nis, matches});
}

/// A dot at the start of each row of feet.csv in a phase: how far the foot moved or how much it turned.
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
  for (const bool turning : {false, true})
    figures.push_back({turning ? "slip_turn" : "slip",
                       turning ? "Slip of each step: angle that a sole turned on the ground"
                               : "Slip of each step: distance that a sole moved on the ground",
                       kTime,
                       turning ? "deg" : "mm",
                       {feet_moved(feet, "landing", "landing", Role::first, turning),
                        feet_moved(feet, "support", "carrying the robot", Role::estimate, turning),
                        feet_moved(feet, "lift_off", "lifting off", Role::second, turning)}});
}

void add_corrections(std::vector<Figure>& figures, const Table& steps) {
  const Column t = steps.seconds("time");
  figures.push_back({"corrections", "Corrections of footsteps", kTime, "moved [mm]"});
  figures.back().lines = {{"ahead", Role::first, t, scaled(steps.numbers("ahead"), kMm), true},
                          {"aside", Role::second, t, scaled(steps.numbers("aside"), kMm), true}};
}

void add_latency(std::vector<Figure>& figures, const Table& answers) {
  const Column t = answers.seconds("timestamp"), effect = answers.seconds("effect");
  Line answered{"answered", Role::estimate, {}, {}, true}, dropped{"dropped", Role::second, {}, {}, true};
  for (std::size_t i = 0; i < t.size(); ++i) {
    const bool is_dropped = std::isnan(effect[i]);
    Line& line = is_dropped ? dropped : answered;
    line.x.push_back(t[i]), line.y.push_back(is_dropped ? 0 : 1e3 * (effect[i] - t[i]));
  }
  figures.push_back({"latency", "Latency of each answer, and dropped frames (at 0)", kTime, "ms"});
  figures.back().lines = {answered, dropped};
}

Figure from_above(const char* name, const char* title, const Path& plan, const Path& truth) {
  Figure f{name, title, "x [m]", "y [m]"};
  f.equal_axes = true;
  f.lines = {{"plan", Role::plan, plan.x, plan.y}, {"truth", Role::truth, truth.x, truth.y}};
  return f;
}

}  // namespace

Figure camera_from_above(const RunData& run) {
  Figure f = from_above("from_above", "Camera from above", run.plan, run.truth);
  if (run.odometry)
    f.lines.push_back({kOdometryName, Role::third, run.odometry->x, run.odometry->y, false, true});
  if (run.estimate) f.lines.push_back({"estimate", Role::estimate, run.estimate->x, run.estimate->y});
  return f;
}

Figure waist_from_above(const RunData& run) {
  Figure f =
      from_above("waist_from_above", "Waist from above: planned and walked", run.waist_plan, run.waist_truth);
  if (run.waist_desired)
    f.lines.push_back({"desired", Role::first, run.waist_desired->x, run.waist_desired->y});
  if (run.waist_estimate)
    f.lines.push_back({"estimate", Role::estimate, run.waist_estimate->x, run.waist_estimate->y});
  return f;
}

Figure camera_height(const RunData& run) {
  Figure f{"height", "Camera height", kTime, "z [m]"};
  f.lines = {{"plan", Role::plan, run.plan.t, run.plan.z}, {"truth", Role::truth, run.truth.t, run.truth.z}};
  if (run.estimate) f.lines.push_back({"estimate", Role::estimate, run.estimate->t, run.estimate->z});
  return f;
}

Figure uncertainty(const RunData& run, double around_s) {
  Figure f{"closure", "Position error around the loop closure", kTime, "mm"};
  if (!run.errors) return f;
  const Errors& e = *run.errors;
  const auto closed = run.value("loop_time_s");
  if (closed) f.moments = {{"loop closed", *closed}};
  Line error{"error", Role::estimate}, sigma{"3 sigma", Role::first};
  for (std::size_t i = 0; i < e.t.size(); ++i) {
    if (closed && std::abs(e.t[i] - *closed) > around_s) continue;
    error.x.push_back(e.t[i]), error.y.push_back(kMm * e.distance[i]);
    sigma.x.push_back(e.t[i]);
    sigma.y.push_back(3 * kMm * std::hypot(e.sigma[0][i], e.sigma[1][i], e.sigma[2][i]));
  }
  f.lines = {sigma, error};
  return f;
}

std::vector<Figure> run_figures(const RunData& run) {
  std::vector<Figure> figures{camera_from_above(run), waist_from_above(run), camera_height(run)};
  if (run.errors) {
    add_errors(figures, run);
    if (run.filter_frames) add_filter(figures, run);
    if (run.value("loop_time_s")) figures.push_back(uncertainty(run, 5));
  }
  if (run.corrected_steps && run.corrected_steps->rows() > 0) add_corrections(figures, *run.corrected_steps);
  if (run.feet && run.feet->rows() > 0) add_slip(figures, *run.feet);
  if (run.answers && run.answers->rows() > 0) add_latency(figures, *run.answers);
  if (run.frame_times && run.errors)
    figures.push_back({"cpu",
                       "CPU of the filter per frame",
                       kTime,
                       "ms",
                       {{"filter", Role::estimate, run.frame_times->seconds("timestamp"),
                         run.frame_times->numbers("filter")}}});
  return figures;
}

}  // namespace sim::pages
