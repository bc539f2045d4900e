// People and doors that move as scripted while the robot walks.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "sim/score/types.h"

namespace sim::physics {

/// No part of an actor is faster, m/s.
inline constexpr double kFastestActor_m_s = 5;

struct Person {
  static constexpr const char* kName = "person";
  std::vector<Eigen::Vector3d>
      path;  ///< times (s) and places (m in the room), at constant speed between them
  bool repeats = false;

  static void keys(auto&& key) {
    number<&Person::path>(
        key, -1e4, 1e4,
        "times and places as [s, x in m, y in m]: the person walks straight from each to the next");
    value<&Person::repeats>(key, "begins again after the last place, which must be the first one");
  }
  std::optional<std::string> problem() const {
    constexpr double kRuns_m_s = 3;
    if (path.empty()) return "has no path, expected places such as [[0, 3, 1], [4, 3, -1]]";
    for (std::size_t i = 1; i < path.size(); ++i) {
      const Eigen::Vector3d step = path[i] - path[i - 1];
      if (!(step[0] > 0)) return "has times that do not increase, expected [s, m, m] in the order of time";
      if (step.tail<2>().norm() > kRuns_m_s * step[0]) return "is faster than 3 m/s";
    }
    if (repeats && (path.size() < 2 || (path.back() - path.front()).tail<2>().norm() > 0))
      return "repeats, but its path does not end where it begins";
    return std::nullopt;
  }
};

struct Door {
  static constexpr const char* kName = "door";
  double x_m = 0, y_m = 0, width_m = 0.9, closed_rad = 0, opening_rad = std::numbers::pi / 2;
  double opens_s = 0, closes_s = 1e6;

  static void keys(auto&& key) {
    number<&Door::x_m>(key, -1e4, 1e4, "x of the hinge in the room");
    number<&Door::y_m>(key, -1e4, 1e4, "y of the hinge in the room");
    number<&Door::width_m>(key, 0.1, 1.5, "width of the door");
    degrees<&Door::closed_rad>(key, -360, 360, "direction from the hinge along the closed door");
    degrees<&Door::opening_rad>(key, -180, 180, "angle by which it opens in 2 s; positive: left");
    number<&Door::opens_s>(key, 0, 1e6, "time at which it starts to open");
    number<&Door::closes_s>(key, 0, 1e6, "time at which it starts to close");
  }
  std::optional<std::string> problem() const {
    return closes_s < opens_s + kSwing_s ? std::optional(
                                               "closes before it is open, expected closes_s at least 2 s "
                                               "after opens_s")
                                         : std::nullopt;
  }
  static constexpr double kSwing_s = 2;
};

using Actor = std::variant<Person, Door>;

/// Moves an actor by X, which turns by yaw_rad about the vertical.
inline void place(Actor& actor, const Eigen::Isometry3d& X, double yaw_rad) {
  const auto moved = [&](double x, double y) { return Eigen::Vector3d(X * Eigen::Vector3d(x, y, 0)); };
  if (auto* door = std::get_if<Door>(&actor)) {
    const Eigen::Vector3d hinge = moved(door->x_m, door->y_m);
    door->x_m = hinge.x(), door->y_m = hinge.y(), door->closed_rad += yaw_rad;
  } else {
    for (Eigen::Vector3d& at : std::get<Person>(actor).path) at.tail<2>() = moved(at[1], at[2]).head<2>();
  }
}

/// A motion as numbers: its period (s; 0: it ends), then t (s), x, y (m) and yaw (rad) of each pose. The
/// motion is linear between poses.
using Script = std::vector<double>;

inline Script script_of(const Person& person) {
  constexpr double kTurn_s = 0.7;
  const auto& path = person.path;
  const auto way_from = [&](std::size_t i) {
    return i + 1 < path.size() ? Eigen::Vector3d(path[i + 1] - path[i]) : Eigen::Vector3d::Zero();
  };
  const auto heading = [](const Eigen::Vector3d& way) { return std::atan2(way[2], way[1]); };
  double yaw = heading(way_from(person.repeats ? path.size() - 2 : 0));
  Script script{person.repeats ? path.back()[0] - path.front()[0] : 0};
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Eigen::Vector3d way = way_from(i);
    const auto add = [&](const Eigen::Vector3d& at) {
      script.insert(script.end(), {at[0], at[1], at[2], yaw});
    };
    add(path[i]);
    if (way.tail<2>().norm() == 0) continue;
    yaw += std::remainder(heading(way) - yaw, 2 * std::numbers::pi);
    add(path[i] + way * std::min(1.0, kTurn_s / way[0]));
  }
  return script;
}

