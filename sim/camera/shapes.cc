#include "sim/camera/shapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/physics/model.h"

namespace sim::camera {
namespace {

using Eigen::Vector2f, Eigen::Vector3f;

constexpr int kSlices = 20;  // of round shapes about z
constexpr int kStacks = 3;   // of half a sphere, from its equator to its pole

void add_quad(GeomMesh& mesh, const Vector3f& middle, const Vector3f& right, const Vector3f& up) {
  const auto first = std::uint32_t(mesh.vertices.size());
  const Vector3f normal = right.cross(up).normalized();
  for (const Vector2f& corner : {Vector2f(-1, -1), Vector2f(1, -1), Vector2f(1, 1), Vector2f(-1, 1)})
    mesh.vertices.push_back({middle + corner.x() * right + corner.y() * up, normal});
  for (const std::uint32_t i : {0, 1, 2, 0, 2, 3}) mesh.indices.push_back(first + i);
}

void add_box(GeomMesh& mesh, const Vector3f& half) {
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {1.0f, -1.0f}) {
      const int next = (axis + 1) % 3, last = (axis + 2) % 3;
      add_quad(mesh, side * half[axis] * Vector3f::Unit(axis), side * half[next] * Vector3f::Unit(next),
               half[last] * Vector3f::Unit(last));
    }
}

// A circle about z, and the normal of the surface along it: its parts along the radius and along z.
struct Ring {
  float radius, z, normal_r, normal_z;
};

// The surface of revolution through two rings or more, from the lowest up.
void add_revolution(GeomMesh& mesh, const std::vector<Ring>& rings) {
  const auto first = std::uint32_t(mesh.vertices.size());
  for (const Ring& ring : rings)
    for (int slice = 0; slice <= kSlices; ++slice) {
      const float angle = 2 * std::numbers::pi_v<float> * float(slice % kSlices) / kSlices;
      const Vector3f out(std::cos(angle), std::sin(angle), 0);
      mesh.vertices.push_back({ring.radius * out + ring.z * Vector3f::UnitZ(),
                               ring.normal_r * out + ring.normal_z * Vector3f::UnitZ()});
    }
  for (std::uint32_t row = 0; row + 1 < rings.size(); ++row)
    for (std::uint32_t slice = 0; slice < kSlices; ++slice) {
      const std::uint32_t a = first + row * (kSlices + 1) + slice, b = a + 1, d = a + kSlices + 1, c = d + 1;
      if (rings[row].radius > 0) mesh.indices.insert(mesh.indices.end(), {a, b, c});
      if (rings[row + 1].radius > 0) mesh.indices.insert(mesh.indices.end(), {a, c, d});
    }
}

// Rings of a unit sphere from one of its stacks to another; -kStacks and kStacks are its poles.
std::vector<Ring> sphere_rings(int from, int to, float radius, float z) {
  std::vector<Ring> rings;
  for (int stack = from; stack <= to; ++stack) {
    const float elevation = std::numbers::pi_v<float> / 2 * float(stack) / kStacks;
    const float across = std::abs(stack) == kStacks ? 0 : std::cos(elevation), up = std::sin(elevation);
    rings.push_back({radius * across, z + radius * up, across, up});
  }
  return rings;
}

void add_ellipsoid(GeomMesh& mesh, const Vector3f& half) {
  add_revolution(mesh, sphere_rings(-kStacks, kStacks, 1, 0));
  for (GeomMesh::Vertex& vertex : mesh.vertices) {
    vertex.p = vertex.p.cwiseProduct(half);
    vertex.normal = vertex.normal.cwiseQuotient(half).normalized();
  }
}

void add_cylinder(GeomMesh& mesh, float radius, float half) {
  add_revolution(mesh, {{0, -half, 0, -1}, {radius, -half, 0, -1}});
  add_revolution(mesh, {{radius, -half, 1, 0}, {radius, half, 1, 0}});
  add_revolution(mesh, {{radius, half, 0, 1}, {0, half, 0, 1}});
}

void add_capsule(GeomMesh& mesh, float radius, float half) {
  std::vector<Ring> rings = sphere_rings(-kStacks, 0, radius, -half);
  for (const Ring& ring : sphere_rings(0, kStacks, radius, half)) rings.push_back(ring);
  add_revolution(mesh, rings);
}

// Vertex normals, except those more than 37 degrees from the triangle's normal, at an edge.
void add_triangles(GeomMesh& mesh, const mjModel& model, int id) {
  const float* const points = model.mesh_vert + 3 * model.mesh_vertadr[id];
  const float* const normals = model.mesh_normal + 3 * model.mesh_vertadr[id];
  for (int face = model.mesh_faceadr[id]; face < model.mesh_faceadr[id] + model.mesh_facenum[id]; ++face) {
    std::array<Vector3f, 3> p, n;
    for (int i = 0; i < 3; ++i) {
      const int vertex = model.mesh_face[3 * face + i];
      p[i] = Eigen::Map<const Vector3f>(points + 3 * vertex);
      n[i] = Eigen::Map<const Vector3f>(normals + 3 * vertex);
    }
    const Vector3f flat = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    for (int i = 0; i < 3; ++i) {
      mesh.indices.push_back(std::uint32_t(mesh.vertices.size()));
      mesh.vertices.push_back({p[i], n[i].dot(flat) < 0.8f ? flat : n[i]});
    }
  }
}

void map_texture(GeomMesh& mesh, const mjModel& model, int geom, const Vector3f& size) {
  const int material = model.geom_matid[geom];
  if (material < 0) return;
  Vector2f scale = Eigen::Map<const Vector2f>(model.mat_texrepeat + 2 * material);
  if (!model.mat_texuniform[material]) scale = scale.cwiseQuotient(size.head<2>());
  for (GeomMesh::Vertex& vertex : mesh.vertices)
    vertex.uv = {0.5f + 0.5f * scale.x() * vertex.p.x(), 0.5f - 0.5f * scale.y() * vertex.p.y()};
}

}  // namespace

