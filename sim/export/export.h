// A recorded run in the file formats of other SLAM programs: the filter's input, noise included, with the
// settings that each program needs and a README with its command line.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/export/exported_run.h"
#include "sim/files/atomic_file.h"

namespace sim::exports {

/// The names of the formats.
const std::vector<std::string>& export_formats();

/// Writes the folder, completely or not at all. Memory does not grow with the run's length. Throws
/// std::out_of_range for an unknown format, FileError if a file cannot be read or written.
void export_run(const ExportedRun& run, const std::string& format, const std::filesystem::path& folder,
                files::Existing existing);

}  // namespace sim::exports
