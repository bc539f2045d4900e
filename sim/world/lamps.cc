#include "sim/world/lamps.h"

#include <algorithm>
#include <stdexcept>

namespace sim::world {
namespace {

Eigen::Vector3f rgb(const float* values) { return Eigen::Map<const Eigen::Vector3f>(values); }

// MuJoCo's rule: the colour of a geom counts where it has no material, or differs from the default.
bool own_colour(const mjModel& model, int geom) {
  const float* colour = model.geom_rgba + 4 * geom;
  return model.geom_matid[geom] < 0 || colour[0] != 0.5f || colour[1] != 0.5f || colour[2] != 0.5f ||
         colour[3] != 1.0f;
}

}  // namespace

Paint paint_of(const mjModel& model, int geom) {
  const int material = model.geom_matid[geom];
  return {rgb(own_colour(model, geom) ? model.geom_rgba + 4 * geom : model.mat_rgba + 4 * material),
          material < 0 ? 0 : model.mat_emission[material]};
}

Lamps::Lamps(const mjModel& model, const mjData& data) : ambient_(Eigen::Vector3f::Zero()) {
  if (model.vis.headlight.active) ambient_ = rgb(model.vis.headlight.ambient);
  for (int light = 0; light < model.nlight; ++light) {
    if (!model.light_active[light]) continue;
    if (!model.light_directional[light] || model.body_weldid[model.light_bodyid[light]] != 0)
      throw std::invalid_argument("a lamp is not directional or not fixed to the room: it cannot be drawn");
    ambient_ += rgb(model.light_ambient + 3 * light);
    lamps_.push_back({-Eigen::Map<const Eigen::Vector3d>(data.light_xdir + 3 * light).cast<float>(),
                      rgb(model.light_diffuse + 3 * light)});
  }
}

Eigen::Vector3f Lamps::lit(const Paint& paint, const Eigen::Vector3f& normal_W, float share) const {
  Eigen::Vector3f light = ambient_;
  for (const Lamp& lamp : lamps_) light += std::max(0.0f, normal_W.dot(lamp.towards_W)) * lamp.diffuse;
  light = (share * light).array() + paint.emission;
  return paint.rgb.cwiseProduct(light).cwiseMin(1);
}

}  // namespace sim::world
