// One row of plan0/data.csv: the planned motion of the camera at a frame, written and read.
#pragma once

#include <string>

#include "sim/files/csv.h"
#include "slam/observation.h"

namespace sim::recording {

/// The header of the rows of plans like this one: all of a file have leg odometry, or none has.
const std::string& plan_header(const slam::PlannedMotion& plan);

/// The fields of a row under its header that follow its stamp; the same bits are read back.
std::string plan_fields(const slam::PlannedMotion& plan);

/// The plan of a row under either header. Throws FileError.
slam::PlannedMotion read_plan_row(const files::CsvReader& row);

}  // namespace sim::recording
