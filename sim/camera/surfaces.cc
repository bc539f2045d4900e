#include "sim/camera/surfaces.h"

#include <memory>
#include <stdexcept>

namespace sim::camera {
namespace {

constexpr int kRoomGroup = 0;

RoomPrimitive::Kind kind_of(int type) {
  using Kind = RoomPrimitive::Kind;
  switch (type) {
    case mjGEOM_PLANE:
      return Kind::plane;
    case mjGEOM_BOX:
      return Kind::box;
    case mjGEOM_SPHERE:
      return Kind::sphere;
    case mjGEOM_CYLINDER:
      return Kind::cylinder;
    case mjGEOM_ELLIPSOID:
      return Kind::ellipsoid;
    case mjGEOM_CAPSULE:
      return Kind::capsule;
    default:
      throw std::invalid_argument(
          "a room may hold planes and other primitives only, no mesh or height field");
  }
}

// MuJoCo leaves unused entries of size free; here each kind has all three.
Eigen::Vector3d extents(RoomPrimitive::Kind kind, const Eigen::Vector3d& size) {
  using Kind = RoomPrimitive::Kind;
  if (kind == Kind::plane) return {size.x(), size.y(), 0};
  if (kind == Kind::sphere) return Eigen::Vector3d::Constant(size.x());
  if (kind == Kind::cylinder || kind == Kind::capsule) return {size.x(), size.x(), size.y()};
  return size;
}

RoomPrimitive primitive(const mjModel& model, const mjData& data, int geom) {
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  RoomPrimitive surface;
  surface.kind = kind_of(model.geom_type[geom]);
  surface.size = extents(surface.kind, Eigen::Map<const Eigen::Vector3d>(model.geom_size + 3 * geom));
  if (surface.kind == RoomPrimitive::Kind::plane && (surface.size.x() <= 0 || surface.size.y() <= 0))
    throw std::invalid_argument("a room's planes need a size");
  surface.X_WS = Eigen::Isometry3d::Identity();
  surface.X_WS.translation() = Eigen::Map<const Eigen::Vector3d>(data.geom_xpos + 3 * geom);
  surface.X_WS.linear() = Eigen::Map<const RowMajor>(data.geom_xmat + 9 * geom);
  return surface;
}

}  // namespace

std::vector<RoomPrimitive> room_primitives(const mjModel& model) {
  const std::unique_ptr<mjData, decltype(&mj_deleteData)> data(mj_makeData(&model), mj_deleteData);
  mj_kinematics(&model, data.get());
  std::vector<RoomPrimitive> surfaces;
  for (int geom = 0; geom < model.ngeom; ++geom)
    if (model.body_weldid[model.geom_bodyid[geom]] == 0 && model.geom_group[geom] == kRoomGroup)
      surfaces.push_back(primitive(model, *data, geom));
  return surfaces;
}

}  // namespace sim::camera
