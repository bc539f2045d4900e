// Polynomials from 0 to 1 that start and end at rest; what moves in the plan between two places moves along
// one of them.
#pragma once

namespace walking {

/// 3s² - 2s³ for s in [0, 1]: velocity zero at both ends, acceleration not.
constexpr double cubic_blend(double s) { return s * s * (3 - 2 * s); }

/// Derivative of cubic_blend by s.
constexpr double cubic_blend_rate(double s) { return 6 * s * (1 - s); }

/// 10s³ - 15s⁴ + 6s⁵ for s in [0, 1]: velocity and acceleration zero at both ends.
constexpr double quintic_blend(double s) { return s * s * s * (10 + s * (6 * s - 15)); }

}  // namespace walking
