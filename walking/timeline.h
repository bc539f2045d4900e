// The walk in time: support phases of whole ticks, each with where feet, waist yaw and ZMP begin and end.
#pragma once

#include <cstddef>
#include <vector>

#include "walking/footsteps.h"

namespace walking {

/// Width of the window that smooths the ZMP reference (zmp_reference.h), 50 ms. The walk begins with as much
/// standing as the preview and this window take together.
inline constexpr int kSmoothingTicks = 10;

/// A part of the walk with the same support.
struct Phase {
  int command = 0;  ///< index into WalkOptions::commands
  Support support = Support::both;
  int ticks = 0;    ///< of kPeriod
  Stance from, to;  ///< the feet; only the swinging one differs
  double waist_yaw_from = 0, waist_yaw_to = 0;
  Eigen::Vector2d zmp_from = Eigen::Vector2d::Zero(), zmp_to = Eigen::Vector2d::Zero();
  int zmp_ramp_ticks = 1;  ///< ZMP goes from zmp_from to zmp_to in this many ticks, then stays
  int zmp_ramp_start = 0;  ///< 1 where the phase's first sample is already on its way

  Eigen::Vector2d zmp(int tick) const;  ///< the unsmoothed reference at a tick of the phase
};

/// The whole walk as phases, in order, with the standing that the preview needs before the first and after
/// the last step.
class Timeline {
 public:
  /// Feet together around `start`, in P. `zmp_in_foot`: the place of the ZMP under a support sole, in
  /// its axes, m. Throws std::invalid_argument naming the option when the commands cannot be carried out.
  Timeline(const WalkOptions& options, const FootPose& start, const Eigen::Vector2d& zmp_in_foot);

  std::size_t ticks() const { return begins_.back(); }
  const std::vector<Phase>& phases() const { return phases_; }

  struct Moment {
    const Phase& phase;
    int tick;  ///< within the phase
  };
  /// Where in the walk `tick` is; before the first tick the first, after the last one the last.
  Moment at(std::ptrdiff_t tick) const;

 private:
  void carry_out(int command, const WalkOptions& options, int least_standing);
  void stand(int command, int ticks);
  void step(int command, const Footstep& step, const WalkOptions& options);
  Phase next_phase(int command, Support support, int ticks) const;
  void append(Phase phase);
  Eigen::Vector2d zmp_under(const FootPose& foot) const;

  Eigen::Vector2d zmp_in_foot_;
  Stance stance_;  // where the phases so far end
  double waist_yaw_ = 0;
  Eigen::Vector2d zmp_ = Eigen::Vector2d::Zero();
  int stop_ramp_ticks_ = 1;
  std::vector<Phase> phases_;
  std::vector<std::size_t> begins_{0};  // first tick of each phase, then the number of all
};

}  // namespace walking
