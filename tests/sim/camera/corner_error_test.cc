// Accuracy of corners in frames: found positions against projections of the true surfaces.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "sim/camera/head_camera.h"
#include "sim/score/surfaces.h"
#include "tests/sim/physics/test_worlds.h"
#include "walking/hrp2.h"

namespace sim::camera {
using namespace physics;
namespace {

/// Errors of corners found again. px; all zero when there were none.
struct CornerError {
  int corners = 0;
  double rms_px = 0;
  Eigen::Vector2d mean_px{0, 0};
};

using Eigen::Vector2d, Eigen::Vector3d;

constexpr int kHalfPatch = 5, kSearch = 3;
constexpr double kSameMatch = 0.9;

struct View {
  cv::Mat1b image;
  Eigen::Isometry3d X_WC;
};

View view_from(HeadCamera& camera, mjData& data, double yaw) {
  stand_on_circle(data, yaw);
  const cv::Mat1b image = camera.render(data);
  mj_kinematics(&camera.model(), &data);
  mj_camlight(&camera.model(), &data);
  return {image.clone(), camera_pose(camera.model(), data, "head_camera")};
}

std::optional<Vector3d> surface_at(const CameraModel& lens, const View& view,
                                   const std::vector<score::Surface>& room, const Vector2d& uv) {
  const Vector3d ray = view.X_WC.linear() * lens.direction(uv).homogeneous().normalized();
  const std::optional<double> distance = score::first_hit(room, view.X_WC.translation(), ray);
  if (!distance) return std::nullopt;
  return view.X_WC * Vector3d(0, 0, 0) + *distance * ray;
}

// The point of the room at a pixel if the patch around it lies on one plane.
std::optional<Vector3d> flat_patch(const CameraModel& lens, const View& view,
                                   const std::vector<score::Surface>& room, const Vector2d& uv) {
  const auto middle = surface_at(lens, view, room, uv);
  if (!middle) return std::nullopt;
  for (const Vector2d& arm : {Vector2d(kHalfPatch, kHalfPatch), Vector2d(kHalfPatch, -kHalfPatch),
                              Vector2d(kHalfPatch, 0), Vector2d(0, kHalfPatch)}) {
    const auto one = surface_at(lens, view, room, uv + arm), other = surface_at(lens, view, room, uv - arm);
    if (!one || !other) return std::nullopt;
    const Vector3d along = (*one - *other).normalized(), off = *middle - *other;
    if ((off - along * along.dot(off)).norm() > 0.005 * (*middle - view.X_WC.translation()).norm())
      return std::nullopt;
  }
  return middle;
}

// Peak of a parabola through three neighbouring values, from the middle one.
double peak(double before, double at, double after) {
  const double bend = before - 2 * at + after;
  return bend < 0 ? 0.5 * (before - after) / bend : 0;
}

std::optional<Vector2d> found_again(const cv::Mat1b& first, cv::Point at, const cv::Mat1b& second,
                                    const Vector2d& expected) {
  const int half = kHalfPatch, reach = kHalfPatch + kSearch;
  const cv::Point guess(int(std::lround(expected.x())), int(std::lround(expected.y())));
  const cv::Rect inside(reach, reach, second.cols - 2 * reach, second.rows - 2 * reach);
  if (!inside.contains(guess)) return std::nullopt;
  const cv::Mat1b patch = first(cv::Rect(at.x - half, at.y - half, 2 * half + 1, 2 * half + 1));
  const cv::Mat1b area = second(cv::Rect(guess.x - reach, guess.y - reach, 2 * reach + 1, 2 * reach + 1));
  cv::Mat1f match;
  cv::matchTemplate(area, patch, match, cv::TM_CCOEFF_NORMED);
  double best;
  cv::Point where;
  cv::minMaxLoc(match, nullptr, &best, nullptr, &where);
  if (best < kSameMatch || !cv::Rect(1, 1, match.cols - 2, match.rows - 2).contains(where))
    return std::nullopt;
  const auto m = [&](int dx, int dy) { return double(match(where + cv::Point(dx, dy))); };
  return Vector2d(guess.x - kSearch + where.x + peak(m(-1, 0), m(0, 0), m(1, 0)),
                  guess.y - kSearch + where.y + peak(m(0, -1), m(0, 0), m(0, 1)));
}

std::vector<cv::Point2f> corners_of(const cv::Mat1b& image) {
  cv::Mat1b inner(image.size(), uchar(0));
  inner(cv::Rect(12, 12, image.cols - 24, image.rows - 24)) = 255;
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(image, corners, 60, 0.02, 12, inner, 11);
  return corners;
}

CornerError summary(const std::vector<Vector2d>& errors) {
  CornerError result;
  result.corners = int(errors.size());
  if (errors.empty()) return result;
  std::vector<double> size;
  for (const Vector2d& e : errors) size.push_back(e.norm()), result.mean_px += e / double(errors.size());
  const double squares = std::inner_product(size.begin(), size.end(), size.begin(), 0.0);
  result.rms_px = std::sqrt(squares / double(size.size()));
  return result;
}

/// Strong corners of a frame are searched in another, a little further on the circle, by correlation of 11x11
/// patches, refined by a parabola, and compared with the projection of the room's true surface through the
/// lens. Patches across the edge of something nearer are left out, as are those that correlate below 0.9.
CornerError corner_error(HeadCamera& camera, int headings, double turn_rad) {
  const std::vector<score::Surface> room = room_surfaces(camera.model());
  const physics::Data data(mj_makeData(&camera.model()));
  std::vector<Vector2d> errors;
  for (int step = 0; step < headings; ++step) {
    const double yaw = 2 * CV_PI * step / headings;
    const View first = view_from(camera, *data, yaw), second = view_from(camera, *data, yaw + turn_rad);
    for (const cv::Point2f& corner : corners_of(first.image)) {
      const cv::Point at(int(corner.x), int(corner.y));
      const auto p_W = flat_patch(camera.camera(), first, room, Vector2d(at.x, at.y));
      if (!p_W) continue;
      const Vector2d expected = camera.camera().project(second.X_WC.inverse() * *p_W);
      const auto found = found_again(first.image, at, second.image, expected);
      if (found) errors.push_back(*found - expected);
    }
  }
  return summary(errors);
}

// Anti-aliasing for sub-pixel work, at both sizes, without and with multisampling. Measured here
// over 24 headings: 0.15 px without, 0.14 px with; a sampled edge without any smoothing gives 0.25 px.
TEST(HeadCamera, CornersAreFoundAgainWithinAFifthOfAPixel) {
  const std::filesystem::path models = std::filesystem::path(GAITSLAM_SOURCE_DIR) / "models";
  for (auto [width, samples] : {std::pair(320, 0), std::pair(320, 4), std::pair(640, 0)}) {
    CameraOptions options;
    options.width_px = width, options.height_px = width * 3 / 4, options.samples = samples;
    HeadCamera camera(load_model("hrp2", "office", models), options);
    const CornerError error = corner_error(camera, 6, 0.04 * 320 / width);
    EXPECT_GT(error.corners, 100) << width << " " << samples;
    EXPECT_LT(error.rms_px, 0.20) << width << " " << samples;
    EXPECT_LT(error.mean_px.norm(), 0.05) << width << " " << samples;  // 0.2 px / sqrt(100), two sigma
  }
}

}  // namespace
}  // namespace sim::camera
