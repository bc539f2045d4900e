#include "sim/world/scene.h"

#include <GL/gl.h>

#include <algorithm>
#include <array>

#include "sim/world/textures.h"

namespace sim::world {
namespace {

constexpr float kNear = 0.05f, kFar = 40.0f;
constexpr int kSpareGeoms = 200;  // beyond the model's own: screens over the unsampled parts of the picture

// Planes through the camera's centre along the four sides of the view: normals in the camera's frame,
// pointing inside.
std::array<Eigen::Vector3f, 4> view_sides(const Pinhole& view) {
  const float l = float(view.left), t = float(view.top);
  const float r = l + float(view.width_px / view.focal_px), b = t + float(view.height_px / view.focal_px);
  return {Eigen::Vector3f(1, 0, -l).normalized(), Eigen::Vector3f(-1, 0, r).normalized(),
          Eigen::Vector3f(0, 1, -t).normalized(), Eigen::Vector3f(0, -1, b).normalized()};
}

// Half the extent of a geom along a direction of its own frame; never less than the true one.
float half_extent(const mjvGeom& geom, const Eigen::Vector3f& direction) {
  Eigen::Vector3f half(geom.size[0], geom.size[1], geom.size[2]);
  if (geom.type == mjGEOM_PLANE) half.z() = 0;
  if (geom.type == mjGEOM_CAPSULE) half.z() += half.x();
  return half.dot(direction.cwiseAbs());
}

struct Placement {
  Eigen::Vector3f position;  // in the camera's frame
  Eigen::Matrix3f axes;
};

Placement seen_from(const mjvGeom& geom, const Eigen::Isometry3f& X_CW) {
  using RowMajor = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;
  return {X_CW * Eigen::Map<const Eigen::Vector3f>(geom.pos),
          X_CW.linear() * Eigen::Map<const RowMajor>(geom.mat)};
}

bool in_view(const mjvGeom& geom, const Placement& placed, const std::array<Eigen::Vector3f, 4>& sides) {
  if (geom.type == mjGEOM_PLANE && placed.position.dot(placed.axes.col(2)) > 0)
    return false;  // seen from behind
  return std::all_of(sides.begin(), sides.end(), [&](const Eigen::Vector3f& side) {
    return placed.position.dot(side) + half_extent(geom, placed.axes.transpose() * side) > 0;
  });
}

float farthest_depth(const mjvGeom& geom, const Placement& placed) {
  return placed.position.z() + half_extent(geom, placed.axes.row(2).transpose());
}

// A black screen before the camera that fills a rectangle of the picture.
mjvGeom screen(const cv::Rect& area, const Eigen::Isometry3d& X_WC, const Pinhole& pinhole) {
  constexpr double depth = 1.1 * kNear;
  const auto at = [&](double x, double y) -> Eigen::Vector3d {
    return depth *
           Eigen::Vector3d(pinhole.left + x / pinhole.focal_px, pinhole.top + y / pinhole.focal_px, 1);
  };
  const Eigen::Vector3d corner = at(area.x, area.y), opposite = at(area.x + area.width, area.y + area.height);
  const mjtNum size[3] = {(opposite - corner).x() / 2, (opposite - corner).y() / 2, 0};
  const Eigen::Vector3d p_W = X_WC * Eigen::Vector3d((corner + opposite) / 2);
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> axes = X_WC.linear();
  axes.rightCols<2>() *= -1;  // its front towards the camera
  const float black[4] = {0, 0, 0, 1};
  mjvGeom geom;
  mjv_initGeom(&geom, mjGEOM_PLANE, size, p_W.data(), axes.data(), black);
  return geom;
}

}  // namespace

Scene::Scene(const mjModel& model, int width_px, int height_px, int samples, std::uint64_t texture_seed)
    : model_(model), gl_(model, width_px, height_px, samples) {
  upload_textures(model, gl_.mjr(), texture_seed);
  mjv_defaultScene(&scene_);
  mjv_makeScene(&model_, &scene_, model.ngeom + kSpareGeoms);
  std::fill_n(scene_.flags, mjNRNDFLAG, mjtByte{0});
  scene_.flags[mjRND_CULL_FACE] = 1;
}

Scene::~Scene() { mjv_freeScene(&scene_); }

void Scene::dim(float light) {
  for (mjvLight* lamp = scene_.lights; lamp != scene_.lights + scene_.nlight; ++lamp)
    for (int channel = 0; channel < 3; ++channel)
      lamp->ambient[channel] *= light, lamp->diffuse[channel] *= light;
  for (mjvGeom* geom = scene_.geoms; geom != scene_.geoms + scene_.ngeom; ++geom)
    if (geom->type == mjGEOM_PLANE && geom->mat[8] < -0.9f) geom->emission *= light;
}

void Scene::place_camera(const Eigen::Isometry3d& X_WC, const Pinhole& pinhole) {
  mjvGLCamera camera{};
  Eigen::Map<Eigen::Vector3f>(camera.pos) = X_WC.translation().cast<float>();
  Eigen::Map<Eigen::Vector3f>(camera.forward) = X_WC.linear().col(2).cast<float>();
  Eigen::Map<Eigen::Vector3f>(camera.up) = -X_WC.linear().col(1).cast<float>();
  const double width = pinhole.width_px / pinhole.focal_px, height = pinhole.height_px / pinhole.focal_px;
  camera.frustum_center = float(kNear * (pinhole.left + width / 2));
  camera.frustum_top = float(-kNear * pinhole.top);
  camera.frustum_bottom = float(-kNear * (pinhole.top + height));
  camera.frustum_near = kNear, camera.frustum_far = kFar;
  scene_.camera[0] = scene_.camera[1] = camera;
}

void Scene::cover_unsampled(const Eigen::Isometry3d& X_WC, const Pinhole& pinhole) {
  for (const cv::Rect& area : pinhole.unsampled) scene_.geoms[scene_.ngeom++] = screen(area, X_WC, pinhole);
}

// What is outside the view is dropped, the rest drawn from near to far so that hidden surfaces cost no
// texturing.
void Scene::cull_and_sort(const Eigen::Isometry3d& X_WC, const Pinhole& pinhole) {
  const auto sides = view_sides(pinhole);
  const Eigen::Isometry3f X_CW = X_WC.inverse().cast<float>();
  mjvGeom* const end = scene_.geoms + scene_.ngeom;
  mjvGeom* const kept = std::remove_if(
      scene_.geoms, end, [&](const mjvGeom& geom) { return !in_view(geom, seen_from(geom, X_CW), sides); });
  for (mjvGeom* geom = scene_.geoms; geom != kept; ++geom)
    geom->camdist = farthest_depth(*geom, seen_from(*geom, X_CW));
  std::stable_sort(scene_.geoms, kept,
                   [](const mjvGeom& a, const mjvGeom& b) { return a.camdist < b.camdist; });
  scene_.ngeom = int(kept - scene_.geoms);
}

cv::Mat3b Scene::draw(const mjData& data, const Eigen::Isometry3d& X_WC, const Pinhole& pinhole, bool head,
                      float light) {
  gl_.make_current();
  mjvOption option;
  mjv_defaultOption(&option);
  std::fill_n(option.flags, mjNVISFLAG, mjtByte{0});
  option.flags[mjVIS_TEXTURE] = option.flags[mjVIS_STATIC] = 1;
  std::fill_n(option.sitegroup, mjNGROUP, mjtByte{0});
  std::fill_n(option.geomgroup, mjNGROUP, mjtByte{0});
  option.geomgroup[0] = option.geomgroup[1] = 1;
  option.geomgroup[2] = head;
  mjvCamera unused;
  mjv_defaultCamera(&unused);
  // mjv_updateScene takes a non-const mjData for its perturbation and inertia displays, which are off.
  mjv_updateScene(&model_, const_cast<mjData*>(&data), &option, nullptr, &unused, mjCAT_ALL, &scene_);
  if (light != 1) dim(light);
  place_camera(X_WC, pinhole);
  cover_unsampled(X_WC, pinhole);
  cull_and_sort(X_WC, pinhole);
  const mjrRect viewport{0, 0, pinhole.width_px, pinhole.height_px};
  mjr_render(viewport, &scene_, &gl_.mjr());
  cv::Mat3b picture(pinhole.height_px, pinhole.width_px);
  mjr_readPixels(picture.data, nullptr, viewport, &gl_.mjr());
  return picture;
}

}  // namespace sim::world
