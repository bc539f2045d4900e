#include "sim/physics/clearance.h"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "sim/model_file/model_file.h"
#include "sim/physics/actors.h"
#include "sim/physics/nominal_body.h"

namespace sim::physics {
namespace {

constexpr int kSolidGroup = 0;
constexpr double kFloor = 0.01;  // m: anything lower is part of the floor, such as a rug or a threshold
constexpr double kSheet = 0.02;  // m, thickness of a plane; the furniture behind a picture is thicker
constexpr int kContacts = 1000;

// MuJoCo's planes fill the half-space behind them; this one is limited to its drawn size.
void make_sheet(mjModel& model, int geom) {
  const Eigen::Vector3d half = half_extents(model, geom) + Eigen::Vector3d(0, 0, kSheet / 2);
  const mjtNum behind[3] = {0, 0, -kSheet / 2};
  mjtNum shift[3];
  mju_rotVecQuat(shift, behind, model.geom_quat + 4 * geom);
  mju_addTo3(model.geom_pos + 3 * geom, shift);
  model.geom_type[geom] = mjGEOM_BOX;
  Eigen::Map<Eigen::Vector3d>(model.geom_size + 3 * geom) = half;
  model.geom_rbound[geom] = half.norm();
  model.geom_sameframe[geom] = 0;
}

}  // namespace

RoomClearance::RoomClearance(Model in_room, double margin_m) : model_(std::move(in_room)), margin_(margin_m) {
  mjModel& m = *model_;
  m.nconmax = kContacts;
  data_.reset(mj_makeData(&m));
  pose_bodies(m, *data_);
  for (int geom = 0; geom < m.ngeom; ++geom) {
    const bool is_floor = m.geom_contype[geom] == model_file::kSteppedBits;
    const bool is_solid = (m.geom_contype[geom] | m.geom_conaffinity[geom]) != 0;
    m.geom_contype[geom] = m.geom_conaffinity[geom] = 0;
    m.geom_condim[geom] = 1;
    m.geom_margin[geom] = 0;
    if (is_robot(geom)) {
      m.geom_conaffinity[geom] = 1;
      robot_.push_back(geom);
    } else if (m.geom_group[geom] == kSolidGroup && is_solid && !is_floor) {
      const Eigen::AlignedBox3d box = box_around(m, *data_, geom);
      if (box.max().z() < kFloor) continue;
      if (m.geom_type[geom] == mjGEOM_PLANE) make_sheet(m, geom);
      m.geom_margin[geom] = margin_;
      solids_.push_back({geom, box, is_actor(m, geom)});
    }
  }
}

bool RoomClearance::is_robot(int geom) const { return model_->body_weldid[model_->geom_bodyid[geom]] != 0; }

Eigen::AlignedBox3d RoomClearance::robot_box() const {
  Eigen::AlignedBox3d box;
  for (const int geom : robot_) {
    const Eigen::Vector3d center(data_->geom_xpos + 3 * geom);
    const Eigen::Vector3d radius = Eigen::Vector3d::Constant(model_->geom_rbound[geom]);
    box.extend(center - radius).extend(center + radius);
  }
  return box;
}

// Enables only the solids within range. Returns a lower bound on the distance to the others.
double RoomClearance::select_near(const Eigen::AlignedBox3d& robot) {
  double others = std::numeric_limits<double>::infinity();
  for (const Solid& solid : solids_) {
    const double distance = robot.exteriorDistance(solid.box);
    const bool near = distance <= margin_;
    model_->geom_contype[solid.geom] = near;
    constexpr double kOfActors = kFastest_m_s / (kFastest_m_s + kFastestActor_m_s);
    if (!near) others = std::min(others, distance * (solid.moves ? kOfActors : 1));
  }
  return others;
}

// MuJoCo is exact about contacts within the margin, but its distances are off by centimeters for ellipsoids
// and cylinders. They only decide which shape is named.
Clearance RoomClearance::at(const double* positions, double t_s) {
  std::copy_n(positions, model_->nq, data_->qpos);
  data_->time = t_s;
  pose_bodies(*model_, *data_);
  for (Solid& solid : solids_)
    if (solid.moves) solid.box = box_around(*model_, *data_, solid.geom);
  const double others = select_near(robot_box());
  const auto is_near = [this](const Solid& solid) { return model_->geom_contype[solid.geom] != 0; };
  if (std::ranges::none_of(solids_, is_near)) return {others, {}};
  mj_collision(model_.get(), data_.get());
  const mjContact* const end = data_->contact + data_->ncon;
  const mjContact* const deepest = std::min_element<const mjContact*>(
      data_->contact, end, [](const mjContact& a, const mjContact& b) { return a.dist < b.dist; });
  if (deepest == end) return {margin_, {}};
  const bool first = is_robot(deepest->geom1);
  return {0, collision(first ? deepest->geom1 : deepest->geom2, first ? deepest->geom2 : deepest->geom1,
                       Eigen::Vector3d(deepest->pos))};
}

Collision RoomClearance::collision(int robot_geom, int room_geom, const Eigen::Vector3d& p_W) const {
  const mjModel& m = *model_;
  std::string object = name_of(m, mjOBJ_GEOM, room_geom);
  const int body = m.geom_bodyid[room_geom];
  if (object.empty() && body != 0) object = name_of(m, mjOBJ_BODY, body);
  if (object.empty()) object = name_of(m, mjOBJ_MATERIAL, m.geom_matid[room_geom]);
  if (object.empty()) object = "the room";
  return {name_of(m, mjOBJ_BODY, m.geom_bodyid[robot_geom]), object, p_W};
}

std::optional<PlannedCollision> first_collision(walking::PatternGenerator plan, Model in_room) {
  RoomClearance room(std::move(in_room), kPlannedMargin_m);
  walking::JointVector q = plan.robot().posture;
  double looked_at_s = 0, free_s = 0;  // free_s: time during which nothing can come near
  for (std::size_t tick = 0; tick < plan.ticks(); ++tick) {
    const walking::Reference reference = plan.next();
    if (tick != 0 && reference.t_s < looked_at_s + free_s) continue;
    const walking::BodyPose pose = walking::pose_of(plan.robot(), reference, q);
    q = pose.q;
    const Eigen::VectorXd positions = robot_positions(room.model(), pose);
    const Clearance clearance = room.at(positions.data(), reference.t_s);
    if (clearance.collision) return PlannedCollision{*clearance.collision, reference.t_s, reference.command};
    looked_at_s = reference.t_s;
    free_s = (clearance.distance_m - kPlannedMargin_m) / kFastest_m_s;
  }
  return std::nullopt;
}

}  // namespace sim::physics