GeomMesh geom_mesh(const mjModel& model, int geom) {
  const Vector3f size = Eigen::Map<const Eigen::Vector3d>(model.geom_size + 3 * geom).cast<float>();
  GeomMesh mesh;
  switch (model.geom_type[geom]) {
    case mjGEOM_PLANE:
      add_quad(mesh, Vector3f::Zero(), size.x() * Vector3f::UnitX(), size.y() * Vector3f::UnitY());
      break;
    case mjGEOM_BOX:
      add_box(mesh, size);
      break;
    case mjGEOM_SPHERE:
      add_ellipsoid(mesh, Vector3f::Constant(size.x()));
      break;
    case mjGEOM_ELLIPSOID:
      add_ellipsoid(mesh, size);
      break;
    case mjGEOM_CYLINDER:
      add_cylinder(mesh, size.x(), size.y());
      break;
    case mjGEOM_CAPSULE:
      add_capsule(mesh, size.x(), size.y());
      break;
    case mjGEOM_MESH:
      add_triangles(mesh, model, model.geom_dataid[geom]);
      return mesh;
    default:
      throw std::invalid_argument("a geom of this kind cannot be drawn: primitives and meshes can");
  }
  map_texture(mesh, model, geom,
              model.geom_type[geom] == mjGEOM_PLANE || model.geom_type[geom] == mjGEOM_BOX ||
                      model.geom_type[geom] == mjGEOM_ELLIPSOID
                  ? size
                  : Vector3f::Constant(size.x()));
  return mesh;
}

namespace {

Eigen::Vector3f rgb(const float* values) { return Eigen::Map<const Eigen::Vector3f>(values); }

// MuJoCo's rule: the color of a geom applies if it has no material or differs from the default.
bool own_color(const mjModel& model, int geom) {
  const float* color = model.geom_rgba + 4 * geom;
  return model.geom_matid[geom] < 0 || color[0] != 0.5f || color[1] != 0.5f || color[2] != 0.5f ||
         color[3] != 1.0f;
}

}  // namespace

