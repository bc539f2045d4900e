// What a report shows of one result folder: its files read, errors and normalised errors worked out by the
// score's own functions.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "sim/pages/table.h"
#include "sim/result/score_file.h"
#include "sim/score/trajectory.h"

namespace sim::pages {

/// One number per pose, or nothing to show.
using Column = std::vector<double>;

/// A trajectory as columns: time (s), position (m), yaw (rad).
struct Path {
  Column t, x, y, z, yaw;
};

/// Estimate minus truth at the estimate's stamps: axes of W, m and rad; sigma: what the filter believes of
/// each.
struct Errors {
  Column t;
  Column x, y, z, yaw;
  Column sigma_x, sigma_y, sigma_z, sigma_yaw;
  Column distance;  ///< m
  Column nees_position, nees_orientation;
};

/// A result folder as read. Parts that the run did not leave (no filter, no camera) are absent.
struct RunData {
  std::string label;  ///< "tangent_circle, seed 1", followed by the estimator where that is not the filter
  std::filesystem::path folder;
  std::filesystem::path recording;  ///< its own; of a replay nothing, unless who read it knows where it is
  nlohmann::ordered_json score;     ///< score.json, every value of the type that write_score() gives it
  result::About about;
  std::optional<double> frame_cpu_ms_median;
  std::string scenario_yaml;
  Path truth, plan, waist_truth, waist_plan;
  std::optional<Path> estimate;
  std::optional<Path> waist_estimate;  ///< of a steered walk, as waist_desired and corrected_steps
  std::optional<Path> waist_desired;
  std::optional<Errors> errors;
  std::optional<Table> frames, map, maps, searches, feet, frame_times, corrected_steps;

  /// The value of a metric, if it has one.
  std::optional<double> metric(const std::string& name) const;
};

/// Throws files::FileError: no result folder, or a file of it is missing or broken.
RunData read_run(const std::filesystem::path& result_folder);

}  // namespace sim::pages
