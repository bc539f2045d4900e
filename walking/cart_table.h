// The cart-table model: a mass at constant height driven by its jerk, and the zero moment point it causes.
#pragma once

#include <Eigen/Core>

#include "walking/plan.h"

namespace walking {

/// One axis, state (position, velocity, acceleration), input jerk: x(k+1) = A x(k) + B u(k), ZMP p = C x
/// (Kajita et al. 2003; Stasse et al. 2006, eqs. (1) and (2)).
struct CartTable {
  /// `period` in s, `com_height` in m, `gravity` in m/s²; all positive.
  explicit CartTable(double com_height, double period = kPeriod, double gravity = kGravity);

  Eigen::Matrix3d A;
  Eigen::Vector3d B;
  Eigen::RowVector3d C;
};

}  // namespace walking
