#include "sim/camera/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <span>
#include <string_view>
#include <utility>

namespace sim::camera {
namespace {

using Eigen::Vector2f, Eigen::Vector3f;
using Kind = score::Surface::Kind;

constexpr int kSlices = 20;  // segments of round shapes around z
constexpr int kStacks = 3;   // segments of a hemisphere, from its equator to its pole

constexpr std::pair<int, Kind> kKinds[]{
    {mjGEOM_PLANE, Kind::plane},         {mjGEOM_BOX, Kind::box},
    {mjGEOM_SPHERE, Kind::sphere},       {mjGEOM_CYLINDER, Kind::cylinder},
    {mjGEOM_ELLIPSOID, Kind::ellipsoid}, {mjGEOM_CAPSULE, Kind::capsule}};

// Meshes and height fields consist of triangles.
Kind kind_of(const mjModel& model, int geom) {
  const auto found = std::ranges::find(kKinds, model.geom_type[geom], &std::pair<int, Kind>::first);
  return found == std::end(kKinds) ? Kind::triangle : found->second;
}

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

// A circle about z and the surface normal along it: its radial component and its z component.
struct Ring {
  float radius, z, normal_r, normal_z;
};

// The surface of revolution through two or more rings, from the lowest up.
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

// Adds rings of a sphere from one of its stacks to another; -kStacks and kStacks are its poles.
void add_sphere_rings(std::vector<Ring>& rings, int from, int to, float radius, float z) {
  for (int stack = from; stack <= to; ++stack) {
    const float elevation = std::numbers::pi_v<float> / 2 * float(stack) / kStacks;
    const float across = std::abs(stack) == kStacks ? 0 : std::cos(elevation), up = std::sin(elevation);
    rings.push_back({radius * across, z + radius * up, across, up});
  }
}

void add_ellipsoid(GeomMesh& mesh, const Vector3f& half) {
  std::vector<Ring> rings;
  add_sphere_rings(rings, -kStacks, kStacks, 1, 0);
  add_revolution(mesh, rings);
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
  std::vector<Ring> rings;
  add_sphere_rings(rings, -kStacks, 0, radius, -half);
  add_sphere_rings(rings, 0, kStacks, radius, half);
  add_revolution(mesh, rings);
}

bool is_mesh(const mjModel& model, int geom) { return model.geom_type[geom] == mjGEOM_MESH; }

// Two triangles per cell, as in MuJoCo's contacts and rays. A vertex has the normal of its face.
void add_height_field(GeomMesh& mesh, const mjModel& model, int field) {
  const int rows = model.hfield_nrow[field], columns = model.hfield_ncol[field];
  const Vector3f size = Eigen::Map<const Eigen::Vector3d>(model.hfield_size + 4 * field).cast<float>();
  const float* const data = model.hfield_data + model.hfield_adr[field];
  const auto point = [&](int row, int column) {
    return Vector3f(size.x() * (2 * float(column) / float(columns - 1) - 1),
                    size.y() * (2 * float(row) / float(rows - 1) - 1),
                    size.z() * data[row * columns + column]);
  };
  for (int row = 0; row + 1 < rows; ++row)
    for (int column = 0; column + 1 < columns; ++column) {
      const Vector3f a = point(row, column), b = point(row, column + 1), c = point(row + 1, column + 1),
                     d = point(row + 1, column);
      for (const std::array<Vector3f, 3>& face : {std::array{a, b, c}, std::array{a, c, d}}) {
        const Vector3f normal = (face[1] - face[0]).cross(face[2] - face[0]).normalized();
        for (const Vector3f& p : face) {
          mesh.indices.push_back(std::uint32_t(mesh.vertices.size()));
          mesh.vertices.push_back({p, normal});
        }
      }
    }
}

// Flat faces: a vertex has the normal of its face.
void add_mesh(GeomMesh& to, const mjModel& model, int mesh) {
  const int* const faces = model.mesh_face + 3 * model.mesh_faceadr[mesh];
  const int first = model.mesh_vertadr[mesh], texture = model.mesh_texcoordadr[mesh];
  const auto corner = [&](int i) { return Vector3f(model.mesh_vert + 3 * (first + faces[i])); };
  for (int i = 0; i < 3 * model.mesh_facenum[mesh]; ++i) {
    const int a = i - i % 3;
    const Vector3f normal = (corner(a + 1) - corner(a)).cross(corner(a + 2) - corner(a)).normalized();
    to.vertices.push_back({corner(i), normal});
    if (texture >= 0) to.vertices.back().uv = Vector2f(model.mesh_texcoord + 2 * (texture + faces[i]));
    to.indices.push_back(std::uint32_t(i));
  }
}

/// Appends the faces of a mesh that have an area.
void add_triangles(std::vector<score::Surface>& to, const mjModel& model, const mjData& data, int geom) {
  const GeomMesh mesh = geom_mesh(model, geom);
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto corner = [&](std::size_t k) {
      return Eigen::Vector3d(mesh.vertices[mesh.indices[i + k]].p.cast<double>());
    };
    const Eigen::Vector3d b = corner(1) - corner(0), c = corner(2) - corner(0), up = b.cross(c);
    if (up.norm() < 1e-12) continue;
    score::Surface& surface = to.emplace_back();
    Eigen::Isometry3d X_GS = Eigen::Isometry3d::Identity();
    X_GS.translation() = corner(0);
    X_GS.linear() << b.normalized(), up.cross(b).normalized(), up.normalized();
    surface.kind = Kind::triangle;
    surface.X_WS = geom_pose(data, geom) * X_GS;
    surface.size = {b.norm(), c.dot(X_GS.linear().col(0)), c.dot(X_GS.linear().col(1))};
  }
}

Vector3f rgb(const float* values) { return Eigen::Map<const Vector3f>(values); }

// MuJoCo leaves unused entries of size undefined.
score::Surface primitive(const mjModel& model, const mjData& data, int geom) {
  const Kind kind = kind_of(model, geom);
  Eigen::Vector3d size = Eigen::Map<const Eigen::Vector3d>(model.geom_size + 3 * geom);
  if (kind == Kind::sphere) size.setConstant(size.x());
  if (kind == Kind::plane || kind == Kind::cylinder || kind == Kind::capsule) size.z() = 0;
  return {kind, geom_pose(data, geom), size};
}

}  // namespace

