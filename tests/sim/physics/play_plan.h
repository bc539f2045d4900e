// A plan played through a model of the whole body, without physics.
#pragma once

#include "walking/kinematics.h"
#include "walking/pattern_generator.h"

namespace walking {

/// Calls each(reference, before, after) at each tick but the first and the last: `before` and `after` are the
/// momenta half a tick before and after it.
template <typename Each>
void play(PatternGenerator plan, const WholeBody& body, const Each& each) {
  Reference before = plan.next(), now = plan.next();
  BodyMomentum first = body(motion_between(pose_of(before), pose_of(now)));
  for (std::size_t k = 2; k < plan.ticks(); ++k) {
    const Reference after = plan.next();
    const BodyMomentum second = body(motion_between(pose_of(now), pose_of(after)));
    each(now, first, second);
    now = after;
    first = second;
  }
}

/// The reference of the ZMP minus the whole body's, in the waist's axes, m.
inline Eigen::Vector2d zmp_error(const Reference& now, const BodyMomentum& before,
                                 const BodyMomentum& after) {
  return now.X_PB.linear().topLeftCorner<2, 2>().transpose() *
         (now.zmp_reference - multibody_zmp(before, after));
}

/// Moment about the vertical through the centre of mass, N·m.
inline double yaw_moment(const BodyMomentum& before, const BodyMomentum& after) {
  return (after.angular.z() - before.angular.z()) / kPeriod;
}

}  // namespace walking
