#include "sim/recording/plan_row.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim/recording/recording_format.h"

namespace sim::recording {

using recording_format::kSupport;

namespace {

constexpr std::size_t kFirstOfLegs = 23;  // field

/// Another program may have columns of its own after the plan's.
bool has_legs(const files::CsvReader& row) {
  return row.titles().size() >= kFirstOfLegs + 15 && row.titles()[kFirstOfLegs].starts_with("p_OC_x");
}

}  // namespace

const std::string& plan_header(const slam::PlannedMotion& plan) {
  return plan.legs ? recording_format::kPlanAndLegsHeader : recording_format::kPlanHeader;
}

std::string plan_fields(const slam::PlannedMotion& plan) {
  std::string fields =
      fmt::format("{},{},{},{},{}", files::csv_fields(plan.X_PC), files::csv_fields(plan.v_PC_C),
                  files::csv_fields(plan.w_PC_C), kSupport.at(static_cast<std::size_t>(plan.support)),
                  files::csv_fields(plan.p_CF));
  if (plan.legs)
    fields += fmt::format(",{},{}", files::csv_fields(plan.legs->X_OC), files::csv_fields(plan.legs->p_CS));
  return fields;
}

slam::PlannedMotion read_plan_row(const files::CsvReader& row) {
  slam::PlannedMotion plan;
  plan.X_PC = row.pose(1);
  plan.v_PC_C = row.vector(13);
  plan.w_PC_C = row.vector(16);
  const auto support = std::find(kSupport.begin(), kSupport.end(), row.text(19));
  if (support == kSupport.end()) row.fail(19, "expected both, left or right");
  plan.support = static_cast<slam::Support>(support - kSupport.begin());
  plan.p_CF = row.vector(20);
  if (has_legs(row)) plan.legs = slam::LegMotion{row.pose(kFirstOfLegs), row.vector(kFirstOfLegs + 12)};
  return plan;
}

}  // namespace sim::recording
