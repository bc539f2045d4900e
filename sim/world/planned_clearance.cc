#include "sim/world/planned_clearance.h"

#include "sim/world/robot_positions.h"

namespace sim::world {

std::optional<PlannedCollision> first_collision(walking::PatternGenerator plan, const WorldOptions& world,
                                                const std::filesystem::path& models) {
  RoomClearance room(world.robot, world.room, models, kPlannedMargin_m);
  double looked_at_s = 0, free_s = 0;  // free_s: for how long nothing can come near
  for (std::size_t tick = 0; tick < plan.ticks(); ++tick) {
    const walking::Reference reference = plan.next();
    if (tick != 0 && reference.t_s < looked_at_s + free_s) continue;
    const Eigen::VectorXd positions = robot_positions(room.model(), walking::pose_of(reference));
    const Clearance clearance = room.at(positions.data());
    if (clearance.collision) return PlannedCollision{*clearance.collision, reference.t_s, reference.command};
    looked_at_s = reference.t_s;
    free_s = (clearance.distance_m - kPlannedMargin_m) / kFastest_m_s;
  }
  return std::nullopt;
}

}  // namespace sim::world
