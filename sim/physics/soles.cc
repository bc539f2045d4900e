#include "sim/physics/soles.h"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace sim::physics {
namespace {

constexpr std::array kSoleBodies{"LLEG_SOLE", "RLEG_SOLE"};

Eigen::Vector2d horizontal(const mjtNum* p) { return {p[0], p[1]}; }

// Friction force on a pad in W, and the velocity that MuJoCo's friction constraint has in steady state
// against it: with no acceleration the constraint's law, a + B v = -R f, leaves v = -R f / B.
struct Friction {
  Eigen::Vector2d place, creep_velocity;
};

Friction friction(const mjData& d, const mjContact& contact, double sign) {
  Friction result{horizontal(contact.pos), Eigen::Vector2d::Zero()};
  for (int i = 1; i < contact.dim; ++i) {
    const int row = contact.efc_address + i;
    const double velocity = -d.efc_R[row] * d.efc_force[row] / d.efc_KBIP[4 * row + 1];
    result.creep_velocity += sign * velocity * horizontal(contact.frame + 3 * i);
  }
  return result;
}

}  // namespace

Soles::Soles(mjModel& model, double friction, std::vector<FloorPatch> patches, std::vector<FloorWave> waves)
    : friction_(friction), patches_(std::move(patches)), waves_(std::move(waves)) {
  for (int foot = 0; foot < 2; ++foot) {
    const int body = mj_name2id(&model, mjOBJ_BODY, kSoleBodies[static_cast<std::size_t>(foot)]);
    const int first = body < 0 ? 0 : model.body_geomadr[body];
    for (int geom = first; body >= 0 && geom < first + model.body_geomnum[body]; ++geom)
      if (model.geom_type[geom] == mjGEOM_SPHERE) pads_.push_back({geom, foot, model.geom_pos[3 * geom + 2]});
  }
  if (pads_.empty()) throw std::runtime_error("the robot has no pads under its soles");
  for (const Pad& pad : pads_) model.geom_friction[3 * pad.geom] = friction_;
}

void Soles::apply_floor(mjModel& model, const mjData& data) const {
  if (patches_.empty() && waves_.empty()) return;
  for (const Pad& pad : pads_) {
    const Eigen::Vector2d place = horizontal(data.geom_xpos + 3 * pad.geom);
    model.geom_friction[3 * pad.geom] = friction_at(place, friction_, patches_);
    model.geom_pos[3 * pad.geom + 2] = pad.z - height_at(place, waves_);
  }
}

double Soles::lowest_pad(const mjModel& model, const mjData& data) const {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Pad& pad : pads_)
    lowest = std::min(lowest, data.geom_xpos[3 * pad.geom + 2] - model.geom_size[3 * pad.geom]);
  return lowest;
}

void Soles::add_contact_forces(const mjModel& model, const mjData& data) {
  for (std::size_t foot = 0; foot < 2; ++foot) add_contact_forces(model, data, foot);
  ++steps_;
}

void Soles::add_contact_forces(const mjModel& model, const mjData& data, std::size_t foot) {
  std::array<Friction, 16> pads;
  std::size_t n = 0;
  for (const mjContact* c = data.contact; c < data.contact + data.ncon && n < pads.size(); ++c) {
    const auto touches = [&](const Pad& pad) {
      return pad.foot == static_cast<int>(foot) && (pad.geom == c->geom1 || pad.geom == c->geom2);
    };
    const auto pad = std::find_if(pads_.begin(), pads_.end(), touches);
    if (pad == pads_.end() || c->efc_address < 0) continue;
    sum_[foot].load += data.efc_force[c->efc_address];
    pads[n++] = friction(data, *c, pad->geom == c->geom2 ? 1 : -1);
  }
  if (n == 0) return;
  // The rigid motion nearest to the motion of the pads.
  const double dt = model.opt.timestep, count = static_cast<double>(n);
  Eigen::Vector2d center = Eigen::Vector2d::Zero(), mean = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    center += pads[i].place / count;
    mean += pads[i].creep_velocity / count;
  }
  double turn = 0, spread = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d r = pads[i].place - center, v = pads[i].creep_velocity;
    turn += r.x() * v.y() - r.y() * v.x();
    spread += r.squaredNorm();
  }
  sum_[foot].creep += dt * mean;
  if (spread > 0) sum_[foot].creep_yaw += dt * turn / spread;
}

std::array<SoleContact, 2> Soles::since_last() {
  std::array<SoleContact, 2> last = std::exchange(sum_, {});
  for (SoleContact& foot : last) foot.load /= std::max(1, steps_);
  steps_ = 0;
  return last;
}

double friction_at(const Eigen::Vector2d& p_W, double elsewhere, const std::vector<FloorPatch>& patches) {
  double friction = elsewhere;
  for (const FloorPatch& p : patches)
    if (p_W.x() >= p.x_min_m && p_W.x() <= p.x_max_m && p_W.y() >= p.y_min_m && p_W.y() <= p.y_max_m)
      friction = p.friction;
  return friction;
}

double height_at(const Eigen::Vector2d& p_W, const std::vector<FloorWave>& waves) {
  double height = 0;
  for (const FloorWave& w : waves) height += w.amplitude_m * std::cos(w.k_1_m.dot(p_W) + w.phase_rad);
  return height;
}

}  // namespace sim::physics
