#include "sim/recording/recording_format.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace sim::recording {

using recording_format::kSupport;

namespace {

constexpr double kLargestReading = 1e7;  // rad/s, m/s^2: ten times the largest spike that a scenario may have

Eigen::Vector3d reading(const files::CsvReader& row, const std::vector<files::Column>& columns,
                        const char* sensor, const char* unit) {
  Eigen::Vector3d values;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double value = columns[axis].factor * row.number(columns[axis].field);
    if (std::abs(value) > kLargestReading)
      row.fail(columns[axis].field, fmt::format("{0}: {1} {2}, expected from -{3:.0f} to {3:.0f} {2}", sensor,
                                                value, unit, kLargestReading));
    values[static_cast<Eigen::Index>(axis)] = value;
  }
  return values;
}

using Joints = std::vector<std::string>;

}  // namespace

void StampedRows::advance() {
  const std::optional<slam::Stamp> before = std::exchange(stamp_, std::nullopt);
  if (!csv_.next()) return;
  const auto t = files::parse_stamp(csv_.text(field_), unit_);
  if (!t || t->count() < 0) csv_.fail(field_, "expected a stamp from 0 to 9000000000000000000 ns");
  stamp_ = *t - epoch_;
  if (before && *stamp_ <= *before) csv_.fail(field_, "the stamp is not after the one before");
}

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
  constexpr std::size_t kLegs = 23;  // field; external files may have columns of their own there
  if (row.titles().size() >= kLegs + 15 && row.titles()[kLegs].starts_with("p_OC_x"))
    plan.legs = slam::LegMotion{row.pose(kLegs), row.vector(kLegs + 12)};
  return plan;
}

Eigen::Vector3d angular_rate(const files::CsvReader& row, const std::vector<files::Column>& columns) {
  return reading(row, columns, "gyroscope", "rad/s");
}
Eigen::Vector3d acceleration(const files::CsvReader& row, const std::vector<files::Column>& columns) {
  return reading(row, columns, "accelerometer", "m/s^2");
}

const std::vector<BodySensor>& body_sensors() {
  static const std::vector<BodySensor> all{
      {"encoders0", "encoders", "joint encoders, ideal: their zeros may be off those of the true joints",
       [](const Joints& joints) { return fmt::format("joints: [{}]\n", fmt::join(joints, ", ")); },
       [](const Joints& joints) {
         std::string columns;
         for (const std::string& joint : joints) columns += "," + joint + " [rad]";
         return columns;
       },
       [](const BodyReading& reading) {
         std::string fields;
         for (const double angle : reading.q) fields += fmt::format(",{}", angle);
         return fields;
       }},
      {"forces0", "forces",
       "six-axis force sensors of the ankles, ideal: force and torque of the ground on each foot, axes of "
       "the sole, about the point of the sole below the ankle",
       [](const Joints&) { return std::string("feet: [left, right]\n"); },
       [](const Joints&) {
         return std::string(
             ",f_L_x [N],f_L_y [N],f_L_z [N],m_L_x [N m],m_L_y [N m],m_L_z [N m]"
             ",f_R_x [N],f_R_y [N],f_R_z [N],m_R_x [N m],m_R_y [N m],m_R_z [N m]");
       },
       [](const BodyReading& reading) {
         std::string fields;
         for (const BodyReading::Wrench& foot : {reading.left, reading.right})
           fields += "," + files::csv_fields(foot.force) + "," + files::csv_fields(foot.torque);
         return fields;
       }},
  };
  return all;
}

}  // namespace sim::recording
