#include "sim/camera/drawn_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "sim/camera/scene.h"
#include "sim/physics/nominal_body.h"

namespace sim::camera {
namespace {

Eigen::Isometry3d pose_in_body(const mjModel& model, int geom) {
  return physics::turned_pose_in(model.geom_pos + 3 * geom, model.geom_quat + 4 * geom);
}

void append(std::vector<float>& to, const auto& vector) {
  to.insert(to.end(), vector.data(), vector.data() + vector.size());
}

void add_geom(DrawnPiece& piece, const mjModel& model, int geom, const Eigen::Isometry3f& X) {
  const GeomMesh mesh = geom_mesh(model, geom);
  const Paint paint = paint_of(model, geom);
  const auto first = std::uint32_t(piece.positions.size() / 3);
  for (const GeomMesh::Vertex& vertex : mesh.vertices) {
    append(piece.positions, Eigen::Vector3f(X * vertex.p));
    append(piece.normals, Eigen::Vector3f(X.linear() * vertex.normal));
    append(piece.colors, paint.rgb);
    if (piece.picture >= 0) append(piece.uv, vertex.uv);
  }
  for (const std::uint32_t index : mesh.indices) piece.indices.push_back(first + index);
}

// Adds a value that is not in the list yet.
template <class Value>
int index_of(std::vector<Value>& list, const Value& value) {
  const auto found = std::ranges::find(list, value);
  if (found != list.end()) return int(found - list.begin());
  list.push_back(value);
  return int(list.size()) - 1;
}

std::string attributes(const Eigen::Isometry3d& X) {
  const Eigen::Matrix3d R = X.linear();  // Rz(yaw) Ry(pitch) Rx(roll)
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  return fmt::format(R"(xyz="{:.9g} {:.9g} {:.9g}" rpy="{:.9g} {:.9g} {:.9g}")", X.translation().x(),
                     X.translation().y(), X.translation().z(), std::atan2(R(2, 1), R(2, 2)), pitch,
                     std::atan2(R(1, 0), R(0, 0)));
}

std::string visuals(const mjModel& model, int geom) {
  const mjtNum* const size = model.geom_size + 3 * geom;
  const Eigen::Isometry3d X = pose_in_body(model, geom);
  const Paint paint = paint_of(model, geom);
  const auto visual = [&](double z, const std::string& shape) {
    return fmt::format(
        "    <visual><origin {}/><geometry><{}/></geometry>"
        "<material name=\"\"><color rgba=\"{:.3g} {:.3g} {:.3g} {:.3g}\"/></material></visual>\n",
        attributes(X * Eigen::Translation3d(0, 0, z)), shape, paint.rgb.x(), paint.rgb.y(), paint.rgb.z(),
        paint.alpha);
  };
  const auto sphere = [&](double z, double radius) {
    return visual(z, fmt::format("sphere radius=\"{:.9g}\"", radius));
  };
  const auto cylinder = [&] {
    return visual(0, fmt::format(R"(cylinder radius="{:.9g}" length="{:.9g}")", size[0], 2 * size[1]));
  };
  switch (model.geom_type[geom]) {
    case mjGEOM_BOX:
      return visual(0,
                    fmt::format(R"(box size="{:.9g} {:.9g} {:.9g}")", 2 * size[0], 2 * size[1], 2 * size[2]));
    case mjGEOM_SPHERE:
      return sphere(0, size[0]);
    case mjGEOM_ELLIPSOID:
      return sphere(0, std::cbrt(size[0] * size[1] * size[2]));
    case mjGEOM_CYLINDER:
      return cylinder();
    case mjGEOM_CAPSULE:
      return cylinder() + sphere(size[1], size[0]) + sphere(-size[1], size[0]);
    default:
      return "";
  }
}

std::string link(const mjModel& model, int body, const std::string& name) {
  std::string text;
  for (int geom = 0; geom < model.ngeom; ++geom)
    if (model.geom_bodyid[geom] == body && is_drawn(model, geom)) text += visuals(model, geom);
  return fmt::format("  <link name=\"{}\">\n{}  </link>\n", name, text);
}

// A body's only hinge is a joint of the robot; the ankles' bushings are fixed.
std::string joint(const mjModel& model, int body, const std::string& parent, const std::string& child) {
  const int first = model.body_jntadr[body];
  const bool hinge = model.body_jntnum[body] == 1 && model.jnt_type[first] == mjJNT_HINGE;
  std::string text = fmt::format(
      "  <joint name=\"{}\" type=\"{}\">\n    <parent link=\"{}\"/><child link=\"{}\"/><origin {}/>\n",
      hinge ? mj_id2name(&model, mjOBJ_JOINT, first) : child + "_fixed", hinge ? "revolute" : "fixed", parent,
      child, attributes(physics::turned_pose_in(model.body_pos + 3 * body, model.body_quat + 4 * body)));
  if (hinge) {
    const mjtNum *axis = model.jnt_axis + 3 * first, *range = model.jnt_range + 2 * first;
    text += fmt::format(
        "    <axis xyz=\"{:.9g} {:.9g} {:.9g}\"/><limit lower=\"{:.9g}\" upper=\"{:.9g}\" effort=\"0\" "
        "velocity=\"0\"/>\n",
        axis[0], axis[1], axis[2], range[0], range[1]);
  }
  return text + "  </joint>\n";
}

}  // namespace

std::vector<float> body_poses(const mjModel& model, const mjData& data,
                              const std::vector<std::string>& bodies) {
  std::vector<float> poses;
  for (const std::string& body : bodies) {
    const int id = mj_name2id(&model, mjOBJ_BODY, body.c_str());
    if (id < 0) throw std::invalid_argument("the model has no body " + body);
    const mjtNum *p = data.xpos + 3 * id, *q = data.xquat + 4 * id;
    for (const mjtNum value : {p[0], p[1], p[2], q[1], q[2], q[3], q[0]}) poses.push_back(float(value));
  }
  return poses;
}

PosedRobot::PosedRobot(const physics::RobotFile& robot, const physics::WorldOptions& world,
                       const fs::path& models)
    : model_(physics::arranged(physics::load_model(robot, world.room, models), world)),
      data_(data_at_rest(*model_)),
      robot_(physics::read_robot(*model_, robot)) {
  std::map<std::tuple<int, int, float>, DrawnPiece> pieces;  // by body, picture and alpha
  for (int geom = 0; geom < model_->ngeom; ++geom) {
    if (!is_drawn(*model_, geom)) continue;
    const char* const body = mj_id2name(model_.get(), mjOBJ_BODY, model_->geom_bodyid[geom]);
    const float alpha = paint_of(*model_, geom).alpha;
    const int texture = alpha < 1 ? -1 : texture_of(*model_, geom);
    const bool moving = moves(*model_, geom);
    const std::tuple key(moving ? index_of(bodies_, std::string(body ? body : "")) : -1,
                         texture < 0 ? -1 : index_of(textures_, texture), alpha);
    DrawnPiece& piece = pieces[key];
    std::tie(piece.body, piece.picture, piece.alpha) = key;
    const Eigen::Isometry3d X = moving ? pose_in_body(*model_, geom) : geom_pose(*data_, geom);
    add_geom(piece, *model_, geom, X.cast<float>());
  }
  for (auto& [key, piece] : pieces) pieces_.push_back(std::move(piece));
}

std::vector<cv::Mat3b> PosedRobot::pictures(std::uint64_t seed, int largest_px) const {
  const physics::Data data = data_at_rest(*model_);
  std::vector<cv::Mat3b> pictures;
  for (const int texture : textures_) {
    const cv::Mat3b whole = texture_picture(*model_, *data, texture, seed);
    const auto side = [&](int px) { return int(std::bit_floor(unsigned(std::min(px, largest_px)))); };
    cv::resize(whole, pictures.emplace_back(), {side(whole.cols), side(whole.rows)}, 0, 0, cv::INTER_AREA);
  }
  return pictures;
}

std::vector<float> PosedRobot::poses(const walking::BodyPose& pose) {
  const Eigen::VectorXd q = physics::robot_positions(*model_, pose);
  std::ranges::copy(q, data_->qpos);
  mj_kinematics(model_.get(), data_.get());
  return body_poses(*model_, *data_, bodies_);
}

std::string urdf(const mjModel& model) {
  const auto free = std::find(model.jnt_type, model.jnt_type + model.njnt, mjJNT_FREE) - model.jnt_type;
  const int root = model.jnt_bodyid[free];
  const auto name = [&](int body) -> std::string {
    return body == root ? "waist" : mj_id2name(&model, mjOBJ_BODY, body);
  };
  std::string text = "<?xml version=\"1.0\"?>\n<robot name=\"gaitslam\">\n";
  for (int body = root; body < model.nbody; ++body) {
    if (model.body_rootid[body] != root) continue;
    text += link(model, body, name(body));
    if (body != root) text += joint(model, body, name(model.body_parentid[body]), name(body));
  }
  return text + "</robot>\n";
}

}  // namespace sim::camera
