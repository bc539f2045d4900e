#include "sim/report/paper.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "sim/report/paper_height.h"
#include "sim/score/statistics.h"

namespace sim::report {
namespace {

constexpr double kMm = 1e3;
constexpr const char* kNotRun = "not run";

using Runs = std::vector<RunData>;

const Runs& runs_of(const PaperRuns& all, const std::string& experiment) {
  static const Runs none;
  const auto found = all.find(experiment);
  return found == all.end() ? none : found->second;
}

std::vector<double> values(const Runs& runs, const std::string& metric, double factor = 1) {
  std::vector<double> all;
  for (const RunData& run : runs)
    if (const auto value = run.metric(metric)) all.push_back(factor * *value);
  return all;
}

/// "12.3 (1.4)": mean and standard deviation over seeds.
std::string spread(const std::vector<double>& values, const std::string& unit) {
  if (values.empty()) return "none";
  const score::Summary s = score::summarise(values, score::Worst::largest);
  return fmt::format("{:.1f} ({:.1f}) {}", s.mean, s.standard_deviation, unit);
}

std::string median_text(std::vector<double> values, const std::string& unit) {
  if (values.empty()) return "none";
  std::sort(values.begin(), values.end());
  return fmt::format("median {:.3g} {}, {:.3g} to {:.3g}",
                     score::summarise(values, score::Worst::largest).median, unit, values.front(),
                     values.back());
}

struct Drift {
  double x_mm, y_mm, yaw_deg;
};

// Within a factor 2 of the paper where the paper's mean is above 10 mm or 1 degree, below those elsewhere.
bool agrees(double paper, double bench, double small) {
  if (paper < small) return std::abs(bench) < 2 * small;
  return std::abs(bench) > paper / 2 && std::abs(bench) < paper * 2;
}

double mean(const std::vector<double>& values) {
  return values.empty() ? NAN : score::summarise(values, score::Worst::largest).mean;
}

PaperRow drift_row(const PaperRuns& all, const std::string& experiment, const std::string& what,
                   const std::string& paper, const Drift& drift) {
  const Runs& runs = runs_of(all, experiment);
  if (runs.empty()) return {what, paper, kNotRun, ""};
  const auto x = values(runs, "plan_drift_x_m", kMm), y = values(runs, "plan_drift_y_m", kMm);
  const auto yaw = values(runs, "plan_drift_yaw_deg");
  const bool all_agree = agrees(drift.x_mm, mean(x), 10) && agrees(drift.y_mm, mean(y), 10) &&
                         agrees(drift.yaw_deg, mean(yaw), 1);
  return {what, paper, fmt::format("X {}, Y {}, yaw {}", spread(x, "mm"), spread(y, "mm"), spread(yaw, "°")),
          all_agree ? "agrees" : "differs"};
}

int closed(const Runs& runs) {
  return static_cast<int>(std::count_if(runs.begin(), runs.end(), [](const RunData& run) {
    return run.metric("loop_closed").value_or(0) == 1;
  }));
}

std::string closures(const Runs& runs) {
  return fmt::format("{} of {} closed, {} landmarks, ATE {}", closed(runs), runs.size(),
                     median_text(values(runs, "loop_landmarks"), ""),
                     median_text(values(runs, "ate_se3_rmse_m", kMm), "mm"));
}

enum class Expected { closes, fails };

PaperRow closure_row(const PaperRuns& all, const std::string& experiment, const std::string& what,
                     const std::string& paper, Expected expected) {
  const Runs& runs = runs_of(all, experiment);
  if (runs.empty()) return {what, paper, kNotRun, ""};
  const bool always = closed(runs) == static_cast<int>(runs.size());
  const bool as_expected = expected == Expected::closes ? always : closed(runs) == 0;
  return {what, paper, closures(runs), as_expected ? "agrees" : "differs"};
}

std::vector<double> end_errors(const Runs& runs, Column Errors::*axis) {
  std::vector<double> all;
  for (const RunData& run : runs)
    if (run.errors && !((*run.errors).*axis).empty())
      all.push_back(kMm * std::abs(((*run.errors).*axis).back()));
  return all;
}

PaperRow end_row(const PaperRuns& all) {
  const std::string what = "Experiment 2, final error of the estimate (V-B)";
  const std::string paper = "30 mm in X, 140 mm in Y";
  const Runs& runs = runs_of(all, "perpendicular_circle");
  if (runs.empty()) return {what, paper, kNotRun, ""};
  const auto x = end_errors(runs, &Errors::x), y = end_errors(runs, &Errors::y);
  return {what, paper, fmt::format("X {}; Y {}", median_text(x, "mm"), median_text(y, "mm")),
          mean(x) < 30 && mean(y) < 140 ? "better" : "differs"};
}

PaperRow height_row(const PaperRuns& all) {
  const Runs& runs = runs_of(all, "tangent_circle");
  const std::string what = "Experiment 1, interval of the estimated height (V-A)";
  if (runs.empty()) return {what, "4 cm", kNotRun, ""};
  const auto range = values(runs, "height_range_m", kMm);
  return {what, "4 cm", median_text(range, "mm"), mean(range) <= 40 ? "better" : "differs"};
}

PaperRow time_row(const PaperRuns& all) {
  const Runs& runs = runs_of(all, "tangent_circle");
  const std::string what = "Time of a frame (V)", paper = "30 ms, up to 40 ms (Pentium M, 1.8 GHz)";
  std::vector<double> ms;
  for (const RunData& run : runs) ms.push_back(run.timing.value("frame_cpu_ms_median", NAN));
  if (ms.empty()) return {what, paper, kNotRun, ""};
  return {what, paper, median_text(ms, "ms"), "better"};
}

}  // namespace

const std::vector<PaperExperiment>& paper_experiments() {
  static const std::vector<PaperExperiment> kAll{
      {"tangent_quadrant", "tangent_quadrant.yaml", ""},
      {"perpendicular_circle_trial1", "perpendicular_circle_trial1.yaml", ""},
      {"tangent_circle", "tangent_circle.yaml", ""},
      {"perpendicular_circle", "perpendicular_circle.yaml", ""},
      {"hall", "hall.yaml", ""},
      {"tangent_circle_paper", "tangent_circle_paper.yaml", "tangent_circle"},
      {"perpendicular_circle_paper", "perpendicular_circle_paper.yaml", "perpendicular_circle"},
      {"vision_only", "vision_only.yaml", "tangent_circle"},
      {"vision_gyro_known_landmarks", "vision_gyro_known_landmarks.yaml", "tangent_circle"},
      {"hall_paper", "hall_paper.yaml", "hall"},
  };
  return kAll;
}

std::vector<PaperRow> paper_rows(const PaperRuns& all) {
  return {
      drift_row(all, "tangent_quadrant", "Drift of the walk, tangent quadrant (II-B)",
                "X 4 mm (1.6), Y 23 mm (3.4), yaw almost none", {4, 23, 0}),
      drift_row(all, "perpendicular_circle_trial1", "Drift, perpendicular circle, first trial (II-B)",
                "X 240 mm, Y 600 mm, yaw 20°", {240, 600, 20}),
      drift_row(all, "perpendicular_circle", "Drift, perpendicular circle, second trial (II-B)",
                "X 160 mm, Y 40 mm, yaw 15°", {160, 40, 15}),
      closure_row(all, "tangent_circle", "Experiment 1, this bench's filter (V-A.2)",
                  "10 of 10 closed, about 10 landmarks", Expected::closes),
      closure_row(all, "tangent_circle_paper", "Experiment 1, the paper's filter (V-A.2)",
                  "10 of 10 closed, about 10 landmarks", Expected::closes),
      closure_row(all, "perpendicular_circle", "Experiment 2, this bench's filter (V-B)",
                  "closed, 3 landmarks", Expected::closes),
      closure_row(all, "perpendicular_circle_paper", "Experiment 2, the paper's filter (V-B)",
                  "closed, 3 landmarks", Expected::closes),
      end_row(all),
      closure_row(all, "vision_gyro_known_landmarks",
                  "Experiment 1, vision and gyro, known landmarks (V-A.1)",
                  "closes; quality of the trajectory insufficient", Expected::closes),
      closure_row(all, "vision_only", "Experiment 1, vision alone, the paper's filter (V-A)",
                  "does not close", Expected::fails),
      closure_row(all, "hall_paper", "The hall, the paper's filter (V)", "fails: landmarks at 10 to 12 m",
                  Expected::fails),
      closure_row(all, "hall", "The hall, this bench's filter", "fails", Expected::closes),
      height_row(all),
      impact_row(runs_of(all, "tangent_circle")),
      time_row(all),
  };
}

}  // namespace sim::report
