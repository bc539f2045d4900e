#include "walking/zmp_reference.h"

#include <cmath>
#include <numbers>

namespace walking {

std::array<double, kSmoothingTicks + 1> smoothing_weights() {
  std::array<double, kSmoothingTicks + 1> w{};
  for (int i = 1; i < kSmoothingTicks; ++i) {
    const double s = std::sin(std::numbers::pi * i / kSmoothingTicks);
    w[i] = s * s / (kSmoothingTicks / 2.0);  // the squares sum to half the width
  }
  return w;
}

Eigen::Vector2d ZmpReference::raw(std::ptrdiff_t tick) const {
  const Timeline::Moment moment = timeline_.at(tick);
  return moment.phase.zmp(moment.tick);
}

Eigen::Vector2d ZmpReference::smoothed(std::ptrdiff_t tick) const {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (int j = 1; j < kSmoothingTicks; ++j) sum += weights_[j] * raw(tick - j + kSmoothingAdvance);
  return sum;
}

}  // namespace walking
