#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "sim/pages/paper.h"
#include "sim/score/statistics.h"

namespace sim::pages {
namespace {

constexpr const char* kNotRun = "not run";

using Runs = std::vector<RunData>;

std::vector<double> values(const Runs& runs, const std::string& metric, double factor = 1) {
  std::vector<double> all;
  for (const RunData& run : runs)
    if (const auto value = run.metric(metric)) all.push_back(factor * *value);
  return all;
}

std::string range_text(const std::vector<double>& values, const std::string& unit) {
  if (values.empty()) return "none";
  if (values.size() == 1) return fmt::format("{:.3g}{}", values.front(), unit);
  return fmt::format("median {:.3g}{} ({:.3g} to {:.3g})", score::median(values), unit,
                     score::quantile(values, 0), score::quantile(values, 1));
}

// One axis of a drift. The paper gives magnitudes without signs, so magnitudes are compared: they agree
// within a factor of two, or if both are below the scatter of the paper's walks.
struct DriftAxis {
  const char* metric;
  const char* axis;
  const char* unit;
  double paper, negligible;
  const char* paper_text;
};

PaperRow drift_row(const Runs& runs, const std::string& walk, const DriftAxis& axis) {
  PaperRow row{fmt::format("{}: drift in {} (II-B)", walk, axis.axis), axis.paper_text, kNotRun};
  const auto drifts = values(runs, axis.metric, axis.unit == std::string(" mm") ? kMm : 1);
  if (drifts.empty()) return row;
  const double mean = score::mean(drifts), size = std::abs(mean);
  row.bench = fmt::format("{:.1f}{}", mean, axis.unit);
  if (drifts.size() > 1) row.bench += fmt::format(" (sd {:.1f})", score::standard_deviation(drifts));
  const bool both_small = axis.paper <= axis.negligible && size <= axis.negligible;
  const bool near = size > axis.paper / 2 && size < axis.paper * 2;
  row.agreement = both_small || near ? Agreement::agrees : Agreement::differs;
  return row;
}

void add_drift(std::vector<PaperRow>& rows, const PaperRuns& all, const std::string& experiment,
               const std::string& walk, const std::vector<DriftAxis>& axes) {
  for (const DriftAxis& axis : axes) rows.push_back(drift_row(runs_of(all, experiment), walk, axis));
}

int closed(const Runs& runs) {
  return static_cast<int>(std::count_if(runs.begin(), runs.end(), [](const RunData& run) {
    return run.metric("loop_closed").value_or(0) == 1;
  }));
}

int diverged(const Runs& runs) {
  return static_cast<int>(
      std::count_if(runs.begin(), runs.end(), [](const RunData& run) { return run.ending == "diverged"; }));
}

enum class Expected { closes, fails, fails_in_2006 };

PaperRow closure_row(const PaperRuns& all, const std::string& experiment, const std::string& what,
                     const std::string& paper, Expected expected) {
  const Runs& runs = runs_of(all, experiment);
  if (runs.empty()) return {what, paper, kNotRun};
  const std::string lost = diverged(runs) > 0 ? fmt::format(", {} diverged", diverged(runs)) : "";
  const std::string text = fmt::format("{} of {} closed{}; landmarks recognized: {}; ATE {}", closed(runs),
                                       runs.size(), lost, range_text(values(runs, "loop_landmarks"), ""),
                                       range_text(values(runs, "ate_se3_rmse_m", kMm), " mm"));
  const bool always = closed(runs) == static_cast<int>(runs.size());
  if (expected == Expected::fails_in_2006)
    return {what, paper, text, always ? Agreement::better : Agreement::agrees};
  const bool as_expected = expected == Expected::closes ? always : closed(runs) == 0;
  return {what, paper, text, as_expected ? Agreement::agrees : Agreement::differs};
}

PaperRow end_row(const PaperRuns& all, const std::string& experiment, const char* axis, Column Errors::*error,
                 double paper_mm) {
  PaperRow row{
      fmt::format("Experiment 2, {}: error of the estimate at the end in {} (V-B)",
                  experiment.ends_with("paper") ? "the paper's filter" : "this bench's filter", axis),
      fmt::format("{:.0f} mm", paper_mm), kNotRun};
  std::vector<double> ends;
  for (const RunData& run : runs_of(all, experiment))
    if (run.errors && !((*run.errors).*error).empty())
      ends.push_back(kMm * std::abs(((*run.errors).*error).back()));
  if (ends.empty()) return row;
  row.bench = range_text(ends, " mm");
  const double median = score::median(ends);
  row.agreement = median < paper_mm / 2   ? Agreement::better
                  : median < 2 * paper_mm ? Agreement::agrees
                                          : Agreement::differs;
  return row;
}

PaperRow height_row(const PaperRuns& all, const std::string& experiment, const std::string& filter) {
  PaperRow row{"Experiment 1, " + filter + ": range of the estimated height (V-A)", "within 40 mm", kNotRun};
  const auto range = values(runs_of(all, experiment), "height_range_m", kMm);
  if (range.empty()) return row;
  row.bench = range_text(range, " mm");
  row.agreement = score::quantile(range, 1) <= 40 ? Agreement::agrees : Agreement::differs;
  return row;
}

PaperRow time_row(const PaperRuns& all, const std::string& experiment, const std::string& filter) {
  PaperRow row{"CPU time of a frame, " + filter + " (V)", "30 ms, sometimes 40 ms (two Pentium M, 1.8 GHz)",
               kNotRun};
  std::vector<double> ms;
  for (const RunData& run : runs_of(all, experiment))
    if (run.frame_cpu_ms_median) ms.push_back(*run.frame_cpu_ms_median);
  if (ms.empty()) return row;
  row.bench = range_text(ms, " ms") + ", on another computer: not comparable";
  return row;
}

void add_closures(std::vector<PaperRow>& rows, const PaperRuns& all) {
  const auto add = [&](const char* experiment, const char* what, const char* paper, Expected expected) {
    rows.push_back(closure_row(all, experiment, what, paper, expected));
  };
  add("tangent_circle_paper", "Experiment 1, the paper's filter (V-A.2)",
      "10 of 10 closed, about 10 landmarks", Expected::closes);
  add("tangent_circle", "Experiment 1, this bench's filter", "10 of 10 closed, about 10 landmarks",
      Expected::closes);
  add("perpendicular_circle_paper", "Experiment 2, the paper's filter (V-B)", "closed, by 3 landmarks",
      Expected::closes);
  add("perpendicular_circle", "Experiment 2, this bench's filter", "closed, by 3 landmarks",
      Expected::closes);
  add("vision_gyro_known_landmarks", "Experiment 1, vision and gyro, known landmarks (V-A.1)",
      "closed; quality of the trajectory insufficient", Expected::closes);
  add("vision_only", "Experiment 1, vision only (V-A)", "did not close", Expected::fails);
  add("hall_paper", "The hall, the paper's filter (V)", "fails: landmarks at 10 to 12 m", Expected::fails);
  add("hall", "The hall, this bench's filter", "fails", Expected::fails_in_2006);
}

}  // namespace

const std::vector<PaperExperiment>& paper_experiments() {
  static const std::vector<PaperExperiment> kAll{
      {"tangent_quadrant", "", 2},
      {"perpendicular_circle_trial1", "", 8},
      {"tangent_circle", "", 17},
      {"tangent_circle_paper", "tangent_circle", 4},
      {"vision_only", "tangent_circle", 4},
      {"vision_gyro_known_landmarks", "tangent_circle", 4},
      {"perpendicular_circle", "", 30},
      {"perpendicular_circle_paper", "perpendicular_circle", 7},
      {"hall", "", 18},
      {"hall_paper", "hall", 4},
  };
  return kAll;
}

const std::vector<RunData>& runs_of(const PaperRuns& all, const std::string& experiment) {
  static const std::vector<RunData> none;
  const auto found = all.find(experiment);
  return found == all.end() ? none : found->second;
}

std::string agreement_text(Agreement agreement) {
  constexpr const char* kTexts[] = {"", "agrees", "better", "differs"};
  return kTexts[static_cast<int>(agreement)];
}

std::vector<PaperRow> paper_rows(const PaperRuns& all) {
  const auto x = [](double paper, const char* text) {
    return DriftAxis{"plan_drift_x_m", "X", " mm", paper, 10, text};
  };
  const auto y = [](double paper, const char* text) {
    return DriftAxis{"plan_drift_y_m", "Y", " mm", paper, 10, text};
  };
  const auto yaw = [](double paper, const char* text) {
    return DriftAxis{"plan_drift_yaw_deg", "yaw", "°", paper, 1, text};
  };
  std::vector<PaperRow> rows;
  add_drift(rows, all, "tangent_quadrant", "Tangent quadrant",
            {x(4, "4 mm (sd 1.6)"), y(23, "23 mm (sd 3.4)"), yaw(0, "almost none")});
  add_drift(rows, all, "perpendicular_circle_trial1", "Facing the center, first trial",
            {x(240, "240 mm"), y(600, "600 mm"), yaw(20, "20°")});
  add_drift(rows, all, "perpendicular_circle", "Facing the center, second trial",
            {x(160, "160 mm"), y(40, "40 mm"), yaw(15, "15°")});
  add_closures(rows, all);
  for (const char* experiment : {"perpendicular_circle_paper", "perpendicular_circle"}) {
    rows.push_back(end_row(all, experiment, "X", &Errors::x, 30));
    rows.push_back(end_row(all, experiment, "Y", &Errors::y, 140));
  }
  for (const auto& [experiment, filter] : {std::pair{"tangent_circle_paper", "the paper's filter"},
                                           std::pair{"tangent_circle", "this bench's filter"}}) {
    rows.push_back(height_row(all, experiment, filter));
    rows.push_back(impact_row(runs_of(all, experiment), filter));
    rows.push_back(time_row(all, experiment, filter));
  }
  return rows;
}

}  // namespace sim::pages
