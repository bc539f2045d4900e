#include "sim/physics/arrangement.h"

#include <mujoco/mujoco.h>

#include <random>

#include "sim/model_file/model_file.h"

namespace sim::physics {
namespace {

using Eigen::Isometry3d;

// What people move: furniture that stands on the floor and is not larger than this.
constexpr double kHighest_m = 1.3, kWidest_m = 1.1, kAboveFloor_m = 0.1;

Isometry3d turned(double yaw_rad) { return Isometry3d(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ())); }

/// Moves the pose in MuJoCo's arrays from the left.
void move(const Isometry3d& X, mjtNum* position, mjtNum* quaternion) {
  const Isometry3d moved = X * turned_pose_in(position, quaternion);
  const Eigen::Quaterniond q(moved.linear());
  Eigen::Map<Eigen::Vector3d>(position, 3) = moved.translation();
  Eigen::Map<Eigen::Vector4d>(quaternion, 4) << q.w(), q.vec();
}

/// The bodies of the room, which have no joint.
std::vector<int> room_bodies(const mjModel& m) {
  std::vector<int> bodies;
  for (int body = 1; body < m.nbody; ++body)
    if (m.body_parentid[body] == 0 && m.body_weldid[body] == 0) bodies.push_back(body);
  return bodies;
}

/// Returns the box around a piece of furniture that people move, and an empty box for other bodies.
Eigen::AlignedBox3d box_around_furniture(const mjModel& m, const mjData& data, int body) {
  Eigen::AlignedBox3d box;
  for (int geom = 0; geom < m.ngeom; ++geom) {
    if (m.body_rootid[m.geom_bodyid[geom]] != body) continue;
    if (m.geom_contype[geom] == model_file::kSteppedBits) return {};  // part of the floor
    box.extend(box_around(m, data, geom));
  }
  const bool stands = !box.isEmpty() && std::abs(box.min().z()) < kAboveFloor_m;
  const bool small = stands && box.max().z() > kAboveFloor_m && box.max().z() < kHighest_m &&
                     box.sizes().head<2>().maxCoeff() < kWidest_m;
  return small ? box : Eigen::AlignedBox3d();
}

void move_furniture(mjModel& m, const WorldOptions::Moved& moved) {
  std::mt19937_64 random(moved.seed);
  const auto within = [&](double largest) { return largest * (0x1p-52 * double(random() >> 11) - 1); };
  const Data data(mj_makeData(&m));
  mj_kinematics(&m, data.get());
  for (const int body : room_bodies(m)) {
    const Eigen::AlignedBox3d box = box_around_furniture(m, *data, body);
    if (box.isEmpty()) continue;
    const Eigen::Vector3d shift(within(moved.largest_m), within(moved.largest_m), 0);
    const Eigen::Vector3d center(box.center().x(), box.center().y(), 0);
    const Isometry3d X = Eigen::Translation3d(center + shift) * turned(within(moved.largest_rad)) *
                         Eigen::Translation3d(-center);
    move(X, m.body_pos + 3 * body, m.body_quat + 4 * body);
  }
}

void move_room(mjModel& m, const Isometry3d& X) {
  for (const int body : room_bodies(m)) move(X, m.body_pos + 3 * body, m.body_quat + 4 * body);
  for (int geom = 0; geom < m.ngeom; ++geom) {
    if (m.geom_bodyid[geom] != 0) continue;
    move(X, m.geom_pos + 3 * geom, m.geom_quat + 4 * geom);
    m.geom_sameframe[geom] = 0;
  }
}

void light(mjModel& m, double level, double turn_rad) {
  const Eigen::Matrix3d R = turned(turn_rad).linear();
  for (int i = 0; i < m.nlight; ++i) {
    Eigen::Map<Eigen::Vector3d> direction(m.light_dir + 3 * i);
    if (m.light_bodyid[i] == 0) direction = R * direction.eval();
    for (float* const color : {m.light_diffuse, m.light_ambient})
      Eigen::Map<Eigen::Vector3f>(color + 3 * i) *= float(level);
  }
  Eigen::Map<Eigen::Vector3f>(m.vis.headlight.ambient) *= float(level);
}

}  // namespace

Model arranged(Model model, const WorldOptions& world) {
  const WorldOptions::Start& start = world.start;
  if (world.moved.seed != 0) move_furniture(*model, world.moved);
  if (!start.is_default()) move_room(*model, start.X_RW().inverse());
  if (world.light.level != 1 || world.light.turn_rad != 0 || start.yaw_rad != 0)
    light(*model, world.light.level, world.light.turn_rad - start.yaw_rad);
  return model;
}

}  // namespace sim::physics