physics::Data data_at_rest(const mjModel& model) {
  physics::Data data(mj_makeData(&model));
  physics::pose_bodies(model, *data);
  mj_camlight(&model, data.get());
  return data;
}

GeomMesh geom_mesh(const mjModel& model, int geom) {
  const Vector3f size = Eigen::Map<const Eigen::Vector3d>(model.geom_size + 3 * geom).cast<float>();
  GeomMesh mesh;
  if (is_mesh(model, geom)) {
    add_mesh(mesh, model, model.geom_dataid[geom]);
    if (model.mesh_texcoordadr[model.geom_dataid[geom]] >= 0) return mesh;
  }
  if (model.geom_type[geom] == mjGEOM_HFIELD) add_height_field(mesh, model, model.geom_dataid[geom]);
  const Kind kind = kind_of(model, geom);
  if (kind == Kind::plane)
    add_quad(mesh, Vector3f::Zero(), size.x() * Vector3f::UnitX(), size.y() * Vector3f::UnitY());
  if (kind == Kind::box) add_box(mesh, size);
  if (kind == Kind::sphere) add_ellipsoid(mesh, Vector3f::Constant(size.x()));
  if (kind == Kind::ellipsoid) add_ellipsoid(mesh, size);
  if (kind == Kind::cylinder) add_cylinder(mesh, size.x(), size.y());
  if (kind == Kind::capsule) add_capsule(mesh, size.x(), size.y());
  if (model.geom_matid[geom] >= 0)
    for (GeomMesh::Vertex& vertex : mesh.vertices) vertex.uv = picture_point(model, geom, vertex.p);
  return mesh;
}