bool is_drawn(const mjModel& model, int geom, Robot robot) {
  const int material = model.geom_matid[geom];
  const float alpha = material < 0 ? model.geom_rgba[4 * geom + 3] : model.mat_rgba[4 * material + 3];
  return alpha > 0 && model.geom_group[geom] <= (robot == Robot::whole ? 2 : 1);
}

Paint paint_of(const mjModel& model, int geom) {
  const int material = model.geom_matid[geom];
  return {rgb(own_color(model, geom) ? model.geom_rgba + 4 * geom : model.mat_rgba + 4 * material),
          material < 0 ? 0 : model.mat_emission[material]};
}

Lamps::Lamps(const mjModel& model, const mjData& data) : ambient_(Eigen::Vector3f::Zero()) {
  if (model.vis.headlight.active) ambient_ = rgb(model.vis.headlight.ambient);
  for (int light = 0; light < model.nlight; ++light) {
    if (!model.light_active[light]) continue;
    if (!model.light_directional[light] || model.body_weldid[model.light_bodyid[light]] != 0)
      throw std::invalid_argument("a lamp is not directional or not fixed to the room: it cannot be drawn");
    ambient_ += rgb(model.light_ambient + 3 * light);
    lamps_.push_back({-Eigen::Map<const Eigen::Vector3d>(data.light_xdir + 3 * light).cast<float>(),
                      rgb(model.light_diffuse + 3 * light)});
  }
}

Eigen::Vector3f Lamps::lit(const Paint& paint, const Eigen::Vector3f& normal_W, float share) const {
  Eigen::Vector3f light = ambient_;
  for (const Lamp& lamp : lamps_) light += std::max(0.0f, normal_W.dot(lamp.towards_W)) * lamp.diffuse;
  light = (share * light).array() + paint.emission;
  return paint.rgb.cwiseProduct(light).cwiseMin(1);
}

namespace {

constexpr int kRoomGroup = 0;

score::Surface::Kind kind_of(int type) {
  using Kind = score::Surface::Kind;
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
          "a room may only contain planes and other primitives, not meshes or height fields");
  }
}

// MuJoCo leaves unused entries of size undefined.
Eigen::Vector3d extents(score::Surface::Kind kind, const Eigen::Vector3d& size) {
  using Kind = score::Surface::Kind;
  if (kind == Kind::plane) return {size.x(), size.y(), 0};
  if (kind == Kind::sphere) return Eigen::Vector3d::Constant(size.x());
  if (kind == Kind::cylinder || kind == Kind::capsule) return {size.x(), size.y(), 0};
  return size;
}

score::Surface primitive(const mjModel& model, const mjData& data, int geom) {
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  score::Surface surface;
  surface.kind = kind_of(model.geom_type[geom]);
  surface.size = extents(surface.kind, Eigen::Map<const Eigen::Vector3d>(model.geom_size + 3 * geom));
  if (surface.kind == score::Surface::Kind::plane && (surface.size.x() <= 0 || surface.size.y() <= 0))
    throw std::invalid_argument("a room's planes need a size");
  surface.X_WS = Eigen::Isometry3d::Identity();
  surface.X_WS.translation() = Eigen::Map<const Eigen::Vector3d>(data.geom_xpos + 3 * geom);
  surface.X_WS.linear() = Eigen::Map<const RowMajor>(data.geom_xmat + 9 * geom);
  return surface;
}

}  // namespace

std::vector<score::Surface> room_surfaces(const mjModel& model) {
  const physics::Data data(mj_makeData(&model));
  mj_kinematics(&model, data.get());
  std::vector<score::Surface> surfaces;
  for (int geom = 0; geom < model.ngeom; ++geom)
    if (model.body_weldid[model.geom_bodyid[geom]] == 0 && model.geom_group[geom] == kRoomGroup)
      surfaces.push_back(primitive(model, *data, geom));
  return surfaces;
}

}  // namespace sim::camera
