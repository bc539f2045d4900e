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

/// Returns a sentence about each noise that the filter assumes clearly too large or too small, with what
/// would fit: sensors whose mean NIS is outside the 99 % band of a consistent filter, IMUs whose simulated
/// noise differs by more than a factor of two, and the NEES. Empty if the run is consistent.
std::vector<std::string> noise_remarks(const RunData& run);

/// Places that show a metric: cards and tables of runs; figures and tables of a sweep; a table file about
/// estimators, or about controllers and robots.
enum Shown : unsigned { kOfRuns = 1, kOfSweeps = 2, kOfEstimators = 4, kOfWalks = 8 };
/// Returns the names of the metrics shown there, most important first.
std::vector<std::string> shown_metrics(Shown where);
/// Returns the metrics shown for a run, without the navigation metrics if nothing steered it.
std::vector<std::string> shown_metrics(const RunData& run);
/// Returns the names of all metrics that a table of results can have.
std::vector<std::string> table_metrics();

/// How readers see a metric: errors in mm.
struct MetricDisplay {
  std::string title, unit;  ///< "ATE", "mm"; unit: empty for 1
  double factor = 1;        ///< from the metric's own unit
};
/// column: from column_of().
MetricDisplay display_of(const std::string& metric, const std::string& column = "");

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

/// A metric over seeds. center: the median, or the mean if the metric has an expected value, as NEES and NIS.
/// spread: the 95 % interval of the center; with two to five values the smallest and the largest.
struct OverSeeds {
  double center = 0;
  std::optional<std::pair<double, double>> spread = {};
};
OverSeeds over_seeds(const std::string& metric, const std::vector<double>& values);
/// Returns "median" or "mean".
std::string statistic_of(const std::string& metric);

/// The values of a metric over the completed runs of a row.
struct MetricSummary {
  std::string metric;
  std::string column;  ///< column_of()
  std::vector<double> values = {};
  OverSeeds over_seeds = {};  ///< if there are values, like worst and worst_run
  double worst = 0;
  std::size_t worst_run = 0;  ///< index of the run with the worst value
  bool best = false;  ///< better than each other row of the condition: larger coverage, or at least six
                      ///< values and no common part of the intervals
};
/// The runs with one scenario, errors.*, estimator, controller, robot and setting (the other keys that
/// differ).
struct ResultRow {
  std::string scenario, errors, estimator, controller, robot, setting;
  std::vector<std::size_t> runs = {};
  std::map<std::string, std::size_t> endings = {};  ///< number of runs by ending
  double coverage = 0;  ///< mean fraction of true poses with an estimate; 0 for a run that did not complete
  std::vector<MetricSummary> metrics = {};

  const MetricSummary* find(const std::string& column) const;
  std::size_t completed() const;
};
/// Returns the runs as rows. Runs of a scenario with equal errors.* are together, and the best one is first:
/// by coverage in whole percent, then by the first metric. metrics: if empty, the metrics shown for each run.
std::vector<ResultRow> result_rows(const std::vector<RunData>& runs,
                                   const std::vector<std::string>& metrics = {});

/// Rows as readers see them: rounded, with titles and units as in papers.
struct ResultTable {
  struct Column {
    std::string title, unit = "";
    bool is_number = false;
  };
  struct Cell {
    std::string text, small = "";  ///< small: the bracket
    bool best = false;
    const MetricSummary* of = nullptr;
  };
  std::vector<Column> columns;  ///< the columns that identify a row are first
  std::vector<std::vector<Cell>> rows;
  std::string note;  ///< what values and brackets are
};
ResultTable result_table(const std::vector<ResultRow>& rows);

/// Returns "slam.vision.sigma_px [px]", or the name if the unit is empty or 1.
std::string with_unit(const std::string& name, std::string_view unit);
/// Returns "rmse_m [m]".
std::string metric_label(const std::string& metric);
/// Returns "≤ 0.05".
std::string limit_text(const scenario::MetricLimit& limit);

enum class TableFormat { csv, markdown, latex };
/// Returns the format of a file from its extension .csv, .md or .tex. Throws std::invalid_argument.
TableFormat table_format(const fs::path& file);
/// Returns a table file. CSV: a line per row and metric, with all digits and the metric's own unit. LaTeX: as
/// wide as the text, with the packages booktabs and tabularx. metrics: if empty, four for estimators, or five
/// for walks if controllers or robots differ.
std::string runs_table(const std::vector<RunData>& runs, TableFormat format,
                       const std::vector<std::string>& metrics = {});

/// Returns HTML of `count` (at least two) images, evenly spaced over the walk, with the 3-sigma ellipses that
/// were searched (class "used" if the match entered the update, else "missed") and the 11 x 11 patches found.
/// Empty without a recording of images.
std::string picture_strip(const RunData& run, std::size_t count);

/// Returns a run's sections as HTML, with links to them. prefix: for the ids. title: for the first section.
std::string run_sections(const RunData& run, const std::string& prefix, const std::string& title);

/// Returns the page about these runs (at least one). metrics: of the table of results; if empty, the shown
/// ones. Throws FileError if a run's file is broken.
std::string runs_page(const std::vector<RunData>& runs, const std::vector<std::string>& metrics = {});

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
