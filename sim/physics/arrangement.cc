#include "sim/physics/arrangement.h"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <numbers>

#include "sim/model_file/model_file.h"
#include "sim/sensor_errors/random.h"
#include "walking/timeline.h"

namespace sim::physics {
namespace {

using Eigen::AlignedBox3d, Eigen::Isometry3d, Eigen::Vector2d, Eigen::Vector3d;
using sensor_errors::Random;

constexpr double kCorridor_m = 0.7;  // half a walking robot's width, its sway and its drift
constexpr double kTouch_m =
    0.01;                        // pieces closer than this stand together; lower shapes are part of the floor
constexpr double kFeet_m = 0.1;  // some models lack casters
constexpr int kDraws = 20;

/// Returns the path of the commands at the walk's support phases, in the room's frame.
std::vector<Vector2d> path_of(const walking::WalkOptions& walk, const Isometry3d& X_RW) {
  std::vector<Vector2d> path{X_RW.translation().head<2>()};
  for (const walking::Phase& phase : walking::Timeline({}, walk, {}, Vector2d::Zero()).phases()) {
    const Vector2d p_W = walking::center_of(phase.to).position;
    path.push_back((X_RW * Vector3d(p_W.x(), p_W.y(), 0)).head<2>());
  }
  return path;
}

Isometry3d pose_of(const mjModel& m, int body) {
  return turned_pose_in(m.body_pos + 3 * body, m.body_quat + 4 * body);
}

void set_pose(mjModel& m, int body, const Isometry3d& X) {
  Eigen::Map<Vector3d>(m.body_pos + 3 * body) = X.translation();
  const Eigen::Quaterniond q(X.linear());
  Eigen::Map<Eigen::Vector4d>(m.body_quat + 4 * body) << q.w(), q.x(), q.y(), q.z();
}

class Room {
 public:
  Room(mjModel& m, std::vector<Vector2d> path) : m_(m), data_(mj_makeData(&m)), path_(std::move(path)) {
    mj_kinematics(&m_, data_.get());
    for (int geom = 0; geom < m_.ngeom; ++geom)
      if (m_.body_weldid[m_.geom_bodyid[geom]] == 0) boxes_.push_back({geom, box(geom)});
  }

  /// Returns the pieces of furniture.
  std::vector<int> pieces() const {
    std::vector<int> all;
    for (int body = 1; body < m_.nbody; ++body)
      if (m_.body_parentid[body] == 0 && m_.body_weldid[body] == 0 && stands_alone(body)) all.push_back(body);
    return all;
  }

  /// Returns whether the piece found a place.
  bool move(int body, const WorldOptions::Moved& moved) {
    Random random(moved.seed, "furniture " + name_of(m_, mjOBJ_BODY, body), std::uint64_t(body));
    const Isometry3d X = pose_of(m_, body);
    const std::vector<Box> before = boxes_of(body);
    const double was_near = distance(before);
    for (int draw = 0; draw < kDraws; ++draw) {
      const double way = 2 * std::numbers::pi * random.uniform(),
                   length = moved.largest_m * std::sqrt(random.uniform()),
                   turn = moved.largest_rad * (2 * random.uniform() - 1);
      Isometry3d to = X;
      to.prerotate(Eigen::AngleAxisd(turn, Vector3d::UnitZ()));
      to.translation() = X.translation() + length * Vector3d(std::cos(way), std::sin(way), 0);
      set_pose(m_, body, to);
      const std::vector<Box> after = placed(body);
      if (distance(after) >= std::min(kCorridor_m, was_near) && is_free(body, before, after)) return true;
    }
    set_pose(m_, body, X);
    placed(body);
    return false;
  }

 private:
  struct Box {
    int geom;
    AlignedBox3d box;
  };

  AlignedBox3d box(int geom) const { return box_around(m_, *data_, geom); }
  bool is_part(int geom, int body) const {
    int of = m_.geom_bodyid[geom];
    while (m_.body_parentid[of] != 0) of = m_.body_parentid[of];
    return of == body;
  }
  std::vector<Box> boxes_of(int body) const {
    std::vector<Box> all;
    for (const Box& each : boxes_)
      if (is_part(each.geom, body)) all.push_back(each);
    return all;
  }

