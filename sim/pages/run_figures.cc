// The figures of a run, and of several runs of a scenario.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "sim/files/text.h"
#include "sim/pages/pages.h"
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
  return std::ranges::any_of(values, [](double value) { return std::isfinite(value); });
}

void add_errors(std::vector<Figure>& figures, const RunData& run) {
  const Errors& e = *run.errors;
  Figure& distance =
      figures.emplace_back(Figure{"error_distance", "Position error", kTime, "distance from the truth [mm]"});
  distance.logarithmic = true;
  distance.lines = {{"estimate", Role::estimate, e.t, scaled(e.distance, kMm)}};
  if (run.odometry)
    distance.lines.push_back(
        {kOdometryName, Role::third, run.odometry->t, scaled(run.odometry_error, kMm), false, true});
  for (const auto& [i, name, title, unit, factor] :
       {std::tuple(0, "error_x", "Position error in x", "mm", kMm),
        {1, "error_y", "Position error in y", "mm", kMm},
        {2, "error_z", "Position error in z", "mm", kMm},
        {3, "error_yaw", "Heading error", "deg", kDeg}}) {
    Figure& f = figures.emplace_back(Figure{name,
                                            title,
                                            kTime,
                                            fmt::format("estimate minus truth [{}]", unit),
                                            {{"error", Role::estimate, e.t, scaled(e.error.at(i), factor)}}});
    const Column three = scaled(e.sigma.at(i), 3 * factor);
    if (any_finite(three)) f.envelopes = {{"3 sigma", Role::estimate, e.t, scaled(three, -1), three}};
    f.levels = {{"zero", 0}};
  }
  if (!any_finite(e.nees_position)) return;
  Figure& nees = figures.emplace_back(Figure{
      "nees", "Normalized error squared (3 expected; 95 % of the frames between the lines)", kTime, "NEES"});
  nees.logarithmic = true;
  nees.lines = {{"position", Role::first, e.t, e.nees_position},
                {"orientation", Role::second, e.t, e.nees_orientation}};
  nees.levels = {{"2.5 %", score::chi_square_quantile(0.025, 3)},
                 {"97.5 %", score::chi_square_quantile(0.975, 3)}};
}

// Returns the NIS divided by the degrees of freedom, as a moving mean over one second.
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
  Figure nis{"nis",
             "Normalized innovation squared per degree of freedom, mean over 1 s (1 expected; gray: 95 % "
             "for three degrees of freedom)",
             kTime, "NIS / dof"};
  nis.logarithmic = true;
  constexpr std::array kRoles{Role::estimate, Role::first, Role::plan, Role::second};
  static_assert(kRoles.size() == score::kSensors.size());
  for (std::size_t i = 0; i < kRoles.size(); ++i) {
    const std::string sensor(score::kSensors[i]);
    if (!frames.has("nis_" + sensor)) continue;
    nis.lines.push_back({sensor == "plan_velocity" ? "velocity from legs or plan" : sensor, kRoles[i], t,
                         smoothed_nis(frames, sensor)});
  }
  const score::Band band = score::mean_band(3, 2 * kHalfSecond + 1);  // for three degrees of freedom
  nis.envelopes = {{"95 %", Role::truth, t, Column(t.size(), band.low / 3), Column(t.size(), band.high / 3)}};
  nis.levels = {{"expected", 1}};
  figures.push_back(nis);
  figures.push_back({"matches",
                     "Landmarks in the map, searched for and accepted",
                     kTime,
                     "count",
                     {{"in the map", Role::truth, t, frames.numbers("landmarks")},
                      {"measured", Role::first, t, frames.numbers("measured")},
                      {"accepted", Role::estimate, t, frames.numbers("accepted")}}});
  figures.back().whole_y = true;
}

/// Returns a dot for each row of feet.csv in a phase, at its start: how far the foot moved or turned.
Line feet_moved(const Table& feet, const std::string& phase, const std::string& name, Role role,
                bool turning) {
  const Column t = feet.seconds("begin"), x = feet.numbers("moved_x"), y = feet.numbers("moved_y"),
               yaw = feet.numbers("moved_yaw");
  Line dots{name, role, {}, {}, true};
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (feet.text("phase")[i] != phase) continue;
    dots.add(t[i], turning ? kDeg * yaw[i] : kMm * std::hypot(x[i], y[i]));
  }
  return dots;
}

