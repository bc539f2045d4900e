// A recorded run in the file formats of other SLAM programs: what the filter saw, noise included, with the
// settings each program needs and a README that says how it is started.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "sim/stream/durable_file.h"
#include "sim/stream/sensor_errors.h"

namespace sim::stream {

/// By the order of kExportFormats.
enum class ExportFormat { euroc, tum, kitti, mcap, orbslam3, openvins, kalibr };
inline constexpr std::array<std::string_view, 7> kExportFormats{"euroc",    "tum",      "kitti", "mcap",
                                                                "orbslam3", "openvins", "kalibr"};

/// A run to be exported. result: its folder, with recording/ and, if a filter was run, estimate_cov.txt.
struct ExportedRun {
  std::filesystem::path result;
  std::string name;  ///< of the scenario
  std::uint64_t seed = 1;
  ErrorOptions errors;
  bool undistort = false;  ///< images as a pinhole would have seen them, also where the format knows lenses
};

/// Makes the folder; it appears whole or not at all. Memory does not grow with the run's length. Throws
/// FileError.
void export_run(const ExportedRun& run, ExportFormat format, const std::filesystem::path& folder,
                Existing existing);

}  // namespace sim::stream
