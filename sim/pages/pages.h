// The pages: each is one HTML file that needs no other file and no network. And the figures of runs.
#pragma once

#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/pages/figure.h"
#include "sim/pages/run_data.h"

namespace sim::pages {

/// The name of the thin line by the same sensors without images.
inline constexpr const char* kOdometryName = "odometry, no images";

/// Planned, true and estimated path of the camera, from above.
Figure camera_from_above(const RunData& run);
/// Planned and true path of the waist, from above.
Figure waist_from_above(const RunData& run);
/// Planned, true and estimated height of the camera.
Figure camera_height(const RunData& run);
/// The position error with its 3-sigma bound and the loop closure, at most so far from it; without lines if
/// the run has no errors.
Figure uncertainty(const RunData& run, double around_s = INFINITY);
/// All figures that the run has data for.
std::vector<Figure> run_figures(const RunData& run);

/// The figures of several runs of one scenario: paths, error over time, mean NEES with its band, and ATE and
/// CPU time by seed. Estimators are never pooled. By scenario; empty for fewer than two runs of it.
std::vector<std::pair<std::string, std::vector<Figure>>> comparison_figures(const std::vector<RunData>& runs);

/// The metrics that are shown first, in cards and in tables over several runs.
inline constexpr std::array kShownMetrics{"ate_se3_rmse_m",
                                          "rmse_m",
                                          "end_position_error_m",
                                          "end_yaw_error_deg",
                                          "tracked_fraction",
                                          "loop_landmarks",
                                          "nees_position_mean",
                                          "navigation_rmse_m",
                                          "navigation_end_position_error_m",
                                          "navigation_end_yaw_error_deg"};

/// By the limits of the run's own scenario: "passed", "missed a limit", or an ending that it does not allow.
std::string verdict_of(const RunData& run);

/// Frames with images, evenly spaced over the walk, as SVG: the image with the 3-sigma ellipses that were
/// searched (class "used" if the match entered the update, else "missed") and the 11 x 11 patches found.
struct Picture {
  double t = 0;  ///< s
  std::string svg;
};
/// Empty if there is no recording with images.
std::vector<Picture> pictures(const RunData& run, int count);
/// HTML of these pictures with an explanation; empty without any. prefix: of the ids.
std::string picture_strip(const std::vector<Picture>& pictures, const std::string& prefix);

/// The sections of a run as HTML, with links to them. prefix: of the ids. title: of the first section.
std::string run_sections(const RunData& run, const std::string& prefix, const std::string& title);

/// The page about these runs (at least one). Throws FileError if a file of a run is broken.
std::string runs_page(const std::vector<RunData>& runs);

/// True if the folder contains the scores of a sweep.
bool is_sweep(const std::filesystem::path& folder);
/// The page of a sweep: medians over one swept key as a line with all trials as dots, over two keys as a heat
/// map, with further keys pooled by their median; and the worst seed of each setting. Scenarios are never
/// pooled. Throws FileError.
std::string sweep_page(const std::filesystem::path& folder);

/// True if the folder contains a tuning.
bool is_tuning(const std::filesystem::path& folder);
/// The page of a tuning: the search, what the recordings determine, and the result on hold-out runs. Throws
/// FileError.
std::string tune_page(const std::filesystem::path& folder);

}  // namespace sim::pages