Vector2f picture_point(const mjModel& model, int geom, const Vector3f& p) {
  const Vector3f size = Eigen::Map<const Eigen::Vector3d>(model.geom_size + 3 * geom).cast<float>();
  const int kind = model.geom_type[geom];
  const bool is_round = kind == mjGEOM_SPHERE || kind == mjGEOM_CYLINDER || kind == mjGEOM_CAPSULE;
  const Vector2f repeat = Eigen::Map<const Vector2f>(model.mat_texrepeat + 2 * model.geom_matid[geom]),
                 scale =
                     repeat.cwiseQuotient(is_round ? Vector2f::Constant(size.x()) : Vector2f(size.head<2>()));
  return {0.5f + 0.5f * scale.x() * p.x(), 0.5f - 0.5f * scale.y() * p.y()};
}

bool is_drawn(const mjModel& model, int geom, Robot robot) {
  return paint_of(model, geom).alpha > 0 && model.geom_group[geom] <= (robot == Robot::whole ? 2 : 1);
}

bool is_glass(const mjModel& model, int geom) { return paint_of(model, geom).alpha < 1; }

int texture_of(const mjModel& model, int geom) {
  const int material = model.geom_matid[geom], texture = material < 0 ? -1 : model.mat_texid[material];
  return texture >= 0 && model.tex_type[texture] == mjTEXTURE_2D ? texture : -1;
}

bool returns_light(const mjModel& model, int geom) {
  const int material = model.geom_matid[geom];
  const std::string_view name = material < 0 ? "" : mj_id2name(&model, mjOBJ_MATERIAL, material);
  return !name.starts_with("window") && !name.starts_with("screen");
}

// MuJoCo's rule: the color of a geom applies if it has no material or differs from the default.
Paint paint_of(const mjModel& model, int geom) {
  const int material = model.geom_matid[geom];
  const float* const color = model.geom_rgba + 4 * geom;
  if (material < 0) return {rgb(color), 0, color[3]};
  const bool own = !std::ranges::equal(std::span(color, 4), std::array{0.5f, 0.5f, 0.5f, 1.0f});
  const float* const shown = own ? color : model.mat_rgba + 4 * material;
  return {rgb(shown), model.mat_emission[material], shown[3]};
}

Lamps::Lamps(const mjModel& model) : ambient_(Vector3f::Zero()) {
  const physics::Data data = data_at_rest(model);
  if (model.vis.headlight.active) ambient_ = rgb(model.vis.headlight.ambient);
  for (int light = 0; light < model.nlight; ++light) {
    if (!model.light_active[light]) continue;
    ambient_ += rgb(model.light_ambient + 3 * light);
    lamps_.push_back({-Eigen::Map<const Eigen::Vector3d>(data->light_xdir + 3 * light).cast<float>(),
                      rgb(model.light_diffuse + 3 * light)});
  }
}

Vector3f Lamps::lit(const Paint& paint, const Vector3f& normal_W, float share) const {
  Vector3f light = ambient_;
  for (const Lamp& lamp : lamps_) light += std::max(0.0f, normal_W.dot(lamp.toward_W)) * lamp.diffuse;
  light = (share * light).array() + paint.emission;
  return paint.rgb.cwiseProduct(light).cwiseMin(1);
}

std::vector<score::Surface> room_surfaces(const mjModel& model) {
  const physics::Data data = data_at_rest(model);
  std::vector<score::Surface> surfaces;
  for (int geom = 0; geom < model.ngeom; ++geom)
    if (!moves(model, geom) && model.geom_group[geom] == 0 && !is_glass(model, geom))
      kind_of(model, geom) == Kind::triangle ? add_triangles(surfaces, model, *data, geom)
                                             : surfaces.push_back(primitive(model, *data, geom));
  return surfaces;
}

}  // namespace sim::camera
