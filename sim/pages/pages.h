// The pages, each a single HTML file that needs no other files and no network; and the figures of runs.
#pragma once

#include <cstdint>

#include "sim/pages/html.h"
#include "sim/pages/run_data.h"
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

/// A metric that pages show unless others are requested: in the cards and tables of runs, the leaderboard,
/// and the figures and tables of a sweep.
struct ShownMetric {
  const char* name;
  bool run = false, leaderboard = false, sweep = false;
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

/// The values of a metric for one scenario and setting over the seeds.
struct MetricSummary {
  std::string scenario, setting, metric;
  std::string column;  ///< column_of()
  std::vector<double> values = {};
  std::optional<std::pair<double, double>> interval = {};  ///< of the median, 95 %; needs 6
  double worst = 0;
  std::size_t worst_run = 0;  ///< index of the run with the worst value
  std::optional<scenario::MetricLimit> limit = {};
};
/// Returns the metrics shown for runs, by scenario and variants().
std::vector<MetricSummary> summaries(const std::vector<RunData>& runs);
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
/// Returns a table file; LaTeX uses the package booktabs. lines: titles, then rows; "-": absent. remark: put
/// below the rows, but not in CSV.
std::string written_table(const std::vector<std::vector<std::string>>& lines, TableFormat format,
                          const std::string& remark);
/// Returns summaries() as a table: in CSV, a line per metric with all digits; otherwise, a row per setting.
std::string runs_table(const std::vector<RunData>& runs, TableFormat format);

/// Returns HTML of `count` (at least two) images, evenly spaced over the walk, with the 3-sigma ellipses that
/// were searched (class "used" if the match entered the update, else "missed") and the 11 x 11 patches found.
/// Empty without a recording of images.
std::string picture_strip(const RunData& run, std::size_t count);

/// Returns a run's sections as HTML, with links to them. prefix: for the ids. title: for the first section.
std::string run_sections(const RunData& run, const std::string& prefix, const std::string& title);

/// Returns the page about these runs (at least one). Throws FileError if a run's file is broken.
std::string runs_page(const std::vector<RunData>& runs);

bool is_sweep(const fs::path& folder);
/// Returns the page of a sweep, by scenario: medians over a numeric key as lines (with the trials as dots, or
/// one line per combination of non-numeric values); medians over two keys as heat maps, pooled over the other
/// keys; and the worst seed of each setting. Throws FileError.
std::string sweep_page(const fs::path& folder);

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
/// A row of the table: what is compared (with the paper's section), and both results. agreement: "agrees",
/// "better", "differs", or empty if the results cannot be compared.
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

// The estimators in a tree of results in one table: a row for each set of results, grouped by scenario.

/// One run of a row. coverage: the fraction of true poses with an estimate; 0 for an incomplete run.
struct LeaderboardRun {
  bool completed = false;
  double coverage = 0;
  std::map<std::string, double> values;  ///< by column, those that it has
  fs::path folder;
};

/// A folder's results with the same scenario, estimator, settings, programs and alignment.
struct LeaderboardRow {
  std::string scenario, estimator;
  std::string alignment;  ///< how the estimate was aligned with the truth before it was scored, or "none"
  fs::path folder;        ///< contains the results; for replays inside them, a path with seed-*
  std::map<std::string, std::string> settings;        ///< settings_of()
  std::map<std::uint64_t, LeaderboardRun> runs = {};  ///< by seed
  std::vector<std::uint64_t> seeds = {};              ///< used for its numbers: the common ones, or all
  std::optional<std::size_t> rank = {};               ///< from 1 in its scenario; absent without common seeds

  /// Returns the values of the runs with these seeds that have one.
  std::vector<double> values(const std::string& column) const;
  double coverage() const;  ///< mean over the runs with these seeds
};

struct Leaderboard {
  std::vector<std::string> metrics;  ///< rows are ordered by the first one
  std::vector<LeaderboardRow> rows = {};
  std::map<std::string, std::vector<std::uint64_t>> common = {};  ///< by scenario: seeds of all ranked rows
  std::vector<std::string> left_out = {};  ///< results that cannot be read or that repeat a seed of their row
};

/// Returns all results below the folders, each once, without recordings and replaced results. Ranks the rows
/// of a scenario over their common seeds, by coverage in whole percent, then by the median of the first
/// metric; never compares scenarios. A row without the common seeds is listed last, without a rank. Throws
/// FileError if a folder contains no result, or none can be read.
Leaderboard leaderboard(const std::vector<fs::path>& folders, const std::vector<std::string>& metrics);

std::string leaderboard_table(const Leaderboard& board);
std::string leaderboard_file(const Leaderboard& board, TableFormat format);
/// Returns a single-file page.
std::string leaderboard_page(const Leaderboard& board);

}  // namespace sim::pages
