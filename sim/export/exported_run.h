// The run that an export is made of.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "sim/sensor_errors/sensor_errors.h"

namespace sim::exports {

/// A recorded run. result: its folder, with recording/ and, if a filter was run, estimate_cov.txt.
struct ExportedRun {
  std::filesystem::path result;
  std::string name;  ///< of the scenario
  std::uint64_t seed = 1;
  sensor_errors::ErrorOptions errors;
  bool with_truth = true;  ///< else neither true poses nor those of the filter are in the export
  bool undistort = false;  ///< remove the lens distortion from the images also where the format knows lenses
};

}  // namespace sim::exports
