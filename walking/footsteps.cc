#include "walking/footsteps.h"

#include <algorithm>
#include <cmath>

namespace walking {
namespace {

using Eigen::Vector2d;

constexpr double kNegligible = 1e-9;  // fraction of a step; a shorter remainder is a rounding error

Vector2d rotated(double yaw, const Vector2d& v) { return Eigen::Rotation2Dd(yaw) * v; }

/// The foot of `side` in a stance around `center`.
Footstep footstep_at(const Robot& robot, const FootPose& center, Side side) {
  return {side, feet_together(center, robot.foot_spacing).of(side)};
}

/// Distances along the path after each step: whole steps, then the remainder.
std::vector<double> progress(double distance, double step) {
  constexpr double kShortestStep_s = 0.1;  // lower bound of walk.single_support_s
  if (distance / step > kLongestWalk_s / kShortestStep_s) throw TooLong(0, "too many steps");
  const int whole = static_cast<int>(std::floor(distance / step + kNegligible));
  std::vector<double> s;
  for (int k = 1; k <= whole; ++k) s.push_back(std::min(k * step, distance));
  if (distance - whole * step > kNegligible * step) s.push_back(distance);
  if (!s.empty()) s.back() = distance;
  return s;
}

void require(bool holds, const std::string& complaint) {
  if (!holds) throw std::invalid_argument(complaint);
}

std::vector<Footstep> steps_of(const Robot&, const auto&, double) {
  return {};
}  // stand and repeat; for go_to, see steps_to()

/// The foot on the side of travel goes first and covers the lateral distance of two steps; the other then
/// closes to the foot spacing, so the feet never cross or come closer. Steps that lead far to the side are
/// shorter.
std::vector<Footstep> steps_of(const Robot& robot, const Straight& straight, double step) {
  const double distance = std::hypot(straight.forward_m, straight.left_m);
  require(distance > 0, "straight: forward_m and left_m are both zero; use stand");
  const Side lead = straight.left_m > 0 ? Side::left : Side::right;
  const double longest = robot.step.aside_m / 2 * distance / std::abs(straight.left_m);
  std::vector<double> s = progress(distance, std::min(step, longest));
  s.push_back(distance);  // the closing step
  std::vector<Footstep> steps;
  for (std::size_t k = 0; k < s.size(); ++k) {
    const bool leading = k % 2 == 0;
    const double lateral = s[leading ? std::min(k + 1, s.size() - 1) : k];
    const FootPose center{{straight.forward_m * (s[k] / distance), straight.left_m * (lateral / distance)},
                          0};
    steps.push_back(footstep_at(robot, center, leading ? lead : other(lead)));
  }
  return steps;
}

template <class Arc>
void check(const Arc& arc) {
  require(arc.angle_rad != 0, std::string(Arc::kName) + ".angle_deg must not be zero");
}

/// Feet alternate along a circle to the left or right, or turn on the spot.
std::vector<Footstep> alternate(const Robot& robot, double radius, double angle, double step_rad, Side side) {
  const double turn = std::copysign(1.0, angle);
  const Vector2d circle_center(0, turn * radius);
  std::vector<double> angles = progress(std::abs(angle), step_rad);
  angles.push_back(angles.back());  // the closing step
  std::vector<Footstep> steps;
  for (const double along : angles) {
    const double yaw = turn * along;
    steps.push_back(footstep_at(robot, {circle_center - rotated(yaw, circle_center), yaw}, side));
    side = other(side);
  }
  return steps;
}

/// The outer foot goes first.
std::vector<Footstep> steps_of(const Robot& robot, const TangentArc& arc, double step) {
  check(arc);
  return alternate(robot, arc.radius_m, arc.angle_rad, step / arc.radius_m,
                   arc.angle_rad > 0 ? Side::right : Side::left);
}

/// Each foot is one step ahead of the other. The foot on the side of the turn goes first, so that the toes
/// never meet.
std::vector<Footstep> steps_of(const Robot& robot, const Turn& turn, double) {
  check(turn);
  return alternate(robot, 0, turn.angle_rad, turn.step_rad, turn.angle_rad > 0 ? Side::left : Side::right);
}

/// Facing the center, radius_m ahead: the foot on the side of travel goes to its place in the turned stance,
/// then the other closes. When turning left, the robot moves to its right.
std::vector<Footstep> steps_of(const Robot& robot, const PerpendicularArc& arc, double step) {
  check(arc);
  const double turn = std::copysign(1.0, arc.angle_rad);
  const Vector2d circle_center(arc.radius_m, 0);
  const Side lead = turn > 0 ? Side::right : Side::left;
  std::vector<Footstep> steps;
  for (const double angle : progress(std::abs(arc.angle_rad), std::min(step, arc.step_m) / arc.radius_m)) {
    const double yaw = turn * angle;
    const FootPose center{circle_center - rotated(yaw, circle_center), yaw};
    steps.push_back(footstep_at(robot, center, lead));
    steps.push_back(footstep_at(robot, center, other(lead)));
  }
  return steps;
}

/// Rotate first, then translate in the turned frame (the step stack of the JRL pattern generator).
FootPose landing(const FootPose& standing, const Step& step) {
  return standing * FootPose{{0, 0}, step.turn_rad} * FootPose{{step.forward_m, step.left_m}, 0};
}

std::vector<Footstep> steps_of(const Robot& robot, const Steps& steps, double) {
  require(!steps.list.empty(), "steps: the list is empty");
  Stance stance = feet_together({}, robot.foot_spacing);
  std::vector<Footstep> landings;
  for (const Step& step : steps.list) {
    const Side side = step.left_m > 0 ? Side::left : Side::right;
    require(step.left_m != 0 && (landings.empty() || landings.back().side != side),
            "steps: left_m of step " + std::to_string(landings.size() + 1) +
                " is zero or on the wrong side, expected > 0 for left feet and < 0 for right ones in turn");
    stance.of(side) = landing(stance.of(other(side)), step);
    landings.push_back({side, stance.of(side)});
  }
  const Side last = landings.back().side, behind = other(last);
  const double spacing = last == Side::left ? -robot.foot_spacing : robot.foot_spacing;
  const FootPose closed = landing(stance.of(last), {0, spacing, 0}), &now = stance.of(behind);
  constexpr double kWritten = 1e-6;  // m and rad: steps are given with six decimals
  if ((closed.position - now.position).norm() >= kWritten || std::abs(closed.yaw - now.yaw) >= kWritten)
    landings.push_back({behind, closed});
  return landings;
}

std::vector<Footstep> steps_to(const Robot& robot, const GoTo& goal, const FootPose& start, double step) {
  constexpr double kThere = 1e-9;  // m and rad
  const FootPose end = FootPose{{goal.x_m, goal.y_m}, goal.heading_rad} * FootPose{{robot.sole_ahead, 0}, 0};
  FootPose at = start;
  std::vector<Footstep> steps;
  const auto append = [&](const Command& command) {
    const auto more = footsteps(robot, command, at, step);
    steps.insert(steps.end(), more.begin(), more.end());
  };
  const auto turn_to = [&](double heading) {
    const double angle = std::remainder(heading - at.yaw, 2 * std::numbers::pi);
    if (std::abs(angle) > kThere) append(Turn{.angle_rad = angle});
    at.yaw += angle;
  };
  const Vector2d way = end.position - at.position;
  if (way.norm() > kThere) {
    turn_to(std::atan2(way.y(), way.x()));
    append(Straight{way.norm(), 0});
    at.position = end.position;
  }
  turn_to(end.yaw);
  return steps;
}

using Corners = Eigen::Matrix<double, 2, 4>;

constexpr double kOuterMargin = 0.04, kSoleClearance = 0.01;  // m

double beyond_outer_edges(const StepLimits& limits, const Vector2d& place) {
  const double ahead = limits.reach_ahead_m, aside = limits.reach_aside_m;
  const std::array<Vector2d, 4> corners{
      {{ahead, 0}, {ahead, aside / 2}, {ahead * 5 / 7, aside * 3 / 4}, {0, aside}}};
  double beyond = 0;
  for (std::size_t edge = 0; edge < 3; ++edge) {
    const Vector2d &from = corners[edge + 1], along = (corners[edge] - from).normalized(),
                   outwards(-along.y(), along.x());
    beyond = std::max(beyond, outwards.dot(place.cwiseAbs()) - outwards.dot(from) + kOuterMargin);
  }
  return beyond;
}

Corners corners(const Leg& leg, const FootPose& foot) {
  const Vector2d &a = leg.sole_min, &b = leg.sole_max;
  Corners all;
  all << a.x(), b.x(), b.x(), a.x(), a.y(), a.y(), b.y(), b.y();
  for (auto corner : all.colwise()) corner = (foot * FootPose{corner, 0}).position;
  return all;
}

/// A lower bound of the gap: the largest separation of the two convex soles along their edges' normals. If it
/// is negative, they overlap.
double gap_between_soles(const Robot& robot, const FootPose& standing, const Footstep& landing) {
  const Corners one = corners(robot.leg(other(landing.side)), standing),
                two = corners(robot.leg(landing.side), landing.pose);
  double widest = -1;
  for (const double yaw : {standing.yaw, landing.pose.yaw})
    for (const Vector2d& axis :
         {Vector2d(std::cos(yaw), std::sin(yaw)), Vector2d(-std::sin(yaw), std::cos(yaw))}) {
      const Eigen::RowVector4d a = axis.transpose() * one, b = axis.transpose() * two;
      widest = std::max({widest, b.minCoeff() - a.maxCoeff(), a.minCoeff() - b.maxCoeff()});
    }
  return widest;
}

}  // namespace

FootPose operator*(const FootPose& frame, const FootPose& local) {
  return {frame.position + rotated(frame.yaw, local.position), frame.yaw + local.yaw};
}

FootPose inverse(const FootPose& pose) { return {rotated(-pose.yaw, -pose.position), -pose.yaw}; }

Side other(Side side) { return side == Side::left ? Side::right : Side::left; }

Stance feet_together(const FootPose& center, double spacing_m) {
  return {center * FootPose{{0, spacing_m / 2}, 0}, center * FootPose{{0, -spacing_m / 2}, 0}};
}

FootPose center_of(const Stance& stance) {
  return {(stance.left.position + stance.right.position) / 2, (stance.left.yaw + stance.right.yaw) / 2};
}

std::vector<Footstep> footsteps(const Robot& robot, const Command& command, const FootPose& start,
                                double step_length_m) {
  if (const auto* goal = std::get_if<GoTo>(&command)) return steps_to(robot, *goal, start, step_length_m);
  auto steps = std::visit([&](const auto& c) { return steps_of(robot, c, step_length_m); }, command);
  for (Footstep& step : steps) step.pose = start * step.pose;
  return steps;
}

double distance_outside(const Robot& robot, const FootPose& standing, const Footstep& landing) {
  const Vector2d seen = Eigen::Rotation2Dd(-standing.yaw) * (landing.pose.position - standing.position);
  const double outwards = landing.side == Side::left ? seen.y() : -seen.y();
  const double crossed = std::max(0.0, -outwards);  // beyond the standing foot
  return std::max({beyond_outer_edges(robot.step, seen),
                   kSoleClearance - gap_between_soles(robot, standing, landing), crossed, 0.0});
}

}  // namespace walking
