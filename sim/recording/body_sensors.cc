#include "sim/recording/body_sensors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/files/csv.h"

namespace sim::recording {
namespace {

using Joints = std::vector<std::string>;

std::string joint_columns(const Joints& joints) {
  std::string columns;
  for (const std::string& joint : joints) columns += "," + joint + " [rad]";
  return columns;
}

std::string joint_angles(const BodyReading& reading) {
  std::string fields;
  for (const double angle : reading.q) fields += fmt::format(",{}", angle);
  return fields;
}

std::string wrenches(const BodyReading& reading) {
  std::string fields;
  for (const BodyReading::Wrench& foot : {reading.left, reading.right})
    fields += "," + files::csv_fields(foot.force) + "," + files::csv_fields(foot.torque);
  return fields;
}

}  // namespace

const std::vector<BodySensor>& body_sensors() {
  static const std::vector<BodySensor> all{
      {"encoders0", "encoders", "joint encoders, ideal: their zeros may be off those of the true joints",
       [](const Joints& joints) { return fmt::format("joints: [{}]\n", fmt::join(joints, ", ")); },
       joint_columns, joint_angles},
      {"forces0", "forces",
       "six-axis force sensors of the ankles, ideal: force and torque of the ground on each foot, axes of "
       "the sole, "
       "about the point of the sole below the ankle",
       [](const Joints&) { return std::string("feet: [left, right]\n"); },
       [](const Joints&) {
         return std::string(
             ",f_L_x [N],f_L_y [N],f_L_z [N],m_L_x [N m],m_L_y [N m],m_L_z [N m]"
             ",f_R_x [N],f_R_y [N],f_R_z [N],m_R_x [N m],m_R_y [N m],m_R_z [N m]");
       },
       wrenches},
  };
  return all;
}

}  // namespace sim::recording
