#include "sim/stream/plan_row.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim/stream/recording_format.h"

namespace sim::stream {

using recording_format::kSupport;

std::string plan_row(std::int64_t stamp_ns, const slam::PlannedMotion& plan) {
  return fmt::format("{},{},{},{},{},{}\n", stamp_ns, csv_fields(plan.X_PC), csv_fields(plan.v_PC_C),
                     csv_fields(plan.w_PC_C), kSupport.at(static_cast<std::size_t>(plan.support)),
                     csv_fields(plan.p_CF));
}

slam::PlannedMotion read_plan_row(const CsvReader& row) {
  slam::PlannedMotion plan;
  plan.X_PC = row.pose(1);
  plan.v_PC_C = row.vector(13);
  plan.w_PC_C = row.vector(16);
  const auto support = std::find(kSupport.begin(), kSupport.end(), row.text(19));
  if (support == kSupport.end()) row.fail(19, "expected both, left or right");
  plan.support = static_cast<slam::Support>(support - kSupport.begin());
  plan.p_CF = row.vector(20);
  return plan;
}

}  // namespace sim::stream
