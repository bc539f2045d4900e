#include "sim/world/shadows.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "sim/world/canvas.h"

namespace sim::world {
namespace {

constexpr double kCell = 0.02;     // m, of the shadow's grid
constexpr double kReach = 0.8;     // m, beyond which nothing shades
constexpr double kFlush = 0.002;   // m: a plane this near another is part of it
constexpr double kDarkest = 0.55;  // share of the light that contact takes

using AxesByRow = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

struct Neighbour {
  Eigen::Vector2d centre, half;  // m, in the plane's frame
  double gap;                    // m, between plane and shape
};

Neighbour neighbour(const mjModel& model, const mjData& data, int plane, int geom) {
  const Eigen::Matrix3d R_WP = Eigen::Map<const AxesByRow>(data.geom_xmat + 9 * plane);
  const Eigen::Matrix3d R_WG = Eigen::Map<const AxesByRow>(data.geom_xmat + 9 * geom);
  const Eigen::Vector3d p_PG =
      R_WP.transpose() * (Eigen::Map<const Eigen::Vector3d>(data.geom_xpos + 3 * geom) -
                          Eigen::Map<const Eigen::Vector3d>(data.geom_xpos + 3 * plane));
  Eigen::Vector3d size = Eigen::Map<const Eigen::Vector3d>(model.geom_size + 3 * geom);
  const int type = model.geom_type[geom];
  if (type == mjGEOM_PLANE) size.z() = 0;
  if (type == mjGEOM_SPHERE) size.setConstant(size.x());
  if (type == mjGEOM_CYLINDER || type == mjGEOM_CAPSULE) size = {size.x(), size.x(), size.y()};
  const Eigen::Vector3d half = (R_WP.transpose() * R_WG).cwiseAbs() * size;
  return {p_PG.head<2>(), half.head<2>(), p_PG.z() - half.z()};
}

// Light left at a distance outside (positive) or inside an edge softened over `softness`.
double inside(double distance, double softness) {
  const double t = std::clamp(0.5 - distance / (2 * softness), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

void shade(cv::Mat1f& light, const Eigen::Vector2d& half_plane, const Neighbour& shape) {
  const double strength = kDarkest * std::exp(-shape.gap / 0.25), softness = 0.05 + 0.6 * shape.gap;
  const auto column = [&](double x) { return int((x + half_plane.x()) / kCell); };
  const auto row = [&](double y) { return int((half_plane.y() - y) / kCell); };
  const Eigen::Vector2d extent = shape.half.array() + softness;
  const cv::Rect area =
      cv::Rect(cv::Point(column(shape.centre.x() - extent.x()), row(shape.centre.y() + extent.y())),
               cv::Point(column(shape.centre.x() + extent.x()) + 1, row(shape.centre.y() - extent.y()) + 1)) &
      cv::Rect({0, 0}, light.size());
  for (int v = area.y; v < area.y + area.height; ++v)
    for (int u = area.x; u < area.x + area.width; ++u) {
      const double x = (u + 0.5) * kCell - half_plane.x(), y = half_plane.y() - (v + 0.5) * kCell;
      const double dark = inside(std::abs(x - shape.centre.x()) - shape.half.x(), softness) *
                          inside(std::abs(y - shape.centre.y()) - shape.half.y(), softness);
      light(v, u) = std::min(light(v, u), float(1 - strength * dark));
    }
}

}  // namespace

void bake_shadows(cv::Mat3b picture, const mjModel& model, const mjData& data, int plane) {
  const Eigen::Vector2d half(model.geom_size[3 * plane], model.geom_size[3 * plane + 1]);
  cv::Mat1f light(int(2 * half.y() / kCell), int(2 * half.x() / kCell), 1.0f);
  for (int geom = 0; geom < model.ngeom; ++geom) {
    if (geom == plane || model.body_weldid[model.geom_bodyid[geom]] != 0) continue;
    const Neighbour shape = neighbour(model, data, plane, geom);
    const bool shell = shape.half.maxCoeff() > 3;
    const bool part_of_plane = model.geom_type[geom] == mjGEOM_PLANE && std::abs(shape.gap) < kFlush;
    if (!shell && !part_of_plane && shape.gap > -0.01 && shape.gap < kReach) shade(light, half, shape);
  }
  cv::GaussianBlur(light, light, {0, 0}, 1.5);
  multiply(picture, light);
}

}  // namespace sim::world
