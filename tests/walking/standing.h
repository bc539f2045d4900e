// The robot standing in half-sitting, as planned.
#pragma once

#include "walking/hrp2.h"
#include "walking/plan.h"

namespace walking {

/// Feet together, the ZMP under the center of mass.
inline Reference standing() {
  Reference reference;
  reference.com = hrp2::kComInWaist + Eigen::Vector3d(0, 0, hrp2::kWaistHeight);
  reference.zmp = reference.zmp_reference = reference.com.head<2>();
  reference.X_PB.translation().z() = hrp2::kWaistHeight;
  reference.X_PL.translation() << hrp2::kAnkleX, hrp2::kFootSpacing / 2, 0;
  reference.X_PR.translation() << hrp2::kAnkleX, -hrp2::kFootSpacing / 2, 0;
  return reference;
}

/// `reference` seen from elsewhere.
inline Reference moved(const Eigen::Isometry3d& X, Reference reference) {
  for (auto* pose : {&reference.X_PB, &reference.X_PL, &reference.X_PR}) *pose = X * *pose;
  return reference;
}

}  // namespace walking
