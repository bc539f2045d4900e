// The second preview stage: shifts the planned center of mass so that the whole ZMP follows its reference.
#pragma once

#include <deque>

#include "walking/kinematics.h"
#include "walking/preview_control.h"

namespace walking {

/// The "dynamic filter" of Kajita et al. 2003: the cart-table's plan is played through a model of all links,
/// and the ZMP error found there, known a preview ahead, is the reference of a second preview control that
/// corrects the first.
class SecondPreview {
 public:
  SecondPreview(WholeBody model, const CartTable& cart, const PreviewGains& gains);

  /// The first stage's plan, tick by tick.
  void push(const Reference& planned);

  /// Returns whether enough ticks have been pushed to correct the next one: preview + 2.
  bool ready() const { return errors_.full(); }

  /// The next tick's reference, corrected.
  Reference pop();

 private:
  void push_error(const Eigen::Vector2d& error);

  WholeBody model_;
  int horizon_;
  PreviewWindow errors_;
  PreviewControl control_;
  std::deque<Reference> planned_;  // pushed and not popped
  BodyPose pose_;                  // of the last pushed
  BodyMomentum momentum_;          // half a tick before it
  int errors_pushed_ = 0;
};

/// `reference` with the waist and the center of mass in it moved by `state` (rows: position, velocity,
/// acceleration).
Reference shifted(Reference reference, const PreviewControl::State& state, const Eigen::Vector2d& zmp);

}  // namespace walking