void add_slip(std::vector<Figure>& figures, const Table& feet) {
  for (const bool turning : {false, true}) {
    const char* const moved = turning ? "rotation of a sole" : "distance that a sole moved";
    figures.push_back({turning ? "slip_turn" : "slip",
                       fmt::format("Slip of each step: {} on the ground", moved),
                       kTime,
                       turning ? "deg" : "mm",
                       {feet_moved(feet, "landing", "landing", Role::first, turning),
                        feet_moved(feet, "support", "in support", Role::estimate, turning),
                        feet_moved(feet, "lift_off", "lifting off", Role::second, turning)}});
  }
}

void add_corrections(std::vector<Figure>& figures, const Table& steps) {
  const Column t = steps.seconds("time");
  figures.push_back({"corrections",
                     "Corrections of footsteps",
                     kTime,
                     "correction [mm]",
                     {{"ahead", Role::first, t, scaled(steps.numbers("ahead"), kMm), true},
                      {"to the side", Role::second, t, scaled(steps.numbers("aside"), kMm), true}}});
}

void add_latency(std::vector<Figure>& figures, const Table& answers) {
  const Column t = answers.seconds("timestamp"), effect = answers.seconds("effect");
  Line answered{"answered", Role::estimate, {}, {}, true}, dropped{"dropped", Role::second, {}, {}, true};
  for (std::size_t i = 0; i < t.size(); ++i) {
    const bool is_dropped = std::isnan(effect[i]);
    (is_dropped ? dropped : answered).add(t[i], is_dropped ? 0 : 1e3 * (effect[i] - t[i]));
  }
  figures.push_back(
      {"latency", "Latency of each answer, and dropped frames (at 0)", kTime, "ms", {answered, dropped}});
}

/// Removes lines that a run lacks, such as the plan's.
Figure with_points(Figure f) {
  std::erase_if(f.lines, [](const Line& line) { return line.x.empty(); });
  return f;
}

Figure from_above(const char* name, const char* title, const Path& plan, const Path& truth) {
  Figure f{name,
           title,
           "x [m]",
           "y [m]",
           {{"plan", Role::plan, plan.x, plan.y}, {"truth", Role::truth, truth.x, truth.y}}};
  f.equal_axes = true;
  return with_points(std::move(f));
}

void add_path(Figure& f, const std::string& name, Role role, const std::optional<Path>& path,
              bool thin = false) {
  if (path) f.lines.push_back({name, role, path->x, path->y, false, thin});
}

using Runs = std::vector<const RunData*>;
using OverTime = std::map<double, Column>;  // by time: a value from each run
using Groups = std::vector<std::pair<std::string, Runs>>;

/// Groups the runs by name, in the order of first appearance.
Groups grouped(const Runs& runs, const std::vector<std::string>& names) {
  Groups groups;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    auto group = std::ranges::find(groups, names[i], &Groups::value_type::first);
    if (group == groups.end()) group = groups.insert(groups.end(), {names[i], {}});
    group->second.push_back(runs[i]);
  }
  return groups;
}

Groups grouped(const Runs& runs, std::string RunData::*member) {
  std::vector<std::string> names;
  for (const RunData* run : runs) names.push_back(run->*member);
  return grouped(runs, names);
}

/// Returns the color of a variant; the fifth variant has the color of the first.
Role role_of(std::size_t variant) {
  constexpr std::array kRoles{Role::estimate, Role::first, Role::second, Role::third};
  return kRoles[variant % kRoles.size()];
}

/// Counts seeds instead of runs: runs with the same seed share walk and noise, so their errors are dependent.
std::size_t seeds_of(const Runs& runs) {
  std::set<std::uint64_t> seeds;
  for (const RunData* run : runs) seeds.insert(run->seed);
  return seeds.size();
}

