// The EuRoC/ASL layout.
#pragma once

#include "sim/export/export_context.h"

namespace sim::exports {

/// Writes mav0/ in the EuRoC/ASL layout, and times.txt. images_within_imu: without the images before the
/// first reading and after the last one.
void write_mav0(const ExportContext& out, bool images_within_imu = false);

void export_euroc(const ExportContext& out);

}  // namespace sim::exports
