// The walk commands as a path of the base in W, and how a controller that takes velocities follows it.
#pragma once

#include "sim/controllers/controller.h"

namespace sim::controllers {

/// Straights, arcs and turns at constant velocities. Feed-forward takes a fixed fraction of the largest
/// speeds, so that feedback can add to it.
class Path {
 public:
  /// Throws std::invalid_argument for a command that is not a path (steps) or that needs a speed of 0.
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
  /// The piece of that time, the last one after the end; there is one.
  const Piece& piece(double t_s) const;
  walking::FootPose pose(double t_s) const;

 private:
  void add(std::size_t command, const walking::Command& what);
  void add(std::size_t command, const Velocity& direction, double length);
  void go(std::size_t command, const walking::GoTo& goal);

  Velocity largest_;
  std::vector<Piece> pieces_;
  walking::FootPose end_;
};

/// Follows a path: feed-forward, and feedback of an estimated place, if there is one.
class PathFollower {
 public:
  PathFollower(Path path, const Velocity& largest, const walking::SteeringOptions& steering);

  /// Desired and estimated place of the base at a time; only the difference of their headings counts.
  void locate(const walking::PlaceEstimate& place);
  void advance(double dt_s);

  bool ended() const { return ended_; }
  bool is_over() const { return ended_ || stopped_; }
  /// The reason why the walk stopped before its end: a command took too long, or the estimate that steers is
  /// missing for walk.steering.lost_s.
  const std::optional<std::string>& stopped() const { return stopped_; }
  Velocity velocity() const { return is_over() ? Velocity{} : velocity_; }
  bool stands() const;
  walking::FootPose desired() const { return path_.pose(t_s_); }
  /// The path some time ahead, in the estimated heading of the base, if there is one. It ends at the end of a
  /// command that the robot has not come near.
  walking::FootPose ahead(double s) const;
  double progress() const;

 private:
  bool may_end() const;
  Velocity limited(Velocity velocity) const;

  Path path_;
  Velocity largest_;
  walking::SteeringOptions steering_;
  double t_s_ = 0, command_s_ = 0;          // on the path; since the start of the command
  double now_s_ = 0, estimate_s_ = 0;       // time, and that of the newest estimate
  std::optional<walking::FootPose> error_;  // of the desired place, seen from the estimated one
  Velocity steady_, sum_, velocity_;        // steady_: along the path; sum_: integral of the error
  bool waits_for_end_ = false, ended_ = false;
  std::optional<std::string> stopped_;
};

}  // namespace sim::controllers