/// Adds a column's values at their times; lines have gaps at non-finite values.
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
  for (const auto& [t, values] : at) line.add(t, values.empty() ? NAN : pool(values));
  return line;
}

/// True if one of the runs used the estimator odometry, which then has its own line.
bool have_odometry_run(const Runs& runs) {
  return std::ranges::any_of(runs, [](const RunData* run) { return run->estimator == "odometry"; });
}

Figure paths(const Runs& runs, const Groups& variants) {
  const RunData& first = *runs.front();
  Figure f = from_above("paths", "camera from above", first.plan, first.truth);
  if (seeds_of(runs) > 1) f.title += ", first seed";
  if (!have_odometry_run(runs)) add_path(f, kOdometryName, Role::third, first.odometry, true);
  for (std::size_t i = 0; i < variants.size(); ++i) {
    const RunData& run = *variants[i].second.front();
    const std::string alignment = run.alignment == "none" ? "" : fmt::format(" ({})", run.alignment);
    add_path(f, variants[i].first + alignment, role_of(i), run.estimate);
  }
  return f;
}

/// Returns the figure for runs with the same alignment: the medians and, if there is one variant, the whole
/// range.
Figure errors_over_time(const std::string& alignment, const Runs& runs, const Groups& variants) {
  Figure f{"error_over_time", "position error", "time [s]", "mm"};
  if (seeds_of(runs) > 1) f.title += ", median over seeds";
  if (alignment != "none") f.name += "_after_" + alignment, f.title += ", after " + alignment + " alignment";
  f.logarithmic = true;
  for (std::size_t i = 0; i < variants.size(); ++i) {
    const auto& [variant, its_runs] = variants[i];
    const OverTime at = over_time(its_runs, &Errors::distance, kMm);
    const auto quantile = [&, &name = variant](double q) {
      return pooled(name, role_of(i), at, [q](const Column& v) { return score::quantile(v, q); });
    };
    const Line median = f.lines.emplace_back(quantile(0.5));
    if (its_runs.size() > 1 && variants.size() == 1)
      f.envelopes = {{"minimum to maximum", median.role, median.x, quantile(0).y, quantile(1).y}};
  }
  OverTime blind;
  for (const RunData* run : runs)
    if (run->odometry) add_values(blind, run->odometry->t, run->odometry_error, kMm);
  if (!blind.empty() && alignment == "none" && !have_odometry_run(runs))
    f.lines.push_back(pooled(kOdometryName, Role::third, blind, score::median)), f.lines.back().thin = true;
  return f;
}

