// The walk commands as a path of the base in W, and how a velocity-controlled walker follows it.
#pragma once

#include "sim/controllers/controller.h"

namespace sim::controllers {

/// Straight lines, arcs and turns at constant velocities. Feed-forward uses a fixed fraction of the largest
/// speeds, so that feedback can add to it.
class Path {
 public:
  /// Throws std::invalid_argument for a command that is not a path (steps) or that needs a direction whose
  /// largest speed is 0.
  Path(const std::vector<walking::Command>& commands, const Velocity& largest);

  struct Piece {
    std::size_t command = 0;  ///< index
    walking::FootPose start;
    Velocity velocity;
    double duration_s = 0, start_s = 0;
  };
  double duration_s() const {
    return pieces_.empty() ? 0 : pieces_.back().start_s + pieces_.back().duration_s;
  }
  /// Moves the path, which starts at the origin.
  void start_at(const walking::FootPose& start);
  /// Returns the piece at that time, or the last piece after the end. There must be at least one.
  const Piece& piece(double t_s) const;
  walking::FootPose pose(double t_s) const;
  /// Returns whether the path still moves after that time.
  bool goes_on(double t_s) const { return t_s < last_move_s_; }

 private:
  void add(std::size_t command, const walking::Command& what);
  void add(std::size_t command, const Velocity& direction, double length);
  void go(std::size_t command, const walking::GoTo& goal);

  Velocity largest_;
  std::vector<Piece> pieces_;
  walking::FootPose end_;
  double last_move_s_ = 0;  // start of the last piece that moves
};

/// Follows a path: feed-forward, plus feedback from an estimated place if there is one.
class PathFollower {
 public:
  /// marches: the robot cannot stand, so that its place is corrected while it stands and after the end, too.
  PathFollower(Path path, const Velocity& largest, const walking::SteeringOptions& steering,
               bool marches = false);

  /// Moves the path, which starts at the origin.
  void start_at(const walking::FootPose& start) { path_.start_at(start); }
  /// Sets the desired and the estimated place of the base at a time; only the difference of their headings
  /// counts.
  void locate(const walking::PlaceEstimate& place);
  void advance(double dt_s);

  bool ended() const { return ended_; }
  bool is_over() const { return ended_ || stopped_; }
  /// Why the walk stopped before its end: a command took too long, or the steering estimate was missing for
  /// walk.steering.lost_s.
  const std::optional<std::string>& stopped() const { return stopped_; }
  Velocity velocity() const { return stopped_ || (ended_ && !marches_) ? Velocity{} : velocity_; }
  bool stands() const;
  walking::FootPose desired() const { return path_.pose(t_s_); }
  /// Returns the path some time ahead, relative to the base's heading (estimated, if possible). While
  /// the robot is not near the end of the current command, the path ends there.
  walking::FootPose ahead(double s) const;
  double progress() const;

 private:
  bool may_end() const;
  void follow(double dt_s);
  void correct(double dt_s);
  Velocity limited(Velocity velocity) const;

  Path path_;
  Velocity largest_;
  walking::SteeringOptions steering_;
  double t_s_ = 0, command_s_ = 0;          // time on the path; time since the start of the command
  double now_s_ = 0, estimate_s_ = 0;       // time now; time of the newest estimate
  std::optional<walking::FootPose> error_;  // desired place, seen from the estimated one
  Velocity steady_, sum_, velocity_;        // steady_: along the path; sum_: integral of the error
  bool marches_, waits_for_end_ = false, ended_ = false;
  std::optional<std::string> stopped_;
};

}  // namespace sim::controllers
