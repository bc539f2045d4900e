// An external program as the walking controller.
#pragma once

#include "sim/controllers/messages.h"
#include "sim/controllers/path.h"
#include "sim/files/hash.h"
#include "walking/leg_odometry.h"

namespace sim::controllers {

/// When an answer takes effect: at once, after a simulated time, or after its wall time.
struct AnswerTime {
  double fixed_s = 0;
  bool measured = false;
};

/// The data that a program needs before its first sensor readings.
struct ProgramStart {
  programs::Choice choice;
  walking::Robot robot;
  RobotDescription description;
  std::string walk;               ///< the walk text of START
  walking::WalkOptions commands;  ///< and steering
  std::uint64_t seed = 1;
  walking::AttitudeOptions attitude = {};
  AnswerTime time = {};
};

/// Duration of GAITSLAM_WALK_STOP after the commands, equal to the time that the built-in controller
/// stands at its end.
inline constexpr double kStopping_s = 2;

class ProgramController : public Controller {
 public:
  /// Throws std::invalid_argument if the program cannot be started or its READY is invalid, and
  /// programs::ProgramFailed if it crashes or misses its time limit.
  explicit ProgramController(ProgramStart start);

  const walking::JointVector& start() const override { return ready_.start; }
  double held_s() const override { return ready_.words.settle_s / 2; }
  /// Returns whether it carries out the walk text on slopes by itself.
  bool plans_on_slopes() const { return ready_.words.plans == 1 && ready_.words.slopes == 1; }
  bool stands() const override { return ready_.words.stands == 1; }
  JointCommands command(const Readings& readings, bool settles) override;
  void advance() override;
  void start_at(const walking::FootPose& start) override;
  bool walks() const override { return follower_ ? stopping_s_ < kStopping_s : !finished_; }
  double progress() const override;
  bool has_plan() const override { return ready_.words.has_plan == 1; }
  bool is_level() const override { return has_plan() && ready_.words.slopes == 0; }
  const walking::Reference& reference() const override { return has_plan() ? plan_.now : path_.now; }
  walking::Reference following() const override { return has_plan() ? plan_.next : path_.next; }
  std::optional<Ticks> path() const override { return follower_ ? std::optional(path_) : std::nullopt; }
  std::optional<Velocity> velocity() const override {
    return follower_ ? std::optional(follower_->velocity()) : std::nullopt;
  }
  bool steers(std::size_t) const override {
    return follower_ && start_.commands.steering.by != walking::SteeredBy::plan;
  }
  void steer(std::size_t tick, const std::optional<walking::PlaceEstimate>& newest) override;
  bool wants_rig() const override { return ready_.words.wants_rig == 1; }
  void add_rig(const std::string& message) override { rig_ += message; }
  std::optional<std::string> stopped() const override {
    return follower_ ? follower_->stopped() : std::nullopt;
  }
  /// Returns the log, which ends with the number of clipped angles, if any. Throws programs::ProgramFailed if
  /// the program sent more answers than it was asked for.
  std::string finish() override;
  std::string answers() const override;
  /// Number of commanded angles that were out of their joints' ranges.
  std::size_t clipped() const { return clipped_; }

 private:
  std::chrono::nanoseconds now() const { return walking::kTick * tick_; }
  void ask(const Readings& readings, bool settles);
  void take_effect();
  void locate();
  void measure_velocity(const Readings& readings, gaitslam_walk_sensors& words);
  gaitslam_walk_place place() const;
  void refer();
  void refer_to_path();
  void refer_to_plan();

  ProgramStart start_;
  Ready ready_;
  programs::Conversation program_;
  std::optional<PathFollower> follower_;
  walking::Attitude attitude_;
  walking::LegOdometry legs_;
  std::optional<Eigen::Isometry3d> X_OB_;  // by the legs, at the last SENSORS
  std::string rig_;                        // messages since the last SENSORS
  std::ptrdiff_t tick_ = 0;
  bool settling_ = true, finished_ = false;
  double stopping_s_ = 0;  // since the end of the commanded path
  std::optional<Answer> pending_;
  std::chrono::nanoseconds effect_{0};  // when pending_ takes effect
  std::ptrdiff_t answered_ = 0;         // tick of answer_'s plan
  gaitslam_walk_plan answer_{};
  walking::FootPose start_at_;                     // pose of the base at t = 0 without a plan
  walking::FootPose X_WP_;                         // newest estimate of the pose of the plan's world
  std::optional<walking::PlaceEstimate> located_;  // that estimate
  std::vector<walking::FootPose> on_path_;         // by tick: place of the base in the plan's world
  JointCommands commands_;
  std::size_t clipped_ = 0;
  files::Hash answers_;
  Ticks plan_, path_;
};

}  // namespace sim::controllers
