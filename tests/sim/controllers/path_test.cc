// The path of walk commands, and following it.
#include "sim/controllers/path.h"

namespace sim::controllers {
namespace {

using std::numbers::pi;
using walking::FootPose;

constexpr Velocity kLargest{0.5, 0.2, 1};
constexpr double kTick = 0.005;

/// The ends of commands, computed from their geometry without integrating the path.
TEST(Path, EndsWhereItsCommandsLead) {
  for (const auto& [commands, end] : std::vector<std::pair<std::vector<walking::Command>, FootPose>>{
           {{walking::Straight{2, 0.5}}, {{2, 0.5}, 0}},
           {{walking::TangentArc{1, pi / 2}}, {{1, 1}, pi / 2}},
           {{walking::TangentArc{1, -pi / 2}}, {{1, -1}, -pi / 2}},
           {{walking::PerpendicularArc{1, pi / 2}}, {{1, -1}, pi / 2}},
           {{walking::Turn{pi}, walking::Straight{1, 0}}, {{-1, 0}, pi}},
           {{walking::Stand{1}, walking::GoTo{1, 2, pi / 2}}, {{1, 2}, pi / 2}},
           {{walking::Straight{1, 0}, walking::Turn{pi / 2}, walking::Repeat{2, 3}}, {{0, 0}, 2 * pi}}}) {
    const Path path(commands, kLargest);
    const FootPose reached = path.pose(path.duration_s());
    EXPECT_LT((reached.position - end.position).norm(), 1e-9);
    EXPECT_NEAR(reached.yaw, end.yaw, 1e-9);
    for (double t = 0; t < path.duration_s(); t += 0.1) {
      const Velocity v = path.piece(t).velocity;
      EXPECT_LE(std::abs(v.ahead), kLargest.ahead);
      EXPECT_LE(std::abs(v.left), kLargest.left);
      EXPECT_LE(std::abs(v.turn), kLargest.turn);
    }
  }
}

TEST(Path, ContinuesFromItsStart) {
  const FootPose start{{0.3, -0.2}, 1};
  Path moved({walking::Straight{1, 0}, walking::TangentArc{1, pi / 2}}, kLargest), path = moved;
  moved.start_at(start);
  for (double t = 0; t < path.duration_s(); t += 0.1) {
    const FootPose expected = start * path.pose(t);
    EXPECT_LT((moved.pose(t).position - expected.position).norm(), 1e-9);
    EXPECT_NEAR(moved.pose(t).yaw, expected.yaw, 1e-9);
  }
}

/// A robot with the gains and biases of a learned gait: ahead, aside, turn.
struct Walker {
  FootPose at = {};
  FootPose desired = {};

