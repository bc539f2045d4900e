// The settings file of ORB-SLAM3 (v1.0).
#pragma once

#include <string>

#include "sim/export/export_context.h"

namespace sim::exports {

/// settings.yaml, with the section of the IMU where its programs need one.
std::string orbslam3_settings(const ExportContext& out, bool with_imu);

}  // namespace sim::exports
