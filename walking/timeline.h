// The walk in time: support phases of whole ticks with feet, waist yaw and ZMP at both ends, the ZMP
// reference at every tick, and the motions of a step: the swing foot, the heading of the waist and the swing
// of the arms.
#pragma once

#include "walking/footsteps.h"

namespace walking {

/// The window that smooths the ZMP reference, 50 ms. A walk starts by standing for this window plus the
/// preview.
inline constexpr int kSmoothingTicks = 10;

/// A part of the walk during which the support does not change.
struct Phase {
  int command = 0;  ///< index in WalkOptions::commands
  Support support = Support::both;
  int ticks = 0;    ///< number of ticks of kPeriod
  Stance from, to;  ///< the feet; only the swinging one differs
  double waist_yaw_from = 0, waist_yaw_to = 0;
  Eigen::Vector2d zmp_from = Eigen::Vector2d::Zero(), zmp_to = Eigen::Vector2d::Zero();
  int zmp_ramp_ticks = 1;  ///< the ZMP goes from zmp_from to zmp_to in this many ticks, then stays
  int zmp_ramp_start = 0;  ///< 1: the first sample of the phase has already moved
};

/// The whole walk as a sequence of phases, including the time spent standing at both ends, which the preview
/// needs.
class Timeline {
 public:
  /// Starts with the feet together around `start`, in P. zmp_in_foot: the place of the ZMP under a support
  /// sole, in the axes of the sole, m. Throws std::invalid_argument that names the option if the commands
  /// cannot be carried out, and TooLong if they take more than kLongestWalk_s.
  Timeline(const Robot& robot, const WalkOptions& options, const FootPose& start,
           const Eigen::Vector2d& zmp_in_foot);

  std::size_t ticks() const { return begins_.back(); }
  const std::vector<Phase>& phases() const { return phases_; }

  std::size_t steps() const { return swings_.size(); }
  /// The foot that a step sets down, and where.
  Footstep landing(std::size_t step) const;
  /// The first tick of a step's single support, and the first tick after it.
  std::size_t lift_off(std::size_t step) const { return begins_[swings_[step]]; }
  std::size_t touch_down(std::size_t step) const { return begins_[swings_[step] + 1]; }
  /// The first tick of the final time spent standing.
  std::size_t final_standing() const { return begins_[phases_.size() - 1]; }

  /// Replaces the landings of all steps starting with `first`; there must be at least one unless first =
  /// steps(). Pauses between steps are kept.
  ///
  /// The walk ends after the last landing in `landings`. Additional landings are inserted before the final
  /// pause, which is interrupted at tick `free` if first = steps().
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
  /// Returns the phase of a tick. Ticks outside the walk are clamped to it.
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
  std::vector<std::size_t> begins_{0};       // first tick of each phase, then the total number
  std::vector<std::size_t> swings_;          // the phase of each step's single support
  std::vector<std::size_t> command_begins_;  // the first tick of each command
  std::vector<Lap> laps_;
};

inline constexpr int kSmoothingAdvance = 2;  ///< ticks the window looks ahead

/// w_i proportional to sin²(pi i / 10), sum 1: the smoothing of Kajita's and the JRL's pattern generators.
std::array<double, kSmoothingTicks + 1> smoothing_weights();

/// The ZMP reference at any tick, even outside the walk, m in P: linear in double support, constant in single
/// support.
Eigen::Vector2d zmp_reference(const Timeline& timeline, std::ptrdiff_t tick);

/// sum_j w_j zmp_reference(tick - j + kSmoothingAdvance).
Eigen::Vector2d smoothed_zmp(const Timeline& timeline, std::ptrdiff_t tick);

/// 3s² - 2s³ for s in [0, 1]: the velocity is zero at both ends, the acceleration is not.
constexpr double cubic_blend(double s) { return s * s * (3 - 2 * s); }

/// 10s³ - 15s⁴ + 6s⁵ for s in [0, 1]: velocity and acceleration are zero at both ends.
constexpr double quintic_blend(double s) { return s * s * s * (10 + s * (6 * s - 15)); }

/// Returns the swinging sole at `elapsed` (0 ... 1) of single support, in P; the heading follows a cubic
/// (Stasse et al. 2006, section II, and the JRL pattern generator). It moves horizontally only in the middle
/// 90 % (so that take-off and landing are vertical), following `polynomial`; the height is 16 h s² (1-s)².
Eigen::Isometry3d swing_foot(const FootPose& from, const FootPose& to, double elapsed, double step_height_m,
                             SwingPolynomial polynomial);

/// The pose of the sole of a foot `height_m` above its place on the ground, in P.
Eigen::Isometry3d sole(const FootPose& foot, double height_m = 0);
/// The place and heading of a pose.
FootPose on_floor(const Eigen::Isometry3d& X);

struct WaistYaw {
  double yaw = 0;   ///< rad, never wrapped
  double rate = 0;  ///< rad/s
};

/// A cubic from the heading at the start of the phase to the heading at its end, with `elapsed` from 0 to 1
/// (Stasse et al. 2006, section II: the waist turns in yaw only, on a third-order polynomial).
WaistYaw waist_yaw(const Phase& phase, double elapsed);

/// Returns the angles of the arm on the side of a foot that is `foot_ahead_m` farther ahead than in the start
/// posture. The hand moves the opposite way by a fraction of that distance, at its height in the start
/// posture (Stasse et al. 2006, section II: "arm motion heuristic"; gain and geometry from the JRL pattern
/// generator). For 0, the arm is in the start posture. The robot must have that arm, with a forearm as long
/// as the upper arm.
ArmAngles arm_swing(const Robot& robot, Side side, double foot_ahead_m);

/// Both arms for the feet of `reference`.
Arms arm_swing(const Robot& robot, const Reference& reference);

}  // namespace walking
