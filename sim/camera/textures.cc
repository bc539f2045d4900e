#include <algorithm>
#include <bit>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "sim/camera/scene.h"
#include "sim/room/paint.h"

namespace sim::camera {
namespace {

constexpr double kLarge = 3;       // m: half of a wall or floor
constexpr double kCell = 0.02;     // m, cell size of the shadow grid
constexpr double kReach = 0.8;     // m, farther shapes cast no shadow
constexpr double kFlush = 0.002;   // m: a plane this close to another is part of it
constexpr double kDarkest = 0.55;  // fraction of the light lost at contact

struct Neighbor {
  Eigen::Vector2d center, half;  // m, in the plane's frame
  double gap;                    // m, between plane and shape
};

Neighbor neighbor(const mjModel& model, const mjData& data, int plane, int geom) {
  const Eigen::Isometry3d X_WP = geom_pose(data, plane), X_WG = geom_pose(data, geom);
  const Eigen::Matrix3d R_WP = X_WP.linear(), R_WG = X_WG.linear();
  const Eigen::Vector3d p_PG = R_WP.transpose() * (X_WG.translation() - X_WP.translation());
  Eigen::Vector3d size = Eigen::Map<const Eigen::Vector3d>(model.geom_size + 3 * geom);
  const int type = model.geom_type[geom];
  if (type == mjGEOM_PLANE) size.z() = 0;
  if (type == mjGEOM_SPHERE) size.setConstant(size.x());
  if (type == mjGEOM_CYLINDER || type == mjGEOM_CAPSULE) size = {size.x(), size.x(), size.y()};
  const Eigen::Vector3d half = (R_WP.transpose() * R_WG).cwiseAbs() * size;
  return {p_PG.head<2>(), half.head<2>(), p_PG.z() - half.z()};
}

// Fraction of the light left at a distance outside (positive) or inside an edge softened over `softness`.
double inside(double distance, double softness) {
  const double t = std::clamp(0.5 - distance / (2 * softness), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

void shade(cv::Mat1f& light, const Eigen::Vector2d& half_plane, const Neighbor& shape) {
  const double strength = kDarkest * std::exp(-shape.gap / 0.25), softness = 0.05 + 0.6 * shape.gap;
  const auto column = [&](double x) { return int((x + half_plane.x()) / kCell); };
  const auto row = [&](double y) { return int((half_plane.y() - y) / kCell); };
  const Eigen::Vector2d extent = shape.half.array() + softness;
  const Eigen::Vector2d low = shape.center - extent, high = shape.center + extent;
  const cv::Rect area =
      cv::Rect(cv::Point(column(low.x()), row(high.y())), cv::Point(column(high.x()) + 1, row(low.y()) + 1)) &
      cv::Rect({0, 0}, light.size());
  for (int v = area.y; v < area.y + area.height; ++v)
    for (int u = area.x; u < area.x + area.width; ++u) {
      const double x = (u + 0.5) * kCell - half_plane.x(), y = half_plane.y() - (v + 0.5) * kCell;
      const double dark = inside(std::abs(x - shape.center.x()) - shape.half.x(), softness) *
                          inside(std::abs(y - shape.center.y()) - shape.half.y(), softness);
      light(v, u) = std::min(light(v, u), float(1 - strength * dark));
    }
}

// Darkens the picture of a plane of the room below and around everything that is close to its front. The
// picture shows the plane from its front, with its upper left at (-x, +y) of the plane's frame.
void bake_shadows(cv::Mat3b picture, const mjModel& model, const mjData& data, int plane) {
  const Eigen::Vector2d half(model.geom_size[3 * plane], model.geom_size[3 * plane + 1]);
  cv::Mat1f light(int(2 * half.y() / kCell), int(2 * half.x() / kCell), 1.0f);
  for (int geom = 0; geom < model.ngeom; ++geom) {
    if (geom == plane || moves(model, geom) || is_glass(model, geom)) continue;
    const Neighbor shape = neighbor(model, data, plane, geom);
    const bool shell = shape.half.maxCoeff() > kLarge;
    const bool part_of_plane = model.geom_type[geom] == mjGEOM_PLANE && std::abs(shape.gap) < kFlush;
    if (!shell && !part_of_plane && shape.gap > -0.01 && shape.gap < kReach) shade(light, half, shape);
  }
  cv::GaussianBlur(light, light, {0, 0}, 1.5);
  room::multiply(picture, light);
}

// The large planes of the room: floor and walls. Pictures that repeat over their plane take no shadows.
bool takes_shadows(const mjModel& model, int geom) {
  const mjtNum* size = model.geom_size + 3 * geom;
  const int material = model.geom_matid[geom];
  return model.geom_type[geom] == mjGEOM_PLANE && std::max(size[0], size[1]) > kLarge && material >= 0 &&
         model.mat_texrepeat[2 * material] == 1;
}

// Area-averaged mipmaps: each level from the one above, down to one texel. Only the nearest level is sampled:
// blending two costs 6 % of a frame and finds corners no better.
void load(unsigned texture, cv::Mat picture) {
  const bool gray = picture.channels() == 1;
  const GLint kept = gray ? GL_R8 : GL_RGB8;
  const GLenum given = gray ? GL_RED : GL_RGB;
  GL(glBindTexture)(GL_TEXTURE_2D, texture);
  GL(glTexParameteri)(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
  GL(glPixelStorei)(GL_UNPACK_ALIGNMENT, 1);
  const auto levels = std::bit_width(unsigned(std::max(picture.cols, picture.rows)));
  GL(glTexStorage2D)(GL_TEXTURE_2D, levels, kept, picture.cols, picture.rows);
  for (int level = 0;; ++level) {
    GL(glTexSubImage2D)
    (GL_TEXTURE_2D, level, 0, 0, picture.cols, picture.rows, given, GL_UNSIGNED_BYTE, picture.data);
    if (picture.total() == 1) break;
    cv::Mat half;
    const cv::Size size(std::max(1, picture.cols / 2), std::max(1, picture.rows / 2));
    cv::resize(picture, half, size, 0, 0, cv::INTER_AREA);
    picture = half;
  }
}

}  // namespace

cv::Mat3b texture_picture(const mjModel& model, const mjData& data, int texture, std::uint64_t seed) {
  const char* const name = mj_id2name(&model, mjOBJ_TEXTURE, texture);
  const cv::Mat own(model.tex_height[texture], model.tex_width[texture], CV_8UC3,
                    model.tex_rgb + model.tex_adr[texture]);
  const bool flat = std::equal(own.data + 3, own.data + 3 * own.total(), own.data);
  const cv::Mat3b painted = name && flat ? room::paint_texture(name, seed) : cv::Mat3b();
  if (painted.empty()) return own.clone();
  for (int geom = 0; geom < model.ngeom; ++geom)
    if (takes_shadows(model, geom) && texture_of(model, geom) == texture)
      bake_shadows(painted, model, data, geom);
  return painted;
}

std::vector<unsigned> load_textures(const mjModel& model, std::uint64_t seed, Channels channels) {
  const physics::Data data = data_at_rest(model);
  std::vector<unsigned> names(std::size_t(model.ntex));
  GL(glGenTextures)(model.ntex, names.data());
  for (int texture = 0; texture < model.ntex; ++texture) {
    if (model.tex_type[texture] != mjTEXTURE_2D) continue;
    cv::Mat picture = texture_picture(model, *data, texture, seed);
    if (channels == Channels::gray) cv::cvtColor(picture, picture, cv::COLOR_RGB2GRAY);
    load(names[std::size_t(texture)], picture);
  }
  GL(glFinish)();  // other contexts may now use them
  return names;
}

}  // namespace sim::camera
