#include "sim/view/strips.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "sim/pages/html.h"
#include "sim/pages/run_data.h"
#include "walking/hrp2.h"

namespace sim::view {
namespace {

using pages::Figure;
using pages::kDeg;
using pages::kMm;
using pages::Role;

constexpr double kLoaded_n = 60, kUnloaded_n = 20;
enum { kPosition, kHeading, kNees, kLandmarks, kSlip, kMargin };  // as in Strips::figures

Figure strip(const char* name, const char* title, std::vector<std::pair<const char*, Role>> lines,
             std::vector<pages::Mark> levels = {}, bool bands = false) {
  Figure f{name, title, "time [s]", ""};
  for (const auto& [line, role] : lines) {
    f.lines.push_back({line, role});
    if (bands) f.envelopes.push_back({"", role});
  }
  f.levels = std::move(levels);
  return f;
}

void add_value(Figure& f, std::size_t line, double t, double value) {
  f.lines[line].x.push_back(t), f.lines[line].y.push_back(value);
}

void add_error(Figure& f, std::size_t line, double t, double error, double sigma) {
  add_value(f, line, t, error);
  f.envelopes[line].x.push_back(t);
  f.envelopes[line].low.push_back(-3 * sigma), f.envelopes[line].high.push_back(3 * sigma);
}

void add_corners(const Eigen::Vector3d& place, std::vector<cv::Point2f>& corners) {
  const Eigen::AlignedBox2d sole(walking::hrp2::kSoleMin, walking::hrp2::kSoleMax);
  for (int corner = 0; corner < 4; ++corner) {
    const Eigen::Vector2f p = (place.head<2>() + Eigen::Rotation2Dd(place.z()) *
                                                     sole.corner(Eigen::AlignedBox2d::CornerType(corner)))
                                  .cast<float>();
    corners.emplace_back(p.x(), p.y());
  }
}

}  // namespace

std::optional<Eigen::Vector2d> zero_moment_point(const std::array<SoleForce, 2>& soles) {
  Eigen::Vector2d weighted = Eigen::Vector2d::Zero();
  double load = 0;
  for (const SoleForce& sole : soles) {
    const Eigen::Vector2d from_moments(-sole.torque.y(), sole.torque.x());  // times the force
    weighted += sole.force.z() * sole.place.head<2>() + Eigen::Rotation2Dd(sole.place.z()) * from_moments;
    load += sole.force.z();
  }
  if (load < kUnloaded_n) return std::nullopt;
  return weighted / load;
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
  const pages::FrameError e = error_of(frame).value_or(pages::FrameError{});
  for (int axis = 0; axis < 3; ++axis)
    add_error(figures_[kPosition], static_cast<std::size_t>(axis), t, kMm * e.error(axis),
              kMm * e.sigma(axis));
  add_error(figures_[kHeading], 0, t, kDeg * e.error(3), kDeg * e.sigma(3));
  add_value(figures_[kNees], 0, t, e.nees.position);
  if (!frame.report) return;
  const auto& searched = frame.report->searched;
  const auto found = std::count_if(searched.begin(), searched.end(), [](const auto& s) { return s.used; });
  add_value(figures_[kLandmarks], 0, t, frame.report->landmarks);
  add_value(figures_[kLandmarks], 1, t, static_cast<double>(found));
}

void Strips::follow_feet(Frame& frame) {
  const double t = slam::seconds(frame.t);
  std::vector<cv::Point2f> corners;
  for (std::size_t i = 0; i < 2; ++i) {
    FootPlace& foot = (*frame.feet)[i];
    if (foot.load_n > kLoaded_n && !landed_[i]) landed_[i] = foot.truth;
    if (foot.load_n < kUnloaded_n) landed_[i].reset();
    foot.landed = landed_[i];
    add_value(figures_[kSlip], i, t, landed_[i] ? kMm * (foot.truth - *landed_[i]).head<2>().norm() : NAN);
    if (foot.load_n > kUnloaded_n) add_corners(foot.truth, corners);
  }
  frame.support.clear();
  if (corners.empty()) return;
  cv::convexHull(corners, frame.support);
  if (!frame.zmp) return;
  const cv::Point2f zmp(static_cast<float>(frame.zmp->x()), static_cast<float>(frame.zmp->y()));
  add_value(figures_[kMargin], 0, t, kMm * cv::pointPolygonTest(frame.support, zmp, true));
}

std::string strips_html(const std::vector<pages::Figure>& figures) {
  constexpr double kWidth = 400, kHeight = 150;
  std::string html;
  for (const Figure& figure : figures) html += figure_html(figure, "", kHeight, kWidth);
  return html;
}

}  // namespace sim::view
