#include "sim/recording/recording_format.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <bit>
#include <cstring>
#include <type_traits>

namespace sim::recording {

using recording_format::kSupport;

namespace {

constexpr double kLargestReading = 1e7;  // rad/s, m/s^2: ten times the largest spike allowed in a scenario

Eigen::Vector3d reading(const files::Row& row, const std::vector<files::Column>& columns, const char* sensor,
                        const char* unit) {
  Eigen::Vector3d values;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double value = columns[axis].factor * row.number(columns[axis].field);
    if (std::abs(value) > kLargestReading)
      row.fail(columns[axis].field, "{0}: {1} {2}, expected from -{3:.0f} to {3:.0f} {2}", sensor, value,
               unit, kLargestReading);
    values[Eigen::Index(axis)] = value;
  }
  return values;
}

using Joints = std::vector<std::string>;

std::string plan_fields(const slam::Observation& o) {
  const slam::PlannedMotion& plan = *o.plan;
  return fmt::format("{},{},{},{},{}", files::csv_fields(plan.X_PC), files::csv_fields(plan.v_PC_C),
                     files::csv_fields(plan.w_PC_C), kSupport.at(std::size_t(plan.support)),
                     files::csv_fields(plan.p_CF));
}

std::string leg_fields(const slam::Observation& o) {
  return fmt::format("{},{},{}", files::csv_fields(o.legs->X_OC), files::csv_fields(o.legs->p_CS),
                     files::csv_fields(o.legs->X_CG.value()));
}

std::string command_fields(const slam::Observation& o) {
  const slam::CommandedVelocity& command = *o.command;
  return fmt::format("{},{},{},{}", (o.t - command.t).count(), command.ahead_m_s, command.left_m_s,
                     command.turn_rad_s);
}

void read_plan(const files::Row& row, slam::Observation& o) {
  slam::PlannedMotion& plan = o.plan.emplace();
  plan.X_PC = row.pose(1);
  plan.v_PC_C = row.vector(13);
  plan.w_PC_C = row.vector(16);
  const auto support = std::ranges::find(kSupport, row.text(19));
  if (support == kSupport.end()) row.fail(19, "expected both, left or right");
  plan.support = static_cast<slam::Support>(support - kSupport.begin());
  plan.p_CF = row.vector(20);
}

void read_legs(const files::Row& row, slam::Observation& o) {
  o.legs = slam::LegMotion{row.pose(1), row.vector(13), row.pose(16)};
}

void read_command(const files::Row& row, slam::Observation& o) {
  o.command =
      slam::CommandedVelocity{o.t - slam::Stamp(row.integer(1)), row.number(2), row.number(3), row.number(4)};
}

}  // namespace

void StampedRows::advance() {
  const std::optional<slam::Stamp> before = std::exchange(stamp_, std::nullopt);
  if (!csv_.next()) return;
  const slam::Stamp t(csv_.integer(0));
  if (t.count() < 0 || t.count() > 9'000'000'000'000'000'000)
    csv_.fail(0, "expected a stamp from 0 to 9000000000000000000 ns");
  stamp_ = t - epoch_;
  if (before && *stamp_ <= *before) csv_.fail(0, "{}", files::not_rising(*before, *stamp_));
}

const std::array<MotionSource, 3>& motion_sources() {
  using namespace recording_format;
  static const std::array<MotionSource, 3> all{
      {{"plan0", "walking plan: the camera's pose and velocities in the plan's own world", kPlanHeader,
        [](const slam::Observation& o) { return o.plan.has_value(); }, plan_fields, read_plan},
       {"legs0", "leg odometry: the camera's pose in a world of its own, and the sole that carries the robot",
        kLegHeader, [](const slam::Observation& o) { return o.legs.has_value(); }, leg_fields, read_legs},
       {"command0", "commanded velocity of the base in its heading, and how long ago it was commanded",
        kStampColumn + ",age [ns],v_x [m s^-1],v_y [m s^-1],w_z [rad s^-1]",
        [](const slam::Observation& o) { return o.command.has_value(); }, command_fields, read_command}}};
  return all;
}

std::string correction_fields(const score::StepCorrection& step) {
  return fmt::format(",{},{},{},{}", kSupport[step.left ? 1 : 2], files::csv_fields(step.desired),
                     files::csv_fields(step.expected),
                     files::csv_fields(Eigen::Vector3d(step.ahead, step.aside, step.turn)));
}

Eigen::Vector3d angular_rate(const files::Row& row, const std::vector<files::Column>& columns) {
  return reading(row, columns, "gyroscope", "rad/s");
}
Eigen::Vector3d acceleration(const files::Row& row, const std::vector<files::Column>& columns) {
  return reading(row, columns, "accelerometer", "m/s^2");
}

const RigFormat& format_of(rig::Kind kind) {
  static constexpr std::array<RigFormat, rig::kKinds.size()> kFormats{
      {{"camera", "gray camera, 8 bits", ".png", CV_8UC1, "an 8-bit gray image"},
       {"camera", "color camera, 8-bit RGB", ".png", CV_8UC3, "an 8-bit RGB image"},
       {"depth", "depth along the optical axis in mm, 16 bits; 0: none", ".png", CV_16UC1,
        "a 16-bit gray image"},
       {"lidar",
        "lidar, ideal; records of float32 x, y, z [m], float32 intensity, int32 time since the stamp [ns], "
        "little-endian",
        ".bin"},
       {"imu", "IMU, ideal: means over (previous stamp, stamp]; +g up at rest", ""}}};
  return kFormats.at(std::size_t(kind));
}

rig::RigSensor head_camera(const RecordingSetup& setup) {
  rig::RigSensor camera;
  camera.name = rig::kHeadCamera;
  camera.rate_hz = setup.camera_rate_hz, camera.camera = setup.calibration.camera;
  return camera;
}

static_assert(sizeof(slam::LidarPoint) == 20 && std::is_trivially_copyable_v<slam::LidarPoint> &&
                  std::endian::native == std::endian::little,
              "a point in memory is its record in a file");

std::string lidar_bytes(const std::vector<slam::LidarPoint>& points) {
  return {reinterpret_cast<const char*>(points.data()), points.size() * sizeof(slam::LidarPoint)};
}

std::vector<slam::LidarPoint> read_lidar(const fs::path& file, std::string_view bytes) {
  std::vector<slam::LidarPoint> points(bytes.size() / sizeof(slam::LidarPoint));
  if (bytes.size() % sizeof(slam::LidarPoint) != 0)
    throw files::FileError(file, "has {} bytes, expected a multiple of {}", bytes.size(),
                           sizeof(slam::LidarPoint));
  if (!points.empty()) std::memcpy(points.data(), bytes.data(), bytes.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    for (const float value : {points[i].x_m, points[i].y_m, points[i].z_m, points[i].intensity})
      if (!std::isfinite(value))
        throw files::FileError(file, "point {} (counting from 0): expected finite numbers", i);
  return points;
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
       },
       [](const files::CsvReader& row, BodyReading& reading) {
         reading.q.resize(Eigen::Index(row.fields()) - 1);
         for (std::size_t i = 1; i < row.fields(); ++i) reading.q[Eigen::Index(i) - 1] = row.number(i);
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
       },
       [](const files::CsvReader& row, BodyReading& reading) {
         reading.left = {row.vector(1), row.vector(4)};
         reading.right = {row.vector(7), row.vector(10)};
       }},
  };
  return all;
}

}  // namespace sim::recording
