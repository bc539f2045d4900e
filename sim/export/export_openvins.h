// A ROS 2 bag with the configuration files of OpenVINS.
#pragma once

#include "sim/export/export_context.h"

namespace sim::exports {

void export_openvins(const ExportContext& out);

}  // namespace sim::exports
