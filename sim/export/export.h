// A recorded run in the file formats of other SLAM programs: what the filter was given, noise included, with
// the settings each program needs and a README that says how it is started.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/export/exported_run.h"
#include "sim/files/atomic_file.h"

namespace sim::exports {

/// The names of the formats.
const std::vector<std::string>& export_formats();

/// Makes the folder, which appears complete or not at all. Memory does not grow with the run's length. Throws
/// std::out_of_range where there is no such format, FileError where a file cannot be read or written.
void export_run(const ExportedRun& run, const std::string& format, const std::filesystem::path& folder,
                files::Existing existing);

}  // namespace sim::exports
