#include "walking/second_preview.h"

#include <algorithm>
#include <utility>

#include "walking/swing_foot.h"

namespace walking {

SecondPreview::SecondPreview(WholeBody model, const CartTable& cart, const PreviewGains& gains)
    : model_(std::move(model)),
      horizon_(static_cast<int>(gains.preview.size())),
      errors_(horizon_),
      control_(cart, gains, Eigen::Vector2d::Zero()) {}

void SecondPreview::push(const Reference& planned) {
  const BodyPose pose = pose_of(planned);
  if (planned_.empty()) pose_ = pose;
  const BodyMomentum momentum = model_(motion_between(pose_, pose));
  if (!planned_.empty()) push_error(planned_.back().zmp_reference - multibody_zmp(momentum_, momentum));
  pose_ = pose;
  momentum_ = momentum;
  planned_.push_back(planned);
}

/// The constant error of standing (the model's center of mass differs from the plan's) is faded in over a
/// preview, so that the walk starts in half-sitting.
void SecondPreview::push_error(const Eigen::Vector2d& error) {
  const double share = quintic_blend(std::min(1.0, static_cast<double>(errors_pushed_++) / horizon_));
  errors_.push(share * error);
}

Reference SecondPreview::pop() {
  const Reference corrected = shifted(planned_.front(), control_.state(), control_.zmp());
  control_.advance(errors_);
  errors_.pop();
  planned_.pop_front();
  return corrected;
}

Reference shifted(Reference reference, const PreviewControl::State& state, const Eigen::Vector2d& zmp) {
  const auto horizontal = [&](int row) { return Eigen::Vector3d(state(row, 0), state(row, 1), 0); };
  reference.com += horizontal(0);
  reference.com_velocity += horizontal(1);
  reference.com_acceleration += horizontal(2);
  reference.zmp += zmp;
  reference.X_PB.translation() += horizontal(0);
  reference.waist_velocity += horizontal(1);
  return reference;
}

}  // namespace walking
