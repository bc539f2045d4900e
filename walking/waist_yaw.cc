#include "walking/waist_yaw.h"

#include "walking/blend.h"

namespace walking {

WaistYaw waist_yaw(const Phase& phase, double elapsed) {
  const double turn = phase.waist_yaw_to - phase.waist_yaw_from;
  return {phase.waist_yaw_from + turn * cubic_blend(elapsed),
          turn * cubic_blend_rate(elapsed) / (phase.ticks * kPeriod)};
}

}  // namespace walking
