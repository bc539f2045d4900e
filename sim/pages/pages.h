// The pages, each a single HTML file that needs no other files and no network; and the figures of runs.
#pragma once

#include <fmt/format.h>

#include <cstdint>

#include "sim/pages/html.h"
#include "sim/pages/pictures.h"
#include "sim/pages/run_data.h"
#include "sim/pages/settings.h"
#include "sim/pages/variants.h"
#include "sim/scenario/options.h"

namespace sim::pages {

/// The name of the thin line for the same sensors without images.
inline constexpr const char* kOdometryName = "odometry, no images";

/// Returns the planned, true and estimated paths of the camera, seen from above.
Figure camera_from_above(const RunData& run);
/// Returns the planned and true paths of the waist, seen from above.
Figure waist_from_above(const RunData& run);
/// Returns the planned, true and estimated height of the camera.
Figure camera_height(const RunData& run);
/// Returns the position error and its 3-sigma bound within around_s of the loop closure; without errors, a
/// figure without lines.
Figure uncertainty(const RunData& run, double around_s = INFINITY);
/// Returns all figures that the run has data for.
std::vector<Figure> run_figures(const RunData& run);

/// Returns figures of the runs of each scenario: paths, error over time, mean NEES with its band, and ATE and
/// CPU time by setting. Estimators are never pooled; a scenario with fewer than two runs has no figures.
std::vector<std::pair<std::string, std::vector<Figure>>> comparison_figures(const std::vector<RunData>& runs);

/// A metric that pages show: in the cards and tables of runs, and in the figures and tables of a sweep.
struct ShownMetric {
  const char* name;
  bool run = false, sweep = false;
};
/// Returns the names of the metrics shown there, most important first.
std::vector<std::string> shown_metrics(bool ShownMetric::*where);
/// Returns the metrics shown for a run, without the navigation metrics if nothing steered it.
std::vector<std::string> shown_metrics(const RunData& run);

/// Returns the time (s) of the largest error that a metric measures, or nullopt if the run has no errors.
std::optional<double> worst_instant(const RunData& run, const std::string& metric);

/// Returns the scores of a run and of its other seeds: neighboring results seed-<n> with the same settings.
std::vector<result::SeedScore> seeds_beside(const RunData& run);

/// The changed keys and the metrics of two sets of runs, A and B, as text. metric: empty for a key.
struct ChangeTable {
  struct Row {
    std::vector<std::string> cells;
    std::string metric = {};
    std::optional<std::uint64_t> worst_seed = {};  ///< the seed that got worse by the most
    std::string remark = {};                       ///< about the verdict
  };
  std::vector<std::string> titles;
  std::vector<Row> rows;
};
/// Compares a with b like gaitslam compare: medians over the common seeds, and p with at least 8 of them.
/// runs: A, B, and more of the same scenario, with a column each.
ChangeTable changes(const std::vector<const RunData*>& runs, const std::vector<result::SeedScore>& a,
                    const std::vector<result::SeedScore>& b);

/// The values of a metric over the seeds of a row.
struct MetricSummary {
  std::string metric;
  std::string column;  ///< column_of()
  std::vector<double> values = {};
  std::optional<std::pair<double, double>> interval = {};  ///< 95 % interval of the median; needs 6 seeds
  double worst = 0;
  std::size_t worst_run = 0;  ///< index of the run with the worst value
  std::optional<scenario::MetricLimit> limit = {};
};
/// The runs with one scenario, estimator, controller, robot and setting (the other keys that differ).
struct ResultRow {
  std::string scenario, estimator, controller, robot, setting;
  std::vector<std::size_t> runs = {};
  std::size_t completed = 0;
  double coverage = 0;  ///< mean fraction of true poses with an estimate; 0 for a run that did not complete
  std::vector<MetricSummary> metrics = {};
  std::vector<double> cpu_ms = {};  ///< median per frame of each run

