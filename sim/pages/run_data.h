// A result folder as pages and the view read it, with errors and normalized errors computed by sim/score.
#pragma once

#include <array>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/pages/frame.h"
#include "sim/result/score_file.h"

namespace sim::pages {

/// Factors from SI to the units of the pages.
inline constexpr double kMm = 1e3, kDeg = 180 / std::numbers::pi;

using Column = std::vector<double>;

/// A comma-separated file by the names of its columns; further columns do not matter. Titles lose their unit
/// ("p_W_x [m]" is p_W_x) and the first one its '#'.
class Table {
 public:
  /// Throws FileError if the file cannot be read, or has two columns of one name or a row of other length.
  explicit Table(const fs::path& file);

  std::size_t rows() const { return rows_; }
  bool has(std::string_view column) const { return columns_.contains(column); }
  /// As text. Throws FileError if there is no such column.
  const std::vector<std::string>& text(std::string_view column) const;
  /// As numbers; NaN if a field is not a number.
  Column numbers(std::string_view column) const;
  /// Nanoseconds as seconds.
  Column seconds(std::string_view column) const;
  /// Time stamps. Throws FileError if a field is none.
  std::vector<slam::Stamp> stamps(std::string_view column) const;

 private:
  fs::path file_;
  std::size_t rows_ = 0;
  std::map<std::string, std::vector<std::string>, std::less<>> columns_;
};

/// A trajectory as columns: time (s) and position (m); NaN where there is none.
struct Path {
  Column t, x, y, z;
};

/// Errors of the frames (FrameError) as columns, in SI units; NaN where there is none.
struct Errors {
  Column t;
  std::array<Column, 4> error, sigma;  ///< x, y, z, yaw
  Column distance;
  Column nees_position, nees_orientation;
};

/// A result folder. Parts that the run did not leave (no filter, no camera) are absent.
struct RunData : result::SeedScore {
  std::string alignment = "none";  ///< of the estimate with the truth before it was scored
  fs::path folder;
  fs::path recording;  ///< its own, if it is finished; else empty
  result::About about;
  std::optional<double> frame_cpu_ms_mean, frame_cpu_ms_median, frame_cpu_ms_p99;  ///< a batch command: mean
  Path truth, plan, waist_truth, waist_plan;
  bool truth_aligned = false;  ///< of positions only: drawn as an SE(3) alignment puts it onto the estimate
  std::optional<Path> estimate;
  std::optional<Path> waist_estimate;  ///< of a steered walk, like waist_desired and corrected_steps
  std::optional<Path> waist_desired;
  std::optional<Errors> errors;
  std::optional<Path> odometry;  ///< by the same sensors without images
  Column odometry_error;         ///< its distance from the truth, m
  std::optional<Table> filter_frames, feet, frame_times, corrected_steps, answers;
  std::vector<Frame> frames;  ///< truth, plan, estimate, report and map, without images

  /// "tangent_circle, seed 1", followed by the estimator unless that is the filter, and by its alignment.
  std::string label() const;
};

/// The alignment of a result's estimate with the truth before it was scored; "none" without one.
std::string alignment_of(const result::About& about);
/// The column of a metric in tables over several results: "rmse_m_after_sim3" if it depends on the alignment.
std::string column_of(const std::string& metric, const std::string& alignment);

/// Throws FileError if the folder is not a result, a file is missing or broken, or its recording was edited.
RunData read_run(const fs::path& result_folder);

}  // namespace sim::pages
