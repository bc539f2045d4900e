#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/score/types.h"

namespace sim::score {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

// A ray in a shape's axes: p + s d, s > 0. The functions below return the smallest s on the shape, or kNever.
struct Ray {
  Eigen::Vector3d p, d;
  Eigen::Vector3d at(double s) const { return p + s * d; }
};

// The interval of the ray's parameter inside a convex shape; empty if first > last.
struct Stretch {
  double first = -kNever, last = kNever;
};

Stretch both(const Stretch& a, const Stretch& b) {
  return {std::max(a.first, b.first), std::min(a.last, b.last)};
}

double entry(const Stretch& inside) {
  if (!(inside.first <= inside.last) || inside.last <= 0) return kNever;
  return inside.first > 0 ? inside.first : inside.last;
}

// |p_i + s d_i| <= half
Stretch slab(const Ray& ray, int axis, double half) {
  const double p = ray.p(axis), d = ray.d(axis);
  if (d == 0) return std::abs(p) <= half ? Stretch{} : Stretch{kNever, -kNever};
  const double a = (-half - p) / d, b = (half - p) / d;
  return {std::min(a, b), std::max(a, b)};
}

// a s² + 2 b s + c <= 0, a >= 0
Stretch below_zero(double a, double b, double c) {
  if (a == 0) return c <= 0 ? Stretch{} : Stretch{kNever, -kNever};
  const double discriminant = b * b - a * c;
  if (discriminant < 0) return {kNever, -kNever};
  const double root = std::sqrt(discriminant);
  return {(-b - root) / a, (-b + root) / a};
}

Stretch inside_ball(const Ray& ray, double radius) {
  return below_zero(ray.d.squaredNorm(), ray.p.dot(ray.d), ray.p.squaredNorm() - radius * radius);
}

Stretch inside_tube(const Ray& ray, double radius) {
  const Eigen::Vector2d p = ray.p.head<2>(), d = ray.d.head<2>();
  return below_zero(d.squaredNorm(), p.dot(d), p.squaredNorm() - radius * radius);
}

double hit_plane(const Ray& ray, const Eigen::Vector3d& size) {
  if (ray.p.z() <= 0 || ray.d.z() >= 0) return kNever;
  const double s = -ray.p.z() / ray.d.z();
  const Eigen::Vector3d at = ray.at(s);
  const bool within =
      (size.x() <= 0 || std::abs(at.x()) <= size.x()) && (size.y() <= 0 || std::abs(at.y()) <= size.y());
  return within ? s : kNever;
}

Stretch inside_cylinder(const Ray& ray, const Eigen::Vector3d& size) {
  return both(inside_tube(ray, size.x()), slab(ray, 2, size.y()));
}

// The union of a cylinder and two balls is convex, so the interval inside it spans the three intervals.
double hit_capsule(const Ray& ray, const Eigen::Vector3d& size) {
  const Eigen::Vector3d end(0, 0, size.y());
  Stretch inside{kNever, -kNever};
  for (const Stretch& part : {inside_cylinder(ray, size), inside_ball({ray.p - end, ray.d}, size.x()),
                              inside_ball({ray.p + end, ray.d}, size.x())})
    if (part.first <= part.last)
      inside = {std::min(inside.first, part.first), std::max(inside.last, part.last)};
  return entry(inside);
}

double hit_triangle(const Ray& ray, const Eigen::Vector3d& size) {
  const double s = ray.d.z() == 0 ? kNever : -ray.p.z() / ray.d.z();
  if (!(s > 0) || s == kNever) return kNever;
  const Eigen::Vector3d at = ray.at(s);
  const double c = at.y() / size.z(), b = (at.x() - c * size.y()) / size.x();  // weights of the corners
  return b >= 0 && c >= 0 && b + c <= 1 ? s : kNever;
}

double hit(const Surface& surface, const Ray& ray) {
  const Eigen::Vector3d& size = surface.size;
  switch (surface.kind) {
    case Surface::Kind::plane:
      return hit_plane(ray, size);
    case Surface::Kind::box:
      return entry(both(both(slab(ray, 0, size.x()), slab(ray, 1, size.y())), slab(ray, 2, size.z())));
    case Surface::Kind::sphere:
      return entry(inside_ball(ray, size.x()));
    case Surface::Kind::cylinder:
      return entry(inside_cylinder(ray, size));
    case Surface::Kind::ellipsoid:
      return entry(inside_ball({ray.p.cwiseQuotient(size), ray.d.cwiseQuotient(size)}, 1));
    case Surface::Kind::capsule:
      return hit_capsule(ray, size);
    case Surface::Kind::triangle:
      return hit_triangle(ray, size);
  }
  return kNever;
}

}  // namespace

std::optional<Hit> first_surface(const std::vector<Surface>& surfaces, const Eigen::Vector3d& origin,
                                 const Eigen::Vector3d& direction) {
  Hit first{0, kNever};
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const Eigen::Isometry3d X_SW = surfaces[i].X_WS.inverse();
    const double distance = hit(surfaces[i], {X_SW * origin, X_SW.linear() * direction});
    if (distance < first.distance) first = {i, distance};
  }
  if (first.distance == kNever) return std::nullopt;
  return first;
}

std::optional<double> first_hit(const std::vector<Surface>& surfaces, const Eigen::Vector3d& origin,
                                const Eigen::Vector3d& direction) {
  const auto first = first_surface(surfaces, origin, direction);
  if (!first) return std::nullopt;
  return first->distance;
}

}  // namespace sim::score
