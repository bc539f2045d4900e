// The layout of the TUM RGB-D benchmark, with undistorted images.
#pragma once

#include "sim/export/export_context.h"

namespace sim::exports {

void export_tum(const ExportContext& out);

}  // namespace sim::exports
