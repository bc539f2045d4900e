// A ROS 2 bag in an MCAP file.
#pragma once

#include "sim/export/export_context.h"

namespace sim::exports {

void export_mcap(const ExportContext& out);

}  // namespace sim::exports
