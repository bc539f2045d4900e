// The reference of the zero moment point at every tick: under the support foot, smoothed over 50 ms.
#pragma once

#include <Eigen/Core>
#include <array>

#include "walking/timeline.h"

namespace walking {

inline constexpr int kSmoothingAdvance = 2;  ///< ticks the window looks ahead

/// w_i proportional to sin²(pi i / 10), sum 1: the smoothing of Kajita's and the JRL's pattern generators.
std::array<double, kSmoothingTicks + 1> smoothing_weights();

/// The reference at any tick of a walk (before and after it: its first and last value), m in P.
class ZmpReference {
 public:
  explicit ZmpReference(const Timeline& timeline) : timeline_(timeline), weights_(smoothing_weights()) {}

  Eigen::Vector2d raw(std::ptrdiff_t tick) const;  ///< linear in double support, constant in single support
  Eigen::Vector2d smoothed(std::ptrdiff_t tick) const;  ///< sum_j w_j raw(tick - j + kSmoothingAdvance)

 private:
  const Timeline& timeline_;
  std::array<double, kSmoothingTicks + 1> weights_;
};

}  // namespace walking
