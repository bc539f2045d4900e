// An external program as the walking controller.
#pragma once

#include "sim/controllers/messages.h"
#include "sim/controllers/path.h"

namespace sim::controllers {

/// When an answer takes effect: at once, after a simulated time, or after its wall time.
struct AnswerTime {
  double fixed_s = 0;
  bool measured = false;
};

/// Input of a program before its first sensors.
struct ProgramStart {
  programs::Choice choice;
  walking::Robot robot;
  RobotDescription description;
  std::string walk;               ///< text of START
  walking::WalkOptions commands;  ///< and steering
  std::uint64_t seed = 1;
  walking::AttitudeOptions attitude = {};
  AnswerTime time = {};
};

class ProgramController : public Controller {
 public:
  /// Throws std::invalid_argument if the program cannot be started or its READY is invalid, and
  /// programs::ProgramFailed if it crashes or misses its time limit.
  explicit ProgramController(ProgramStart start);

  const walking::JointVector& start() const override { return ready_.start; }
  double held_s() const override { return ready_.words.settle_s / 2; }
  JointCommands command(const Readings& readings, bool settles) override;
  void advance() override;
  bool walks() const override {
    return follower_ ? !follower_->ended() && !follower_->stopped() : !finished_;
  }
  double progress() const override;
  bool has_plan() const override { return ready_.words.has_plan == 1; }
  const walking::Reference& reference() const override { return reference_; }
  walking::Reference following() const override { return following_; }

  /// The follower of the commanded path; absent if the program plans the commands itself.
  std::optional<PathFollower>& follower() { return follower_; }
  /// Its log ends with the number of clipped angles, if there are any. Throws programs::ProgramFailed if it
  /// sent more answers than asked for.
  std::string finish() override;
  /// Commanded angles that were beyond the range of their joints.
  std::size_t clipped() const { return clipped_; }

 private:
  std::chrono::nanoseconds now() const { return walking::kTick * tick_; }
  void ask(const Readings& readings, bool settles);
  void take_effect();
  void refer();
  void refer_to_path();

  ProgramStart start_;
  Ready ready_;
  programs::Conversation program_;
  std::optional<PathFollower> follower_;
  walking::Attitude attitude_;
  std::ptrdiff_t tick_ = 0;
  bool settling_ = true, finished_ = false;
  std::optional<Answer> pending_;
  std::chrono::nanoseconds effect_{0};  // of pending_
  std::ptrdiff_t answered_ = 0;         // tick of the plan in reference_
  gaitslam_walk_plan plan_{};
  JointCommands commands_;
  std::size_t clipped_ = 0;
  walking::Reference reference_, following_;
};

}  // namespace sim::controllers
