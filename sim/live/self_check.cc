#include "sim/live/self_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "sim/files/json.h"
#include "sim/score/trajectory.h"
#include "walking/plan.h"

namespace sim::live {
namespace {

using namespace std::chrono_literals;

constexpr slam::Stamp kBegin = 10s, kLast = 30s;
constexpr double kBlow_m_s2 = 50;  // walking reaches 17
const Eigen::Vector3d kGravity_W(0, 0, -walking::kGravity);

void integrate(recording::TrueMotion& at, const Eigen::Vector3d& gyro, const Eigen::Vector3d& force,
               double dt) {
  const Eigen::Vector3d turned = gyro * dt;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(turned.norm(), turned.normalized()).toRotationMatrix();
  const Eigen::Matrix3d R = at.X_WG.linear(), R_end = R * turn;
  const Eigen::Vector3d a_W = (R * force + R_end * force) / 2 + kGravity_W, v = at.v_WG;
  at.v_WG += dt * a_W;
  at.X_WG.translation() += dt / 2 * (v + at.v_WG);
  at.X_WG.linear() = R_end;
}

double distance(const recording::TrueMotion& a, const recording::TrueMotion& b) {
  return (a.X_WG.translation() - b.X_WG.translation()).norm();
}
double yaw_between_deg(const recording::TrueMotion& a, const recording::TrueMotion& b) {
  return std::abs(score::yaw(a.X_WG.linear() * b.X_WG.linear().transpose())) * 180 / std::numbers::pi;
}

constexpr slam::Stamp kBetweenPairs = 1s, kApart = 400ms;
constexpr int kHalfPatch = 6, kSearch = 6, kMargin = kHalfPatch + kSearch + 2;
constexpr double kSame = 0.95;      // least correlation of a patch with its place in the later image
constexpr double kDistinct = 0.25;  // least ratio of its decreases in two directions, kRing px away
constexpr int kRing = 3;
constexpr std::size_t kFewest = 30;

cv::Rect around(cv::Point center, int half) {
  return {center.x - half, center.y - half, 2 * half + 1, 2 * half + 1};
}

// Returns where in (-1, 1) the parabola through three values at -1, 0 and 1 has its vertex.
double top(double before, double at, double after) {
  const double bend = before - 2 * at + after;
  return bend < 0 ? 0.5 * (before - after) / bend : 0;
}

struct Found {
  Eigen::Vector2d place;  // px from the middle of the window
  bool distinct;          // the correlation decreases in each direction, unlike along an edge
};

// Finds the patch. Returns nothing unless the correlation is high and its peak inside the window.
std::optional<Found> find(const cv::Mat& window, const cv::Mat& patch) {
  cv::Mat scores;
  cv::matchTemplate(window, patch, scores, cv::TM_CCOEFF_NORMED);
  double best = 0;
  cv::Point at;
  cv::minMaxLoc(scores, nullptr, &best, nullptr, &at);
  if (best < kSame || at.x < 1 || at.y < 1 || at.x >= scores.cols - 1 || at.y >= scores.rows - 1) return {};
  const auto score = [&](int u, int v) { return static_cast<double>(scores.at<float>(at.y + v, at.x + u)); };
  double least = 1, most = 0;  // decrease
  for (int u = -kRing; u <= kRing; ++u)
    for (int v = -kRing; v <= kRing; ++v)
      if (std::max(std::abs(u), std::abs(v)) == kRing &&
          cv::Rect({}, scores.size()).contains(at + cv::Point(u, v)))
        least = std::min(least, best - score(u, v)), most = std::max(most, best - score(u, v));
  return Found{{at.x + top(score(-1, 0), best, score(1, 0)) - (scores.cols - 1) / 2,
                at.y + top(score(0, -1), best, score(0, 1)) - (scores.rows - 1) / 2},
               least >= kDistinct * most};
}

}  // namespace

void InertialCheck::add(const slam::InertialSample& gyro, const slam::InertialSample& accelerometer,
                        const recording::TrueMotion& end) {
  if (accelerometer.value.norm() > kBlow_m_s2) {
    half.reset();
    return integrations.assign(1, {end, end});
  }
  const double dt = slam::seconds(gyro.end - gyro.begin);
  for (Integration& i : integrations) integrate(i.fine, gyro.value, accelerometer.value, dt);
  if (!half) {
    half.emplace(gyro.value, accelerometer.value);
    return;
  }
  const auto raise = [](Error& error, double now, double by_step) {
    error = {std::max(error.worst, now), std::max(error.by_step, by_step)};
  };
  for (Integration& i : integrations) {
    integrate(i.coarse, (half->first + gyro.value) / 2, (half->second + accelerometer.value) / 2, 2 * dt);
    longest = std::max(longest, end.t - i.fine.t);
    raise(position_m, distance(i.fine, end), distance(i.fine, i.coarse));
    raise(yaw_deg, yaw_between_deg(i.fine, end), yaw_between_deg(i.fine, i.coarse));
  }
  half.reset();
  if (end.t - integrations.back().fine.t >= kBegin) integrations.push_back({end, end});
  if (end.t - integrations.front().fine.t >= kLast) integrations.pop_front();
}

ViewCheck::ViewCheck(const slam::CameraIntrinsics& intrinsics, std::vector<score::Surface> surfaces)
    : camera_(intrinsics), surfaces_(std::move(surfaces)) {}

void ViewCheck::add(const cv::Mat& image, slam::Stamp t, const Eigen::Isometry3d& X_WC) {
  if (!first_.empty() && t - *first_t_ >= kApart) find_corners(image, X_WC);
  if (first_t_ && t - *first_t_ < kBetweenPairs) return;
  first_t_ = t;
  extract_corners(image, X_WC);
}

void ViewCheck::extract_corners(const cv::Mat& image, const Eigen::Isometry3d& X_WC) {
  first_ = image;
  corners_.clear();
  std::vector<cv::Point2f> found;
  cv::goodFeaturesToTrack(image, found, 40, 0.05, 10);
  for (const cv::Point pixel : found) {
    if (!camera_.inside({pixel.x, pixel.y}, kMargin)) continue;
    const Eigen::Vector3d ray = X_WC.linear() * camera_.unproject({pixel.x, pixel.y}).value().h.normalized();
    if (const auto distance = score::first_hit(surfaces_, X_WC.translation(), ray))
      corners_.push_back({pixel, X_WC.translation() + *distance * ray});
  }
}

// Returns nullopt if the point is out of sight.
std::optional<Eigen::Vector2d> ViewCheck::expected(const Eigen::Vector3d& p_W,
                                                   const Eigen::Isometry3d& X_WC) const {
  const auto seen = camera_.project(X_WC.inverse() * p_W);
  if (!seen || !camera_.inside(seen->pixel, kMargin)) return std::nullopt;
  const Eigen::Vector3d way = p_W - X_WC.translation();
  const auto hit = score::first_hit(surfaces_, X_WC.translation(), way.normalized());
  if (!hit || std::abs(*hit - way.norm()) > 0.01) return std::nullopt;
  return seen->pixel;
}

void ViewCheck::find_corners(const cv::Mat& image, const Eigen::Isometry3d& X_WC) {
  for (const Corner& corner : corners_) {
    const auto pixel = expected(corner.p_W, X_WC);
    if (!pixel) continue;
    const cv::Point near(static_cast<int>(std::lround(pixel->x())),
                         static_cast<int>(std::lround(pixel->y())));
    const auto found =
        find(image(around(near, kHalfPatch + kSearch)), first_(around(corner.pixel, kHalfPatch)));
    if (!found) continue;
    const double distance = (Eigen::Vector2d(near.x, near.y) + found->place - *pixel).norm();
    for (Distances* const each : {&all_, &distinct_})
      if (each == &all_ || found->distinct)
        ++each->counts[std::min(each->counts.size() - 1, static_cast<std::size_t>(20 * distance))],
            ++each->points;
  }
  first_.release();
}

std::optional<double> ViewCheck::Distances::median_px() const {
  if (points < kFewest) return std::nullopt;
  std::size_t below = 0, bin = 0;
  while (2 * (below + counts[bin]) < points) below += counts[bin++];
  return (static_cast<double>(bin) + 0.5) / 20;
}

const ViewCheck::Distances& ViewCheck::judged() const {
  return all_.median_px().value_or(0) > kView_px ? distinct_ : all_;
}

std::optional<std::string> SelfCheck::complaint() const {
  for (const auto& [what, error, own, unit] :
       {std::tuple("path", inertial.position_m, kInertialPosition_m, "m"),
        {"heading", inertial.yaw_deg, kInertialYaw_deg, "deg"}})
    if (!(error.worst <= own + error.by_step))
      return fmt::format(
          "self-check: the ideal gyro and accelerometer, integrated over {:.1f} s, deviate from the true {} "
          "by {:.4f} {}, more than {:.4g} {}",
          slam::seconds(inertial.longest), what, error.worst, unit, own + error.by_step, unit);
  const std::optional<double> distance = view ? view->median_px() : std::nullopt;
  if (distance && !(*distance <= kView_px))
    return fmt::format(
        "self-check: points of the room are {:.2f} px from their projections with the true pose, more than "
        "{} px",
        *distance, kView_px);
  return std::nullopt;
}

std::string SelfCheck::json() const {
  using Json = nlohmann::ordered_json;
  const auto figures = [](const InertialCheck::Error& error, double own) {
    return Json{{"worst", error.worst}, {"at_most", own + error.by_step}};
  };
  Json json{{"inertial_position_m", figures(inertial.position_m, kInertialPosition_m)},
            {"inertial_yaw_deg", figures(inertial.yaw_deg, kInertialYaw_deg)}};
  if (view) {
    const std::optional<double> distance = view->median_px();
    json["view_px"] = {{"median", distance ? Json(*distance) : Json(nullptr)},
                       {"points", view->points()},
                       {"at_most", kView_px}};
  }
  json["complaint"] = complaint().value_or("");
  return files::json_text(json, 2) + "\n";
}

}  // namespace sim::live
