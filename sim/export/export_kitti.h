// The layout of the KITTI odometry benchmark, with undistorted images.
#pragma once

#include "sim/export/export_context.h"

namespace sim::exports {

void export_kitti(const ExportContext& out);

}  // namespace sim::exports