inline Script script_of(const Door& door) {
  Script script{0};
  for (const auto& [t, open] : {std::pair(door.opens_s, 0),
                                {door.opens_s + Door::kSwing_s, 1},
                                {door.closes_s, 1},
                                {door.closes_s + Door::kSwing_s, 0}})
    script.insert(script.end(), {t, door.x_m, door.y_m, door.closed_rad + open * door.opening_rad});
  return script;
}

inline Script script_of(const Actor& actor) {
  return std::visit([](const auto& one) { return script_of(one); }, actor);
}

/// Returns the pose of an actor on the floor, X_WM. Before the first and after the last pose it stands still.
inline Eigen::Isometry3d pose_at(std::span<const double> script, double t_s) {
  const double period = script[0];
  const std::span<const double> poses = script.subspan(1);
  const std::size_t count = poses.size() / 4;
  if (period > 0 && t_s > poses[0]) t_s = poses[0] + std::fmod(t_s - poses[0], period);
  std::size_t after = 0;
  while (after < count && poses[4 * after] <= t_s) ++after;
  const double* const to = &poses[4 * std::min(after, count - 1)];
  const double* const from = &poses[4 * (after == 0 ? 0 : after - 1)];
  const double part = to[0] > from[0] ? std::clamp((t_s - from[0]) / (to[0] - from[0]), 0.0, 1.0) : 0;
  const auto at = [&](int i) { return from[i] + part * (to[i] - from[i]); };
  return Eigen::Translation3d(at(1), at(2), 0) *
         Eigen::Isometry3d(Eigen::AngleAxisd(at(3), Eigen::Vector3d::UnitZ()));
}

/// The shapes of an actor in its own axes: ahead, left, up.
inline std::vector<score::Surface> shapes_of(const Actor& actor) {
  using Kind = score::Surface::Kind;
  const auto at = [](double x, double y, double z) {
    return Eigen::Isometry3d(Eigen::Translation3d(x, y, z));
  };
  if (const auto* door = std::get_if<Door>(&actor))
    return {{Kind::box, at(door->width_m / 2, 0, 1.01), {door->width_m / 2, 0.02, 1}}};
  std::vector<score::Surface> body{{Kind::sphere, at(0, 0, 1.63), {0.12, 0, 0}},            // head
                                   {Kind::ellipsoid, at(0, 0, 1.17), {0.14, 0.22, 0.36}}};  // trunk
  for (const double side : {-1.0, 1.0}) {
    body.push_back({Kind::capsule, at(0, 0.1 * side, 0.5), {0.08, 0.42, 0}});     // leg
    body.push_back({Kind::capsule, at(0, 0.27 * side, 1.1), {0.05, 0.27, 0}});    // arm
    body.push_back({Kind::box, at(0.06, 0.1 * side, 0.05), {0.13, 0.05, 0.04}});  // shoe
  }
  return body;
}

/// Returns the shapes of actors in W at a time.
inline std::vector<score::Surface> surfaces_of(const std::vector<Actor>& actors, double t_s) {
  std::vector<score::Surface> all;
  for (const Actor& actor : actors)
    for (score::Surface shape : shapes_of(actor)) {
      shape.X_WS = pose_at(script_of(actor), t_s) * shape.X_WS;
      all.push_back(shape);
    }
  return all;
}

}  // namespace sim::physics