  std::optional<double> coverage_shown() const {
    return coverage > 0 ? std::optional(coverage) : std::nullopt;
  }
  /// Returns "3 of 3".
  std::string completed_text() const { return fmt::format("{} of {}", completed, runs.size()); }
};
/// Returns the runs as rows, grouped by scenario with the best one first: by coverage in whole
/// percent, then by the first metric.
std::vector<ResultRow> result_rows(const std::vector<RunData>& runs);
/// Returns the columns that identify a row: the estimator, and columns in which rows differ.
std::vector<std::pair<std::string, std::string ResultRow::*>> naming_columns(
    const std::vector<ResultRow>& rows);
/// Returns "≤ 0.05".
std::string limit_text(const scenario::MetricLimit& limit);
/// Returns "slam.vision.sigma_px [px]", or the name if the unit is empty or 1.
std::string with_unit(const std::string& name, std::string_view unit);
/// Returns "rmse_m [m]". column: the name in a table, from column_of().
std::string metric_label(const std::string& metric, const std::string& column = "");
/// Returns "0.02 [0.01, 0.03]".
std::string median_text(double median, const std::optional<std::pair<double, double>>& interval);

enum class TableFormat { csv, markdown, latex };
/// Returns the format of a file from its extension .csv, .md or .tex. Throws std::invalid_argument.
TableFormat table_format(const fs::path& file);
/// Returns result_rows() as a table file: in CSV, a line per row and metric with all digits; otherwise, a
/// line per row. LaTeX uses the package booktabs.
std::string runs_table(const std::vector<RunData>& runs, TableFormat format);

/// Returns HTML of `count` (at least two) images, evenly spaced over the walk, with the 3-sigma ellipses that
/// were searched (class "used" if the match entered the update, else "missed") and the 11 x 11 patches found.
/// Empty without a recording of images.
std::string picture_strip(const RunData& run, std::size_t count);

/// Returns a run's sections as HTML, with links to them. prefix: for the ids. title: for the first section.
std::string run_sections(const RunData& run, const std::string& prefix, const std::string& title);

/// Returns the page about these runs (at least one). Throws FileError if a run's file is broken.
std::string runs_page(const std::vector<RunData>& runs);

/// Returns whether a folder contains a sweep: scores.jsonl and trials.jsonl.
bool is_sweep(const fs::path& folder);
/// Returns the page of a sweep, by scenario: medians over each numeric key as lines, one for each combination
/// of the other keys' values or a single one with the trials as dots; and the worst seed of each setting.
/// Throws FileError.
std::string sweep_page(const fs::path& folder);

/// Returns whether a folder contains a tuning: tune.json and history.csv.
bool is_tuning(const fs::path& folder);
/// Returns the page of a tuning: parameters, training and hold-out runs, and the search. Throws FileError.
std::string tune_page(const fs::path& folder);

// The experiments of the paper, our runs that repeat them, and the page that compares both.

/// One experiment: walks with the scenario <name>.yaml, or its filter on another experiment's recordings.
struct PaperExperiment {
  std::string name;
  std::string recordings;  ///< experiment that it replays; empty: it simulates its own walks
  double cost_s;           ///< approximate CPU time per seed, to estimate the remaining time
};

/// All experiments, ordered so that recordings exist before they are replayed.
inline const std::vector<PaperExperiment> kPaperExperiments{
    {"tangent_quadrant", "", 2},
    {"perpendicular_circle_trial1", "", 8},
    {"tangent_circle", "", 17},
    {"tangent_circle_paper", "tangent_circle", 4},
    {"vision_only", "tangent_circle", 4},
    {"vision_gyro_known_landmarks", "tangent_circle", 4},
    {"perpendicular_circle", "", 30},
    {"perpendicular_circle_paper", "perpendicular_circle", 7},
    {"hall", "", 18},
    {"hall_paper", "hall", 4}};

/// The runs of each experiment, by name.
using PaperRuns = std::map<std::string, std::vector<RunData>>;
/// A row of the table: the compared quantity (with the paper's section), and both results. agreement:
/// "agrees", "better", "differs", or empty if the results cannot be compared.
struct PaperRow {
  std::string what, paper, bench = "not run", agreement = "";
};
/// Returns all rows; an experiment without runs has the result "not run".
std::vector<PaperRow> paper_rows(const PaperRuns& runs);

/// Returns Figure 3 from a depths.csv: the depth hypotheses of the landmark that took the most images until
/// its depth was known (standard deviation below 0.3 of the mean), after the first image, one and two thirds
/// of them, and the last. It has no lines if no landmark qualifies.
Figure depths_figure(const fs::path& depths_csv);

/// Returns the page: table and figures. Throws FileError if a table of a run is broken.
std::string paper_page(const PaperRuns& runs, const std::string& revision);

}  // namespace sim::pages
