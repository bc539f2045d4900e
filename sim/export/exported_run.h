// The run that an export is made of.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "sim/export/robot_description.h"
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
  std::shared_ptr<const RobotDescription> robot = nullptr;  ///< null: viewers draw none
  std::function<void(double)> progress = [](double) {};     ///< called with the part that is done, 0 to 1
};

}  // namespace sim::exports
