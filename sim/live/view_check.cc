#include "sim/live/view_check.h"

#include <chrono>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace sim::live {
namespace {

using namespace std::chrono_literals;

constexpr slam::Stamp kBetweenPairs = 1s, kApart = 400ms;
constexpr int kHalfPatch = 6, kSearch = 6, kMargin = kHalfPatch + kSearch + 2;
constexpr double kSame = 0.95;  // least correlation of a patch with its place in the later image
constexpr std::size_t kFewest = 30;

cv::Rect around(cv::Point center, int half) {
  return {center.x - half, center.y - half, 2 * half + 1, 2 * half + 1};
}

// Where in (-1, 1) the parabola through three values at -1, 0 and 1 has its top.
double top(double before, double at, double after) {
  const double bend = before - 2 * at + after;
  return bend < 0 ? 0.5 * (before - after) / bend : 0;
}

// Place of the patch in pixels from the middle of the window; nothing unless the correlation is high and its
// peak inside.
std::optional<Eigen::Vector2d> find(const cv::Mat& window, const cv::Mat& patch) {
  cv::Mat scores;
  cv::matchTemplate(window, patch, scores, cv::TM_CCOEFF_NORMED);
  double best = 0;
  cv::Point at;
  cv::minMaxLoc(scores, nullptr, &best, nullptr, &at);
  if (best < kSame || at.x < 1 || at.y < 1 || at.x >= scores.cols - 1 || at.y >= scores.rows - 1) return {};
  const auto score = [&](int u, int v) { return static_cast<double>(scores.at<float>(at.y + v, at.x + u)); };
  return Eigen::Vector2d(at.x + top(score(-1, 0), best, score(1, 0)) - (scores.cols - 1) / 2,
                         at.y + top(score(0, -1), best, score(0, 1)) - (scores.rows - 1) / 2);
}

}  // namespace

ViewCheck::ViewCheck(const slam::CameraIntrinsics& intrinsics, std::vector<score::Surface> surfaces)
    : camera_(intrinsics), surfaces_(std::move(surfaces)) {}

void ViewCheck::add(const cv::Mat& image, slam::Stamp t, const Eigen::Isometry3d& X_WC) {
  if (!first_.empty() && t - *first_t_ >= kApart) find_corners(image, X_WC);
  if (!first_t_ || t - *first_t_ >= kBetweenPairs) extract_corners(image, t, X_WC);
}

void ViewCheck::extract_corners(const cv::Mat& image, slam::Stamp t, const Eigen::Isometry3d& X_WC) {
  first_t_ = t;
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

// Nothing where the point is out of sight.
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
    const double distance = (Eigen::Vector2d(near.x, near.y) + *found - *pixel).norm();
    ++distances_[std::min(distances_.size() - 1, static_cast<std::size_t>(20 * distance))];
    ++points_;
  }
  first_.release();
}

std::optional<double> ViewCheck::median_px() const {
  if (points_ < kFewest) return std::nullopt;
  std::size_t below = 0, bin = 0;
  while (2 * (below + distances_[bin]) < points_) below += distances_[bin++];
  return (static_cast<double>(bin) + 0.5) / 20;
}

}  // namespace sim::live