  /// Follows the path to its end. locates: whether the walker's place is known.
  void follow(PathFollower& follower, bool locates) {
    for (int tick = 0; tick < 100000 && !follower.ended() && !follower.stopped(); ++tick)
      step(follower, locates);
  }
  void step(PathFollower& follower, bool locates) {
    const Velocity v = follower.velocity();
    at = at * FootPose{Eigen::Vector2d(0.9 * v.ahead - 0.02, 0.9 * v.left + 0.01) * kTick,
                       (0.9 * v.turn + 0.02) * kTick};
    follower.advance(kTick);
    desired = follower.desired();
    if (locates) follower.locate({0, desired, at});
  }
  double off() const { return (at.position - desired.position).norm(); }
};

TEST(PathFollower, BringsARobotWithGainAndBiasToTheEnd) {
  walking::SteeringOptions steering;
  steering.tolerance_m = 0.05, steering.tolerance_rad = 0.1;
  for (const double aside : {0.2, 0.0}) {  // also a robot that does not walk sideways
    const Velocity largest{0.5, aside, 1};
    const std::vector<walking::Command> circle{walking::Straight{2, 0}, walking::TangentArc{1, pi / 2},
                                               walking::Turn{pi / 2}};
    for (const bool locates : {false, true}) {
      PathFollower follower(Path(circle, largest), largest, steering);
      Walker walker;
      walker.follow(follower, locates);
      EXPECT_TRUE(follower.ended()) << follower.stopped().value_or("");
      if (locates)
        EXPECT_LT(walker.off(), 0.05);
      else
        EXPECT_GT(walker.off(), 0.2) << "by dead reckoning of the command";
    }
  }
}

TEST(PathFollower, OnlyTheEndOfThePathWaitsForARobotThatLags) {
  walking::SteeringOptions steering;
  steering.tolerance_m = 0.05, steering.tolerance_rad = 0.1;
  const auto waits_after_a_meter = [&](const std::vector<walking::Command>& commands) {
    PathFollower follower(Path(commands, kLargest), kLargest, steering);
    double t_s = 0;
    for (; !follower.is_over(); t_s += kTick) {
      const walking::FootPose at = follower.desired() * walking::FootPose{{-0.2, 0}, 0};
      follower.locate({t_s, follower.desired(), at});
      follower.advance(kTick);
      if (follower.desired().position.x() > 1.0001) return false;
    }
    return true;
  };
  const walking::Straight ahead{1, 0};
  EXPECT_FALSE(waits_after_a_meter({ahead, walking::Stand{1}, ahead}));
  EXPECT_TRUE(waits_after_a_meter({ahead, walking::Stand{1}}));
}

TEST(PathFollower, ASteeredCommandDoesNotJumpWhereAnArcTurnsBack) {
  PathFollower follower(
      Path({walking::PerpendicularArc{1, 0.7}, walking::PerpendicularArc{1, -0.7}}, kLargest), kLargest, {});
  double most_m_s = 0;
  for (Velocity last = follower.velocity(); !follower.is_over(); last = follower.velocity()) {
    follower.locate({0, follower.desired(), follower.desired()});
    follower.advance(kTick);
    if (follower.is_over()) break;
    most_m_s = std::max(most_m_s, std::abs(follower.velocity().left));
    EXPECT_LE(std::abs(follower.velocity().left - last.left), 0.5 * kTick + 1e-9);
  }
  EXPECT_GT(most_m_s, 0.1);
}

TEST(PathFollower, ARobotThatDriftsWhileItStandsReturnsInTheNextCommand) {
  walking::SteeringOptions steering;
  steering.tolerance_m = 0.05, steering.tolerance_rad = 0.1;
  PathFollower follower(Path({walking::Stand{1}, walking::Straight{1, 0}}, kLargest), kLargest, steering);
  Walker walker{{{-0.5, 0.1}, 0}};
  walker.follow(follower, true);
  EXPECT_TRUE(follower.ended()) << follower.stopped().value_or("");
  EXPECT_LT(walker.off(), 0.05);
}

TEST(PathFollower, ARobotThatMarchesStaysInPlaceWhileItStandsAndAfterTheEnd) {
  walking::SteeringOptions steering;
  steering.tolerance_m = 0.08, steering.tolerance_rad = 0.1;
  PathFollower follower(Path({walking::Straight{1, 0}, walking::Stand{5}}, kLargest), kLargest, steering,
                        true);
  Walker walker;
  walker.follow(follower, true);
  EXPECT_LT(walker.off(), 0.05) << "with 0.01 to 0.02 m/s for 5 s";
  const FootPose end = walker.at;
  for (int tick = 0; tick < 400; ++tick) walker.step(follower, true);
  EXPECT_LT((walker.at.position - end.position).norm(), 0.02);
}

TEST(PathFollower, StopsIfTheEstimateThatSteersIsMissing) {
  walking::SteeringOptions steering;
  steering.by = walking::SteeredBy::estimate, steering.lost_s = 2;
  PathFollower follower(Path({walking::Straight{10, 0}}, kLargest), kLargest, steering);
  double t_s = 0;
  for (; !follower.ended() && !follower.stopped(); t_s += kTick) {
    if (t_s < 1) follower.locate({t_s, follower.desired(), follower.desired()});
    follower.advance(kTick);
  }
  EXPECT_NEAR(t_s, 3, 2 * kTick);
  EXPECT_EQ(follower.stopped(), "steering had no estimate for 2 s at t = 3.00 s");
  EXPECT_EQ(follower.velocity().ahead, 0);
}

}  // namespace
}  // namespace sim::controllers
