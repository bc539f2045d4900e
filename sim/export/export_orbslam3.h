// The EuRoC/ASL layout with the settings of ORB-SLAM3.
#pragma once

#include "sim/export/export_context.h"

namespace sim::exports {

void export_orbslam3(const ExportContext& out);

}  // namespace sim::exports
