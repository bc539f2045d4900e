// The walk in time: support phases of whole ticks with feet, waist yaw and ZMP at their ends, the ZMP
// reference at every tick, and the motions of a step: swing foot, heading of the waist and swing of the arms.
#pragma once

#include "walking/footsteps.h"

namespace walking {

/// The window that smooths the ZMP reference, 50 ms. A walk first stands as long as it and the preview.
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
  int zmp_ramp_start = 0;  ///< 1: the first sample of the phase has already moved
};

/// The whole walk as phases, in order, with the standing that the preview needs at both ends.
class Timeline {
 public:
  /// Feet together around `start`, in P; `zmp_in_foot`: the place of the ZMP under a support sole, in its
  /// axes, m. Throws std::invalid_argument naming the option if the commands cannot be carried out, TooLong
  /// if they take more than kLongestWalk_s.
  Timeline(const Robot& robot, const WalkOptions& options, const FootPose& start,
           const Eigen::Vector2d& zmp_in_foot);

  std::size_t ticks() const { return begins_.back(); }
  const std::vector<Phase>& phases() const { return phases_; }

  std::size_t steps() const { return swings_.size(); }
  /// Which foot a step sets down, and where.
  Footstep landing(std::size_t step) const;
  /// The first tick of a step's single support, and the first tick after it.
  std::size_t lift_off(std::size_t step) const { return begins_[swings_[step]]; }
  std::size_t touch_down(std::size_t step) const { return begins_[swings_[step] + 1]; }
  /// The first tick of the standing that ends the walk.
  std::size_t final_standing() const { return begins_[phases_.size() - 1]; }

  /// Replaces the landings of all steps from `first` on, at least one unless first = steps(); the standing
  /// between them is kept.
  ///
  /// The walk ends after the last landing given. Additional landings are inserted before its final standing,
  /// which is interrupted at tick `free` if first = steps().
  void replan(std::size_t first, const std::vector<Footstep>& landings, std::size_t free);

  /// Start and end of a lap, in ticks.
  struct Lap {
    std::size_t begin, end;
  };
  /// The laps of each repeat, in order; none in a walk without repeat.
  const std::vector<Lap>& laps() const { return laps_; }
  /// Both feet at the start of a step.
  const Stance& stance_before(std::size_t step) const { return phases_[swings_[step]].from; }

  struct Moment {
    const Phase& phase;
    int tick;  ///< within the phase
  };
  /// Returns the phase of a tick; ticks outside the walk are clamped.
  Moment at(std::ptrdiff_t tick) const;

 private:
  void carry_out(const Robot& robot, int command, const WalkOptions& options, int least_standing);
  void repeat(const Robot& robot, int command, const WalkOptions& options);
  void stand(int command, int ticks);
  void step(int command, const Footstep& step);
  void truncate(std::size_t phases);
  Phase next_phase(int command, Support support, int ticks) const;
  void append(Phase phase);
  Eigen::Vector2d zmp_under(const FootPose& foot) const;

  Eigen::Vector2d zmp_in_foot_;
  double zmp_inwards_m_;
  Stance stance_;  // at the end of the phases so far
  double waist_yaw_ = 0;
  Eigen::Vector2d zmp_ = Eigen::Vector2d::Zero();
  int double_support_ticks_ = 1, single_support_ticks_ = 1, stop_ramp_ticks_ = 1;
  std::vector<Phase> phases_;
  std::vector<std::size_t> begins_{0};       // first tick of each phase, then the number of all
  std::vector<std::size_t> swings_;          // the phase of each step's single support
  std::vector<std::size_t> command_begins_;  // the first tick of each command
  std::vector<Lap> laps_;
};

inline constexpr int kSmoothingAdvance = 2;  ///< ticks the window looks ahead

/// w_i proportional to sin²(pi i / 10), sum 1: the smoothing of Kajita's and the JRL's pattern generators.
std::array<double, kSmoothingTicks + 1> smoothing_weights();

/// The ZMP reference at any tick, also beyond the walk, m in P: linear in double, constant in single support.
Eigen::Vector2d zmp_reference(const Timeline& timeline, std::ptrdiff_t tick);

/// sum_j w_j zmp_reference(tick - j + kSmoothingAdvance).
Eigen::Vector2d smoothed_zmp(const Timeline& timeline, std::ptrdiff_t tick);

/// 3s² - 2s³ for s in [0, 1]: velocity zero at both ends, acceleration not.
constexpr double cubic_blend(double s) { return s * s * (3 - 2 * s); }

/// 10s³ - 15s⁴ + 6s⁵ for s in [0, 1]: velocity and acceleration zero at both ends.
constexpr double quintic_blend(double s) { return s * s * s * (10 + s * (6 * s - 15)); }

/// Returns the swinging sole at `elapsed` (0 ... 1) of single support, in P; the heading follows a cubic
/// (Stasse et al. 2006, section II, and the JRL pattern generator). Horizontally it moves during the middle
/// 90 % (vertical take-off and landing), along `polynomial`; height is 16 h s² (1-s)².
Eigen::Isometry3d swing_foot(const FootPose& from, const FootPose& to, double elapsed, double step_height_m,
                             SwingPolynomial polynomial);

/// The sole of a foot at `height_m` above its place on the ground, in P.
Eigen::Isometry3d sole(const FootPose& foot, double height_m = 0);
/// Place and heading of a pose.
FootPose on_floor(const Eigen::Isometry3d& X);

struct WaistYaw {
  double yaw = 0;   ///< rad, never wrapped
  double rate = 0;  ///< rad/s
};

/// Cubic from the heading at the start of the phase to that at its end, `elapsed` in 0 ... 1 of the phase
/// (Stasse et al. 2006, section II: the waist turns in yaw only, on a third-order polynomial).
WaistYaw waist_yaw(const Phase& phase, double elapsed);

/// Returns the arm for a foot on its side that is `foot_ahead_m` ahead of the start posture: the hand goes
/// the other way by a share of that, at its height in the start posture (Stasse et al. 2006, section II: "arm
/// motion heuristic"; gain and geometry of the JRL pattern generator). The start posture for 0. The robot has
/// that arm, its forearm as long as the upper arm.
ArmAngles arm_swing(const Robot& robot, Side side, double foot_ahead_m);

/// Both arms for the feet of `reference`.
Arms arm_swing(const Robot& robot, const Reference& reference);

}  // namespace walking
