// A result folder as read by pages and the view, with errors and normalized errors computed by sim/score.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "sim/pages/frame.h"
#include "sim/pages/table.h"
#include "sim/recording/recording.h"
#include "sim/result/score_file.h"

namespace sim::pages {

/// Factors from SI to the units of the pages.
inline constexpr double kMm = 1e3, kDeg = 180 / std::numbers::pi;

/// A trajectory as columns: time (s) and position (m); NaN if missing.
struct Path {
  Column t, x, y, z;
};

/// Errors of the frames (FrameError) as columns, in SI units; NaN if missing.
struct Errors {
  Column t;
  std::array<Column, 4> error, sigma;  ///< x, y, z, yaw
  Column distance;
  Column nees_position, nees_orientation;
};

/// A result folder. Parts that the run did not write (no filter, no camera) are absent.
struct RunData : result::SeedScore {
  std::string alignment = "none";  ///< how the estimate was aligned with the truth before it was scored
  fs::path folder;
  fs::path recording;                           ///< the result's own recording if finished, otherwise empty
  std::optional<recording::Truth> recorded;     ///< the truth in that recording
  std::map<std::string, std::string> settings;  ///< settings_of()
  result::About about;
  std::optional<double> frame_cpu_ms_mean, frame_cpu_ms_median, frame_cpu_ms_p99;  ///< batch: mean
  Path truth, plan, waist_truth, waist_plan;
  bool truth_aligned = false;  ///< if positions only, drawn after SE(3) alignment with the estimate
  std::optional<Path> estimate;
  std::optional<Path> waist_estimate;  ///< only for a steered walk, like waist_desired and corrected_steps
  std::optional<Path> waist_desired;
  std::optional<Errors> errors;
  std::optional<Path> odometry;  ///< from the same sensors without images
  Column odometry_error;         ///< its distance from the truth, m
  std::optional<Table> filter_frames, feet, frame_times, corrected_steps, answers;
  std::vector<Frame> frames;  ///< truth, plan, estimate, report and map, without images

  /// Returns the value of a key in one line, or "" if it is unknown.
  std::string setting(const std::string& key) const;
  /// Returns "tangent_circle, seed 1", with the estimator unless it is the filter, and with its alignment.
  std::string label() const;
};

/// poses: errors, and frames with poses and the filter's state; all: also the truth in the result's
/// recording.
enum class Reads { poses, all };

/// Reads a result. Throws FileError if it is not a result, if a file is missing or broken, or if its
/// recording was edited.
RunData read_run(const fs::path& result_folder, Reads reads = Reads::all);

/// Returns a function that adds what the filter searched for and its map to frames of a run, which is called
/// in chronological order. It reads the files as far as needed, and throws FileError.
std::function<void(Frame&)> frame_parts(const RunData& run);

}  // namespace sim::pages
