#include "sim/world/ground.h"

#include <cmath>

namespace sim::world {

double friction_at(const Eigen::Vector2d& p_W, double elsewhere, const std::vector<FloorPatch>& patches) {
  double friction = elsewhere;
  for (const FloorPatch& patch : patches) {
    const bool inside = p_W.x() >= patch.x_min_m && p_W.x() <= patch.x_max_m && p_W.y() >= patch.y_min_m &&
                        p_W.y() <= patch.y_max_m;
    if (inside) friction = patch.friction;
  }
  return friction;
}

double height_at(const Eigen::Vector2d& p_W, const std::vector<FloorWave>& waves) {
  double height = 0;
  for (const FloorWave& wave : waves)
    height += wave.amplitude_m * std::cos(wave.k_1_m.dot(p_W) + wave.phase_rad);
  return height;
}

}  // namespace sim::world
