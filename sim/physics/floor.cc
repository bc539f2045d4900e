#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/physics/world.h"

namespace sim::physics {
namespace {

constexpr double kAbove = 100;     // m: above every floor
constexpr double kUneven = 0.001;  // m from z = 0
constexpr int kPlaces = 5;         // places on a sole, along each side
const double kSteepest = std::tan(kSteepest_deg * std::numbers::pi / 180);

}  // namespace

Floor::Floor(const mjModel& on_floor) : model_(on_floor) {
  for (int geom = 0; geom < model_.ngeom; ++geom)
    if (model_.body_weldid[model_.geom_bodyid[geom]] == 0) geoms_.push_back(geom);
  if (geoms_.size() != 1) return;
  const int geom = geoms_[0];
  const mjtNum* const q = model_.geom_quat + 4 * geom;
  plain_ = model_.geom_type[geom] == mjGEOM_PLANE && model_.geom_bodyid[geom] == 0 &&
           model_.geom_pos[3 * geom + 2] == 0 && q[1] == 0 && q[2] == 0 &&
           model_.geom_friction[3 * geom] == 1;
}

std::optional<FloorPoint> Floor::at(const mjData& data, const Eigen::Vector2d& p_W) const {
  const Eigen::Vector3d from(p_W.x(), p_W.y(), kAbove), down(0, 0, -1);
  std::optional<FloorPoint> highest;
  for (const int geom : geoms_) {
    const double distance = ray_distance(model_, data, geom, from, down);
    if (distance >= 0 && (!highest || kAbove - distance > highest->z)) highest = {kAbove - distance, geom};
  }
  return highest;
}

double Floor::height(const mjData& data, const Eigen::Vector2d& p_W) const {
  return plain_ ? 0 : at(data, p_W).value_or(FloorPoint{}).z;
}

double Floor::friction(const mjData& data, const Eigen::Vector2d& p_W) const {
  const auto found = plain_ ? std::nullopt : at(data, p_W);
  return found ? model_.geom_friction[3 * found->geom] : 1;
}

std::size_t Floor::solids() const {
  return std::size_t(std::ranges::count_if(geoms_, [this](int geom) {
    return model_.geom_type[geom] != mjGEOM_PLANE && model_.geom_type[geom] != mjGEOM_HFIELD;
  }));
}

std::optional<UnevenStep> first_uneven_step(walking::PatternGenerator plan, const Model& on_floor,
                                            bool slopes) {
  const Floor floor(*on_floor);
  if (floor.is_plain()) return std::nullopt;
  const Data data(mj_makeData(on_floor.get()));
  mj_kinematics(on_floor.get(), data.get());
  std::array<Eigen::Isometry3d, 2> stood{};
  std::array<std::vector<Eigen::Vector3d>, 2> floors;  // below each sole
  for (std::size_t tick = 0; tick < plan.ticks(); ++tick) {
    const walking::Reference reference = plan.next();
    for (const walking::Side side : {walking::Side::left, walking::Side::right}) {
      const bool left = side == walking::Side::left;
      const Eigen::Isometry3d& X = left ? reference.X_PL : reference.X_PR;
      Eigen::Isometry3d& before = stood[left ? 0 : 1];
      if (reference.support == (left ? walking::Support::right : walking::Support::left) ||
          (tick > 0 && X.isApprox(before, 1e-9)))
        continue;
      before = X;
      const walking::Leg& leg = plan.robot().leg(side);
      std::vector<Eigen::Vector3d>&below = floors[left ? 0 : 1], &beside = floors[left ? 1 : 0];
      below.clear();
      for (int i = 0; i < kPlaces * kPlaces; ++i) {
        const Eigen::Array2d part(i % kPlaces / (kPlaces - 1.0), i / kPlaces / (kPlaces - 1.0));
        const Eigen::Vector2d in_sole = leg.sole_min.array() + part * (leg.sole_max - leg.sole_min).array();
        const Eigen::Vector2d place = (X * Eigen::Vector3d(in_sole.x(), in_sole.y(), 0)).head<2>();
        const auto found = floor.at(*data, place);
        const Eigen::Vector3d p_W(place.x(), place.y(), found ? found->z : 0);
        const auto fits = [&](const Eigen::Vector3d& other) {
          const double distance = (p_W - other).head<2>().norm();
          return std::abs(p_W.z() - other.z()) <= std::max(kHighestEdge_m, kSteepest * distance);
        };
        below.push_back(p_W);
        if (found && (slopes ? std::ranges::all_of(below, fits) && std::ranges::all_of(beside, fits)
                             : std::abs(found->z) <= kUneven))
          continue;
        return UnevenStep{reference.t_s, reference.command, left,
                          name_of(*on_floor, mjOBJ_GEOM, found ? found->geom : -1), p_W};
      }
    }
  }
  return std::nullopt;
}

}  // namespace sim::physics
