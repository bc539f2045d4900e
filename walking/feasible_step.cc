#include "walking/feasible_step.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "walking/hrp2.h"

namespace walking {
namespace {

using Eigen::Vector2d;

constexpr double kOuterMargin = 0.04, kSoleClearance = 0.01;  // m

/// The outer half-planes n · (|x|, |y|) <= d.
struct HalfPlane {
  Vector2d normal;
  double most;
};

HalfPlane through(const Vector2d& a, const Vector2d& b) {
  const Vector2d along = (b - a).normalized(), normal(-along.y(), along.x());
  return {normal, normal.dot(a)};
}

double beyond_outer_edges(const Vector2d& place) {
  static const std::array kEdges{HalfPlane{Vector2d(1, 0), 0.28}, through({0.20, 0.3}, {0.28, 0.2}),
                                 through({0, 0.4}, {0.20, 0.3})};
  double beyond = 0;
  for (const HalfPlane& edge : kEdges)
    beyond = std::max(beyond, edge.normal.dot(place.cwiseAbs()) - edge.most + kOuterMargin);
  return beyond;
}

std::array<Vector2d, 4> corners(const FootPose& foot) {
  const Vector2d &a = hrp2::kSoleMin, &b = hrp2::kSoleMax;
  std::array<Vector2d, 4> all{Vector2d(a), Vector2d(b.x(), a.y()), Vector2d(b), Vector2d(a.x(), b.y())};
  for (Vector2d& corner : all) corner = (foot * FootPose{corner, 0}).position;
  return all;
}

/// The gap between two soles along an axis; negative where they overlap.
double gap(const std::array<Vector2d, 4>& one, const std::array<Vector2d, 4>& two, const Vector2d& axis) {
  const auto range = [&](const std::array<Vector2d, 4>& sole) {
    std::array<double, 4> s{};
    for (std::size_t i = 0; i < 4; ++i) s[i] = axis.dot(sole[i]);
    const auto [least, most] = std::minmax_element(s.begin(), s.end());
    return std::pair(*least, *most);
  };
  const auto [a, b] = range(one);
  const auto [c, d] = range(two);
  return std::max(c - b, a - d);
}

/// Two convex soles are as far apart as along the best of their edges' normals, or farther.
double gap_between_soles(const FootPose& one, const FootPose& two) {
  double widest = -1;
  for (const double yaw : {one.yaw, two.yaw})
    for (const Vector2d& axis :
         {Vector2d(std::cos(yaw), std::sin(yaw)), Vector2d(-std::sin(yaw), std::cos(yaw))})
      widest = std::max(widest, gap(corners(one), corners(two), axis));
  return widest;
}

}  // namespace

double distance_outside(const FootPose& standing, const Footstep& landing) {
  const Vector2d seen = Eigen::Rotation2Dd(-standing.yaw) * (landing.pose.position - standing.position);
  const double outwards = landing.side == Side::left ? seen.y() : -seen.y();
  const double crossed = std::max(0.0, -outwards);  // beyond the standing foot
  return std::max(
      {beyond_outer_edges(seen), kSoleClearance - gap_between_soles(standing, landing.pose), crossed, 0.0});
}

}  // namespace walking
