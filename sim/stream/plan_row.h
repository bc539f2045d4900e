// One row of plan0/data.csv: what the walking plan says of the camera at a frame, written and read.
#pragma once

#include <cstdint>
#include <string>

#include "sim/stream/csv.h"
#include "slam/observation.h"

namespace sim::stream {

/// The row under recording_format::kPlanHeader, line feed included; the same bits come back. stamp_ns: as it
/// is to be written.
std::string plan_row(std::int64_t stamp_ns, const slam::PlannedMotion& plan);

/// What plan_row wrote. Throws FileError.
slam::PlannedMotion read_plan_row(const CsvReader& row);

}  // namespace sim::stream
