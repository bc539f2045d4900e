#include "sim/view/strips.h"

#include <algorithm>
#include <cmath>

#include "sim/pages/html.h"
#include "sim/pages/run_data.h"
#include "walking/hrp2.h"

namespace sim::view {
namespace {

using Eigen::Vector2d;
using pages::Figure;
using pages::kDeg;
using pages::kMm;
using pages::Role;

constexpr double kLoaded_n = 60, kUnloaded_n = 20;

double cross(const Vector2d& o, const Vector2d& a, const Vector2d& b) {
  return (a - o).x() * (b - o).y() - (a - o).y() * (b - o).x();
}

Vector2d turned(double yaw, const Vector2d& v) { return Eigen::Rotation2Dd(yaw) * v; }

std::array<Vector2d, 4> sole_corners(const Eigen::Vector3d& place) {
  using walking::hrp2::kSoleMax, walking::hrp2::kSoleMin;
  std::array<Vector2d, 4> corners{Vector2d(kSoleMin.x(), kSoleMin.y()), Vector2d(kSoleMax.x(), kSoleMin.y()),
                                  Vector2d(kSoleMax.x(), kSoleMax.y()), Vector2d(kSoleMin.x(), kSoleMax.y())};
  for (Vector2d& corner : corners) corner = place.head<2>() + turned(place.z(), corner);
  return corners;
}

std::vector<Vector2d> half_hull(const auto& sorted) {
  std::vector<Vector2d> chain;
  for (const Vector2d& p : sorted) {
    while (chain.size() > 1 && cross(chain[chain.size() - 2], chain.back(), p) <= 0) chain.pop_back();
    chain.push_back(p);
  }
  chain.pop_back();
  return chain;
}

Figure strip(const char* name, const char* title, std::vector<std::pair<const char*, Role>> lines,
             std::vector<pages::Level> levels = {}, bool bands = false) {
  Figure f{name, title, "time [s]", ""};
  for (const auto& [line, role] : lines) {
    f.lines.push_back({line, role});
    if (bands) f.envelopes.push_back({"", role});
  }
  f.levels = std::move(levels);
  return f;
}

void add(Figure& f, std::size_t line, double t, double value) {
  f.lines[line].x.push_back(t), f.lines[line].y.push_back(value);
}

void add(Figure& f, std::size_t line, double t, double value, double band) {
  add(f, line, t, value);
  f.envelopes[line].x.push_back(t);
  f.envelopes[line].low.push_back(-band), f.envelopes[line].high.push_back(band);
}

}  // namespace

std::optional<Vector2d> zero_moment_point(const std::array<SoleForce, 2>& soles) {
  Vector2d weighted = Vector2d::Zero();
  double load = 0;
  for (const SoleForce& sole : soles) {
    const Vector2d from_moments(-sole.torque.y(), sole.torque.x());  // times the force
    weighted += sole.force.z() * sole.place.head<2>() + turned(sole.place.z(), from_moments);
    load += sole.force.z();
  }
  if (load < kUnloaded_n) return std::nullopt;
  return weighted / load;
}

std::vector<Vector2d> convex_hull(std::vector<Vector2d> points) {
  if (points.size() < 3) return points;
  std::sort(points.begin(), points.end(), [](const Vector2d& a, const Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  std::vector<Vector2d> hull = half_hull(points);
  std::reverse(points.begin(), points.end());
  for (const Vector2d& p : half_hull(points)) hull.push_back(p);
  return hull;
}

double margin_inside(const std::vector<Vector2d>& polygon, const Vector2d& p) {
  double margin = INFINITY;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    margin = std::min(margin, cross(a, b, p) / (b - a).norm());
  }
  return margin;
}

Strips::Strips()
    : figures_{strip("position", "Position error with 3σ [mm]",
                     {{"x", Role::estimate}, {"y", Role::plan}, {"z", Role::first}}, {}, true),
               strip("heading", "Heading error with 3σ [deg]", {{"heading", Role::estimate}}, {}, true),
               strip("nees", "NEES of the position (3 expected, 95 % below 7.8)", {{"NEES", Role::estimate}},
                     {{"expected", 3}, {"95 %", 7.81}, {"", 0}}),
               strip("landmarks", "Landmarks", {{"in the map", Role::first}, {"found", Role::estimate}},
                     {{"", 0}}),
               strip("slip", "Slip of the standing soles [mm]",
                     {{"left", Role::estimate}, {"right", Role::plan}}, {{"", 0}}),
               strip("margin", "ZMP: distance inside the support polygon [mm]", {{"margin", Role::estimate}},
                     {{"", 0}})} {}

void Strips::add(Frame& frame) {
  const double t = slam::seconds(frame.t);
  if (frame.feet) follow_feet(frame);
  // The lines break in frames without an estimate.
  const pages::FrameError error = error_of(frame).value_or(pages::FrameError{Eigen::Vector4d::Constant(NAN)});
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    view::add(figures_[0], axis, t, kMm * error.error(i), 3 * kMm * error.sigma(i));
  }
  view::add(figures_[1], 0, t, kDeg * error.error(3), 3 * kDeg * error.sigma(3));
  view::add(figures_[2], 0, t, error.nees);
  if (!frame.report) return;
  const auto& searched = frame.report->searched;
  view::add(figures_[3], 0, t, frame.report->landmarks);
  view::add(figures_[3], 1, t,
            static_cast<double>(std::count_if(searched.begin(), searched.end(),
                                              [](const slam::Search& search) { return search.used; })));
}

void Strips::follow_feet(Frame& frame) {
  const double t = slam::seconds(frame.t);
  std::vector<Vector2d> corners;
  for (std::size_t i = 0; i < 2; ++i) {
    FootPlace& foot = (*frame.feet)[i];
    if (foot.load_n > kLoaded_n && !landed_[i]) landed_[i] = foot.truth;
    if (foot.load_n < kUnloaded_n) landed_[i].reset();
    foot.landed = landed_[i];
    view::add(figures_[4], i, t,
              landed_[i] ? kMm * (foot.truth - *landed_[i]).head<2>().norm() : std::nan(""));
    if (foot.load_n <= kUnloaded_n) continue;
    for (const Vector2d& corner : sole_corners(foot.truth)) corners.push_back(corner);
  }
  frame.support = convex_hull(std::move(corners));
  if (frame.zmp && !frame.support.empty())
    view::add(figures_[5], 0, t, kMm * margin_inside(frame.support, *frame.zmp));
}

std::string strips_html(const std::vector<pages::Figure>& figures) {
  constexpr double kWidth = 400, kHeight = 150;
  std::string html;
  for (const Figure& figure : figures) html += figure_html(figure, "", kHeight, kWidth);
  return html;
}

}  // namespace sim::view
