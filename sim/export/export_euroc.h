// The EuRoC/ASL layout.
#pragma once

#include "sim/export/export_context.h"

namespace sim::exports {

/// Writes mav0/ in the EuRoC/ASL layout, and times.txt.
void write_mav0(const ExportContext& out);

void export_euroc(const ExportContext& out);

}  // namespace sim::exports