  /// Computes where the piece is now.
  std::vector<Box> placed(int body) {
    mj_kinematics(&m_, data_.get());
    for (Box& each : boxes_)
      if (is_part(each.geom, body)) each.box = box(each.geom);
    return boxes_of(body);
  }

  bool stands_alone(int body) const {
    const std::vector<Box> own = boxes_of(body);
    double lowest = 1, highest = 0;
    for (const auto& [geom, box] : own) {
      if (m_.geom_contype[geom] == model_file::kSteppedBits) return false;
      lowest = std::min(lowest, box.min().z()), highest = std::max(highest, box.max().z());
    }
    return std::abs(lowest) < kFeet_m && highest > kTouch_m && is_free(body, own, own);
  }

  /// Returns whether nothing else is where the piece's parts are before and after a move, or between.
  bool is_free(int body, const std::vector<Box>& before, const std::vector<Box>& after) const {
    for (std::size_t i = 0; i < before.size(); ++i) {
      const AlignedBox3d swept = before[i].box.merged(after[i].box);
      for (const auto& [geom, box] : boxes_)
        if (box.max().z() > kTouch_m && !is_part(geom, body) && swept.exteriorDistance(box) < kTouch_m)
          return false;
    }
    return true;
  }

  /// Returns the horizontal distance of a piece from the path, m.
  double distance(const std::vector<Box>& piece) const {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [geom, box] : piece)
      for (const Vector2d& p : path_)
        least = std::min(least,
                         Eigen::AlignedBox2d(box.min().head<2>(), box.max().head<2>()).exteriorDistance(p));
    return least;
  }

  mjModel& m_;
  Data data_;
  std::vector<Vector2d> path_;
  std::vector<Box> boxes_;  // around all shapes of the room
};

/// Moves the pose in MuJoCo's arrays from the left.
void move(const Isometry3d& X, mjtNum* position, mjtNum* quaternion) {
  const Isometry3d moved = X * turned_pose_in(position, quaternion);
  const Eigen::Quaterniond q(moved.linear());
  Eigen::Map<Vector3d>(position, 3) = moved.translation();
  Eigen::Map<Eigen::Vector4d>(quaternion, 4) << q.w(), q.vec();
}

void move_room(mjModel& m, const Isometry3d& X) {
  for (int body = 1; body < m.nbody; ++body)
    if (m.body_parentid[body] == 0 && m.body_weldid[body] == 0 && m.body_mocapid[body] < 0)
      move(X, m.body_pos + 3 * body, m.body_quat + 4 * body);
  for (int geom = 0; geom < m.ngeom; ++geom) {
    if (m.geom_bodyid[geom] != 0) continue;
    move(X, m.geom_pos + 3 * geom, m.geom_quat + 4 * geom);
    m.geom_sameframe[geom] = 0;
  }
}

void turn_lamps(mjModel& m, double angle) {
  const Data data(mj_makeData(&m));
  mj_kinematics(&m, data.get());
  for (int light = 0; light < m.nlight; ++light) {
    const int body = m.light_bodyid[light];
    const Eigen::Matrix3d R_WB = pose_in(data->xpos + 3 * body, data->xmat + 9 * body).linear();
    Eigen::Map<Vector3d> along_B(m.light_dir + 3 * light);
    along_B = R_WB.transpose() * (Eigen::AngleAxisd(angle, Vector3d::UnitZ()) * (R_WB * along_B));
  }
}

}  // namespace

int arrange(mjModel& m, const WorldOptions& world, const walking::WalkOptions& walk) {
  const WorldOptions::Start& start = world.start;
  int moved = 0;
  if (world.moved.seed != 0) {
    Room room(m, path_of(walk, start.X_RW()));
    for (const int body : room.pieces()) moved += room.move(body, world.moved);
  }
  if (world.light.turn_rad != 0) turn_lamps(m, world.light.turn_rad);
  if (start.is_default()) return moved;
  move_room(m, start.X_RW().inverse());
  for (int light = 0; light < m.nlight; ++light)  // lamps of the room's bodies have moved with them
    if (m.light_bodyid[light] == 0) {
      Eigen::Map<Vector3d> along(m.light_dir + 3 * light);
      along = Eigen::AngleAxisd(-start.yaw_rad, Vector3d::UnitZ()) * Vector3d(along);
    }
  return moved;
}

}  // namespace sim::physics