/// Draws a value of every run as a dot above the number of its setting, with a box plot: quartiles, median
/// and extremes.
Figure boxes(const char* name, const char* title, const char* unit, const Groups& variants,
             std::optional<double> (*value)(const RunData&)) {
  Figure f{name, title, "setting", unit};
  f.logarithmic = f.whole_x = true;
  for (std::size_t i = 0; i < variants.size(); ++i) {
    const double at = static_cast<double>(i + 1);
    Line dots{fmt::format("{}: {}", i + 1, variants[i].first), role_of(i), {}, {}, true};
    for (const RunData* run : variants[i].second)
      if (const std::optional<double> y = value(*run)) dots.add(at, *y);
    f.lines.push_back(dots);
    if (dots.y.size() < 2) continue;
    const auto q = [&](double p) { return score::quantile(dots.y, p); };
    const double left = at - 0.2, right = at + 0.2, low = q(0.25), high = q(0.75);
    f.lines.push_back({"",
                       dots.role,
                       {at, at, left, left, at, at, at, right, right, at, at, left, right},
                       {q(0), low, low, high, high, q(1), high, high, low, low, NAN, q(0.5), q(0.5)}});
  }
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

/// Returns the NEES over the seeds of one variant; nullopt if fewer than two have a NEES.
std::optional<Figure> nees_over_seeds(const Runs& runs) {
  const OverTime position = over_time(runs, &Errors::nees_position),
                 orientation = over_time(runs, &Errors::nees_orientation);
  std::size_t most = 0;
  for (const auto& [t, values] : position) most = std::max(most, values.size());
  if (most < 2) return std::nullopt;
  Figure f{"nees_over_seeds",
           fmt::format("normalized error squared, mean of {} (3 expected). Frames after {:.0f} s within the "
                       "95 % band: position {}, orientation {}",
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
  const Groups by_variant = grouped(runs, variants(runs));
  std::vector<Figure> figures{paths(runs, by_variant)};
  const Groups alignments = grouped(runs, &RunData::alignment);
  for (const auto& [alignment, its_runs] : alignments)
    figures.push_back(errors_over_time(alignment, its_runs, grouped(its_runs, variants(its_runs))));
  if (alignments.size() == 1 && by_variant.size() == 1 && seeds_of(runs) == runs.size())
    if (const auto nees = nees_over_seeds(runs)) figures.push_back(*nees);
  if (seeds_of(runs) > 1) {
    const auto ate_mm = [](const RunData& run) {
      const auto value = run.value("ate_se3_rmse_m");
      return value ? std::optional(kMm * *value) : std::nullopt;
    };
    figures.push_back(boxes("ate_by_setting",
                            "ATE after SE(3) alignment of every run; boxes: quartiles and median", "mm",
                            by_variant, ate_mm));
    figures.push_back(boxes("cpu_by_setting",
                            "Median CPU time per frame of every run; boxes: quartiles and median", "ms",
                            by_variant, [](const RunData& run) { return run.frame_cpu_ms_median; }));
  }
  for (Figure& f : figures) f.name += "_" + scenario, f.title = scenario + ": " + f.title;
  return figures;
}

}  // namespace

Figure camera_from_above(const RunData& run) {
  Figure f = from_above("from_above", "Camera from above", run.plan, run.truth);
  add_path(f, kOdometryName, Role::third, run.odometry, true);
  add_path(f, "estimate", Role::estimate, run.estimate);
  return f;
}

Figure map_from_above(const RunData& run) {
  Figure f = camera_from_above(run);
  f.name = "map", f.title = "Landmarks in the last map, from above";
  const auto last = std::find_if(run.frames.rbegin(), run.frames.rend(),
                                 [](const Frame& frame) { return frame.map.has_value(); });
  if (last == run.frames.rend() || last->map->empty()) return Figure{};
  Line& dots = f.lines.emplace_back(Line{"landmarks", Role::first, {}, {}, true});
  for (const slam::MapPoint& point : *last->map) dots.add(point.p_W.x(), point.p_W.y());
  return f;
}

Figure waist_from_above(const RunData& run) {
  Figure f =
      from_above("waist_from_above", "Waist from above: planned and actual", run.waist_plan, run.waist_truth);
  add_path(f, "desired", Role::first, run.waist_desired);
  add_path(f, "estimate", Role::estimate, run.waist_estimate);
  return f;
}

Figure camera_height(const RunData& run) {
  Figure f{"height",
           "Camera height",
           kTime,
           "z [m]",
           {{"plan", Role::plan, run.plan.t, run.plan.z}, {"truth", Role::truth, run.truth.t, run.truth.z}}};
  if (run.estimate) f.lines.push_back({"estimate", Role::estimate, run.estimate->t, run.estimate->z});
  return with_points(std::move(f));
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
    error.add(e.t[i], kMm * e.distance[i]);
    sigma.add(e.t[i], 3 * kMm * std::hypot(e.sigma[0][i], e.sigma[1][i], e.sigma[2][i]));
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
  if (const Figure map = map_from_above(run); !map.lines.empty()) figures.push_back(map);
  for (const auto& [table, add] : {std::pair{&run.corrected_steps, &add_corrections},
                                   {&run.feet, &add_slip},
                                   {&run.answers, &add_latency}})
    if (*table && (*table)->rows() > 0) add(figures, **table);
  if (run.frame_times && run.errors)
    figures.push_back({"cpu",
                       fmt::format("CPU time per frame, {}", run.estimator),
                       kTime,
                       "ms",
                       {{run.estimator, Role::estimate, run.frame_times->seconds("timestamp"),
                         run.frame_times->numbers("filter")}}});
  return figures;
}

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
