#include "sim/camera/urdf.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

#include "sim/camera/shapes.h"

namespace sim::camera {
namespace {

std::string attributes(const Eigen::Isometry3d& X) {
  const Eigen::Matrix3d R = X.linear();  // Rz(yaw) Ry(pitch) Rx(roll)
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  return fmt::format(R"(xyz="{:.9g} {:.9g} {:.9g}" rpy="{:.9g} {:.9g} {:.9g}")", X.translation().x(),
                     X.translation().y(), X.translation().z(), std::atan2(R(2, 1), R(2, 2)), pitch,
                     std::atan2(R(1, 0), R(0, 0)));
}

Eigen::Isometry3d placed(const mjtNum* p, const mjtNum* q) {
  return Eigen::Translation3d(p[0], p[1], p[2]) *
         Eigen::Isometry3d(Eigen::Quaterniond(q[0], q[1], q[2], q[3]));
}

std::string visual(const Eigen::Isometry3d& X, const std::string& shape, const Eigen::Vector3f& rgb) {
  return fmt::format(
      "    <visual><origin {}/><geometry><{}/></geometry>"
      "<material name=\"\"><color rgba=\"{:.3g} {:.3g} {:.3g} 1\"/></material></visual>\n",
      attributes(X), shape, rgb.x(), rgb.y(), rgb.z());
}

std::string sphere(double radius) { return fmt::format("sphere radius=\"{:.9g}\"", radius); }

std::string visuals(const mjModel& model, int geom) {
  const mjtNum* const size = model.geom_size + 3 * geom;
  const Eigen::Isometry3d X = placed(model.geom_pos + 3 * geom, model.geom_quat + 4 * geom);
  const Eigen::Vector3f rgb = paint_of(model, geom).rgb;
  const auto cylinder = [&] {
    return visual(X, fmt::format(R"(cylinder radius="{:.9g}" length="{:.9g}")", size[0], 2 * size[1]), rgb);
  };
  switch (model.geom_type[geom]) {
    case mjGEOM_BOX:
      return visual(
          X, fmt::format(R"(box size="{:.9g} {:.9g} {:.9g}")", 2 * size[0], 2 * size[1], 2 * size[2]), rgb);
    case mjGEOM_SPHERE:
      return visual(X, sphere(size[0]), rgb);
    case mjGEOM_ELLIPSOID:
      return visual(X, sphere(std::cbrt(size[0] * size[1] * size[2])), rgb);
    case mjGEOM_CYLINDER:
      return cylinder();
    case mjGEOM_CAPSULE:
      return cylinder() + visual(X * Eigen::Translation3d(0, 0, size[1]), sphere(size[0]), rgb) +
             visual(X * Eigen::Translation3d(0, 0, -size[1]), sphere(size[0]), rgb);
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

// The only hinge of a body, which is then a joint of the robot; -1 for the ankles' bushes.
int hinge_of(const mjModel& model, int body) {
  const int first = model.body_jntadr[body];
  return model.body_jntnum[body] == 1 && model.jnt_type[first] == mjJNT_HINGE ? first : -1;
}

std::string joint(const mjModel& model, int body, const std::string& parent, const std::string& child) {
  const Eigen::Isometry3d X = placed(model.body_pos + 3 * body, model.body_quat + 4 * body);
  const int hinge = hinge_of(model, body);
  const std::string name = hinge < 0 ? child + "_fixed" : mj_id2name(&model, mjOBJ_JOINT, hinge);
  std::string text = fmt::format(
      "  <joint name=\"{}\" type=\"{}\">\n    <parent link=\"{}\"/><child link=\"{}\"/><origin {}/>\n", name,
      hinge < 0 ? "fixed" : "revolute", parent, child, attributes(X));
  if (hinge >= 0) {
    const mjtNum *axis = model.jnt_axis + 3 * hinge, *range = model.jnt_range + 2 * hinge;
    text += fmt::format(
        "    <axis xyz=\"{:.9g} {:.9g} {:.9g}\"/><limit lower=\"{:.9g}\" upper=\"{:.9g}\" effort=\"0\" "
        "velocity=\"0\"/>\n",
        axis[0], axis[1], axis[2], range[0], range[1]);
  }
  return text + "  </joint>\n";
}

int root_of(const mjModel& model) {
  for (int joint = 0; joint < model.njnt; ++joint)
    if (model.jnt_type[joint] == mjJNT_FREE) return model.jnt_bodyid[joint];
  throw std::invalid_argument("the model has no body with a free joint");
}

}  // namespace

std::string urdf(const mjModel& model) {
  const int root = root_of(model);
  const auto name = [&](int body) -> std::string {
    return body == root ? kUrdfRoot : mj_id2name(&model, mjOBJ_BODY, body);
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
