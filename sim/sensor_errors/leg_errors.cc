#include "sim/sensor_errors/leg_errors.h"

#include "sim/sensor_errors/random.h"

namespace sim::sensor_errors {

void LegErrors::apply(slam::LegMotion& legs, slam::Stamp t) {
  auto p_OC = legs.X_OC.translation();
  if (!first_p_OC_) first_p_OC_ = p_OC;
  if (scale_fraction_ != 0) p_OC.head<2>() += scale_fraction_ * (p_OC - *first_p_OC_).head<2>();
  if (sigma_m_ == 0) return;
  Random random(seed_, "leg odometry", static_cast<std::uint64_t>(t.count()));
  for (int axis = 0; axis < 3; ++axis) p_OC(axis) += sigma_m_ * random.normal();
}

}  // namespace sim::sensor_errors
