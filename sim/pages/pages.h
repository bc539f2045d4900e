// The pages: each is one HTML file that needs no other file and no network. And the figures of runs.
#pragma once

#include <cstdint>

#include "sim/pages/html.h"
#include "sim/pages/run_data.h"
#include "sim/scenario/options.h"

namespace sim::pages {

/// The name of the thin line by the same sensors without images.
inline constexpr const char* kOdometryName = "odometry, no images";

/// Returns the planned, true and estimated path of the camera, from above.
Figure camera_from_above(const RunData& run);
/// Returns the planned and true path of the waist, from above.
Figure waist_from_above(const RunData& run);
/// Returns the planned, true and estimated height of the camera.
Figure camera_height(const RunData& run);
/// Returns position error and 3-sigma bound within around_s of the loop closure; no lines without errors.
Figure uncertainty(const RunData& run, double around_s = INFINITY);
/// Returns all figures that the run has data for.
std::vector<Figure> run_figures(const RunData& run);

/// Returns, by scenario, figures of its runs: paths, error over time, mean NEES with its band, and ATE and
/// CPU time by seed. Estimators are never pooled; a scenario with fewer than two runs has no figures.
std::vector<std::pair<std::string, std::vector<Figure>>> comparison_figures(const std::vector<RunData>& runs);

/// A metric that pages show unless others are asked for: in the cards and tables of runs, the leaderboard,
/// and the figures and tables of a sweep.
struct ShownMetric {
  const char* name;
  bool run = false, leaderboard = false, sweep = false;
};
/// Returns the names of the metrics shown there, the most important first.
std::vector<std::string> shown_metrics(bool ShownMetric::*where);
/// Returns the metrics shown of a run, without those of its navigation if nothing steered it.
std::vector<std::string> shown_metrics(const RunData& run);

/// Returns the time (s) of the largest error that a metric measures; nothing if the run has no errors.
std::optional<double> worst_instant(const RunData& run, const std::string& metric);

/// Returns the scores of a run and of its other seeds: results seed-<n> beside it with the same settings.
std::vector<result::SeedScore> seeds_beside(const RunData& run);

/// The changed keys and the metrics of two sets of runs, A and B, as text. metric: empty for a key.
struct ChangeTable {
  struct Row {
    std::vector<std::string> cells;
    std::string metric = {};
    std::optional<std::uint64_t> worst_seed = {};  ///< which changed most for the worse
    std::string remark = {};                       ///< on the verdict
  };
  std::vector<std::string> titles;
  std::vector<Row> rows;
};
/// Compares a with b as gaitslam compare does: medians over the seeds in common, and p from 8 of them on.
/// runs: A, B, and more of the same scenario, each with a column.
ChangeTable changes(const std::vector<const RunData*>& runs, const std::vector<result::SeedScore>& a,
                    const std::vector<result::SeedScore>& b);

/// A metric of one scenario and setting over its seeds.
struct MetricSummary {
  std::string scenario, setting, metric;
  std::string column;  ///< column_of()
  std::vector<double> values = {};
  std::optional<std::pair<double, double>> interval = {};  ///< of the median, 95 %; from 6 values on
  double worst = 0;
  std::size_t worst_run = 0;  ///< its index
  std::optional<scenario::MetricLimit> limit = {};
};
/// Returns the metrics that runs show, by scenario and variants().
std::vector<MetricSummary> summaries(const std::vector<RunData>& runs);
/// Returns "≤ 0.05".
std::string limit_text(const scenario::MetricLimit& limit);
/// Returns "slam.vision.sigma_px [px]", or the name if the unit is empty or 1.
std::string with_unit(const std::string& name, std::string_view unit);
/// Returns "rmse_m [m]"; column: its name in a table, as by column_of().
std::string metric_label(const std::string& metric, const std::string& column = "");
/// Returns "0.02 [0.01, 0.03]".
std::string median_text(double median, const std::optional<std::pair<double, double>>& interval);

enum class TableFormat { csv, markdown, latex };
/// Returns the format of a file by its ending .csv, .md or .tex. Throws std::invalid_argument.
TableFormat table_format(const fs::path& file);
/// Returns titles and rows as a file, LaTeX for the package booktabs. "-": absent. remark: below the rows;
/// not in CSV.
std::string written_table(const std::vector<std::vector<std::string>>& lines, TableFormat format,
                          const std::string& remark);
/// Returns summaries(): as CSV a line for each metric with all digits, else a row for each setting.
std::string runs_table(const std::vector<RunData>& runs, TableFormat format);

/// Returns the HTML of frames with images, evenly spaced over the walk: the image with the 3-sigma ellipses
/// that were searched (class "used" if the match entered the update, else "missed") and the 11 x 11 patches
/// found. Empty without a recording of images. count: at least two.
std::string picture_strip(const RunData& run, std::size_t count);

/// Returns a run's sections as HTML with links to them. prefix: of the ids. title: of the first section.
std::string run_sections(const RunData& run, const std::string& prefix, const std::string& title);

/// Returns the page about these runs (at least one). Throws FileError if a file of a run is broken.
std::string runs_page(const std::vector<RunData>& runs);

/// Returns whether the folder contains the scores of a sweep.
bool is_sweep(const fs::path& folder);
/// Returns the page of a sweep: medians over one numeric key as lines, with the trials as dots or a line for
/// each combination of words, over two keys as a heat map, further keys pooled by their median; and the worst
/// seed of each setting, by scenario. Throws FileError.
std::string sweep_page(const fs::path& folder);

/// Returns whether the folder contains a tuning.
bool is_tuning(const fs::path& folder);
/// Returns the page of a tuning: the search, what recordings determine, hold-out runs. Throws FileError.
std::string tune_page(const fs::path& folder);

// The experiments of the paper, the runs of this bench that repeat them, and the page that compares both.

/// One experiment: walks of the scenario <name>.yaml, or its filter on the recordings of another experiment.
struct PaperExperiment {
  std::string name;
  std::string recordings;  ///< experiment that it replays; empty: it simulates its walks
  double cost_s;           ///< approximate CPU time of a seed, for the estimate of the time left
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

/// Runs by the name of their experiment.
using PaperRuns = std::map<std::string, std::vector<RunData>>;
/// A row of the table: what is compared (with the section of the paper), and both results. agreement:
/// "agrees", "better", "differs", or empty if it cannot be compared.
struct PaperRow {
  std::string what, paper, bench = "not run", agreement = "";
};
/// Returns all rows; the result of an experiment without runs is "not run".
std::vector<PaperRow> paper_rows(const PaperRuns& runs);

/// Returns Figure 3, from a depths.csv: the depth hypotheses of the landmark that took most images until its
/// depth was known (standard deviation below 0.3 of it), after the first image, thirds of them and the last.
/// It has no lines if no landmark qualifies.
Figure depths_figure(const fs::path& depths_csv);

/// Returns the page: table and figures. Throws FileError if a table of a run is broken.
std::string paper_page(const PaperRuns& runs, const std::string& revision);

// The estimators of a tree of results in one table: a row for each set of results, grouped by scenario.

/// One run of a row. coverage: the fraction of true poses with an estimate; 0 of an incomplete run.
struct LeaderboardRun {
  bool completed = false;
  double coverage = 0;
  std::map<std::string, double> values;  ///< by column, those that it has
  fs::path folder;
};

/// The results of one folder that are of the same scenario, estimator, settings, programs and alignment.
struct LeaderboardRow {
  std::string scenario, estimator;
  std::string alignment;  ///< of the estimate with the truth before it was scored; or "none"
  fs::path folder;        ///< of the results; of replays in it, with seed-* for each seed
  std::map<std::string, std::string> settings;        ///< settings_of()
  std::map<std::uint64_t, LeaderboardRun> runs = {};  ///< by seed
  std::vector<std::uint64_t> seeds = {};              ///< that its numbers are of: those in common, or all
  std::optional<std::size_t> rank = {};               ///< from 1 in its scenario; absent without common seeds

  /// Returns the values of the runs with these seeds that have one.
  std::vector<double> values(const std::string& column) const;
  double coverage() const;  ///< mean over the runs with these seeds
};

struct Leaderboard {
  std::vector<std::string> metrics;  ///< the first one orders
  std::vector<LeaderboardRow> rows = {};
  std::map<std::string, std::vector<std::uint64_t>> common = {};  ///< by scenario: seeds of all ranked rows
  std::vector<std::string> left_out = {};  ///< results that cannot be read, or repeat a seed of their row
};

/// Returns all results below the folders, each once, without recordings and replaced results. Ranks the rows
/// of a scenario over the seeds that they have in common, by coverage in whole percent, then by the median of
/// the first metric; never compares scenarios. A row without these seeds is listed last, without a rank.
/// Throws FileError if a folder contains no result that can be read.
Leaderboard leaderboard(const std::vector<fs::path>& folders, const std::vector<std::string>& metrics);

std::string leaderboard_table(const Leaderboard& board);
std::string leaderboard_file(const Leaderboard& board, TableFormat format);
/// Returns a page that needs no other file.
std::string leaderboard_page(const Leaderboard& board);

}  // namespace sim::pages
