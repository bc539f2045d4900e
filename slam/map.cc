#include "slam/map.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "slam/active_search.h"
#include "slam/corner_detector.h"
#include "slam/line_search.h"
#include "slam/surface.h"

namespace slam {
namespace {

constexpr int kTries = 5;
constexpr double kApart = 20;          // px between a new landmark and the others
constexpr double kFewInView = 12;      // landmarks, up to which a box has a quarter of the image's sides
constexpr double kSigmas = 3;          // around a known landmark's pixel
constexpr double kChangedView = 0.02;  // way over distance; less is swaying, which comes back

/// A box at a random place that leaves room for the patch; small enough that `visible` of them may lie apart.
cv::Rect random_box(const cv::Mat& image, int visible, std::mt19937_64& random) {
  const int margin = kSourceHalf + 1;
  const double side = std::min(1.0, std::sqrt(kFewInView / visible)) / 4;  // of the image's
  const int width = static_cast<int>(side * image.cols), height = static_cast<int>(side * image.rows);
  const auto below = [&random](int n) { return static_cast<int>(random() % static_cast<std::uint64_t>(n)); };
  const int x = margin + below(image.cols - 2 * margin - width + 1);
  const int y = margin + below(image.rows - 2 * margin - height + 1);
  return {x, y, width, height};
}

bool holds_any(const cv::Rect& box, const std::vector<Eigen::Vector2d>& pixels) {
  return std::any_of(pixels.begin(), pixels.end(),
                     [&](const Eigen::Vector2d& p) { return box.contains(cv::Point2d(p.x(), p.y())); });
}

bool far_from_all(const Eigen::Vector2i& pixel, const std::vector<Eigen::Vector2d>& taken, double apart) {
  return std::all_of(taken.begin(), taken.end(),
                     [&](const Eigen::Vector2d& p) { return (p - pixel.cast<double>()).norm() >= apart; });
}

/// The corner that a known landmark makes in the image, below the pixel: the one that the grey values around
/// the expected place point to, if it lies within 3 sigma.
std::optional<Eigen::Vector2d> seen_corner(const cv::Mat& image, const Candidate& expected) {
  const cv::Point2f start(cv::Point2d(expected.pixel.x(), expected.pixel.y()));
  std::vector<cv::Point2f> at{start};
  const cv::TermCriteria enough(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 20, 0.01);
  cv::cornerSubPix(image, at, {kPatchHalf, kPatchHalf}, {-1, -1}, enough);
  const Eigen::Vector2d corner(at[0].x, at[0].y), moved = corner - expected.pixel;
  if (at[0] == start || !(moved.dot(expected.S.llt().solve(moved)) < kSigmas * kSigmas)) return std::nullopt;
  return corner;
}

double inverse_depth_sigma(const State& state, const Landmark& landmark) {
  return std::sqrt(std::max(0.0, state.storage_P(landmark.at + 5, landmark.at + 5)));
}

/// An inverse depth surely negative: nothing that a camera in front of it could have seen.
bool behind(const State& state, const Landmark& landmark) {
  return std::holds_alternative<InverseDepth>(landmark.kind) &&
         state.storage_x(landmark.at + 5) + 3 * inverse_depth_sigma(state, landmark) < 0;
}

}  // namespace

void Map::count(std::size_t index, bool success) {
  ++landmarks_[index].attempts;
  if (success) ++landmarks_[index].successes;
}

void Map::seen_anew(std::size_t index, const Camera& camera, const Options& options, Kalman& kalman) {
  Landmark& landmark = landmarks_[index];
  const State& state = kalman.state();
  const double distance =
      (position(landmark.kind, state.storage_x.segment(landmark.at, landmark.size())) - state.position())
          .norm();
  const double change = (state.position() - landmark.p_WC_counted).norm() / distance;
  if (change < kChangedView) return;
  landmark.p_WC_counted = state.position();
  const double angle = options.vision.sigma_view_px / camera.intrinsics().fu_px * std::sqrt(change);
  if (std::holds_alternative<Point>(landmark.kind))
    kalman.blur(landmark.at, angle * angle * distance * distance * Eigen::Matrix3d::Identity());
  else  // azimuth and elevation of the ray
    kalman.blur(landmark.at + 3, angle * angle * Eigen::Vector3d(1, 1, 0).asDiagonal().toDenseMatrix());
}

void Map::learn_surface(std::size_t index, const cv::Mat& image, const Eigen::Vector2d& pixel,
                        const Camera& camera, const State& state) {
  landmarks_[index].tilt = better_tilt(image, landmarks_[index], pixel, camera, state);
}

int Map::begin_known(const cv::Mat& image, Stamp t, const Camera& camera, const Options& options,
                     Kalman& kalman) {
  const std::size_t before = landmarks_.size();
  for (const Eigen::Vector3d& p_W : options.known_landmarks.at_m) {
    Landmark landmark;
    landmark.kind = Point{};
    landmark.at = kalman.append_known(p_W, options.known_landmarks.sigma_m);
    landmark.X_WC_first = kalman.state().X_WC();
    landmark.p_WC_counted = landmark.X_WC_first.translation();
    landmark.begun = t;
    const auto expected = predict(kalman, landmark, landmark.kind, camera, options.vision.sigma_px);
    const auto pixel = expected ? seen_corner(image, *expected) : std::nullopt;
    if (!pixel || !camera.inside(*pixel, kSourceHalf + 1)) {
      kalman.erase(landmark.at, Point::kSize);
      continue;
    }
    landmark.patch = cut_patch_between(image, *pixel);
    landmark.pixel_first = *pixel;
    landmark.id = next_id_++;
    landmarks_.push_back(landmark);
  }
  return static_cast<int>(landmarks_.size() - before);
}

int Map::begin(const cv::Mat& image, Stamp t, std::vector<Eigen::Vector2d>& taken, int wanted,
               const Camera& camera, const Options& options, Kalman& kalman) {
  const std::size_t before = landmarks_.size();
  const auto begun = [&] { return static_cast<int>(landmarks_.size() - before); };
  for (int tries = 0; begun() < wanted && tries < kTries * wanted; ++tries) {
    const cv::Rect box = random_box(image, options.vision.visible_landmarks, random_);
    if (holds_any(box, taken)) continue;
    const auto corner = strongest_corner(image, box, options.vision.corner_threshold);
    if (!corner || !far_from_all(corner->pixel, taken, std::min<double>(kApart, box.height))) continue;
    add(image, t, corner->pixel, camera, options, kalman);
    taken.push_back(corner->pixel.cast<double>());
  }
  return begun();
}

void Map::add(const cv::Mat& image, Stamp t, const Eigen::Vector2i& pixel, const Camera& camera,
              const Options& options, Kalman& kalman) {
  const auto ray = camera.unproject(pixel.cast<double>());
  if (!ray) return;
  Landmark landmark;
  landmark.id = next_id_++;
  landmark.patch = cut_patch(image, pixel);
  landmark.X_WC_first = kalman.state().X_WC();
  landmark.p_WC_counted = landmark.X_WC_first.translation();
  landmark.begun = t;
  landmark.pixel_first = pixel.cast<double>();
  const double sigma = camera.sigma(pixel.cast<double>(), options.vision.sigma_first_px);
  const RobotVector x = kalman.state().storage_x.head<kRobot>();
  if (options.depth.first_sight == FirstSight::particles) {
    landmark.kind = SemiInfiniteLine{flat_prior(options.depth.particles)};
    landmark.at = kalman.append(begin_line(x, *ray, sigma));
  } else {
    landmark.at = kalman.append(begin_inverse_depth(x, *ray, sigma, options.depth));
  }
  landmarks_.push_back(landmark);
}

void Map::convert(double linearity, Kalman& kalman) {
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    Landmark& landmark = landmarks_[i];
    const State& state = kalman.state();
    if (!std::holds_alternative<InverseDepth>(landmark.kind)) continue;
    const Vector6d y = state.storage_x.segment<6>(landmark.at);
    if (!(linearity_index(y, inverse_depth_sigma(state, landmark), state.position()) < linearity)) continue;
    make_point(landmark, inverse_depth_position(y), inverse_depth_position_jacobian(y), kalman);
  }
}

void Map::make_point(Landmark& landmark, const Eigen::Vector3d& p_W,
                     const Eigen::Ref<const Eigen::MatrixXd>& J, Kalman& kalman) {
  const int before = landmark.size();
  kalman.replace(landmark.at, before, p_W, J);
  landmark.kind = Point{};
  for (Landmark& later : landmarks_)
    if (later.at > landmark.at) later.at -= before - Point::kSize;
}

int Map::lines() const {
  return static_cast<int>(std::count_if(landmarks_.begin(), landmarks_.end(), [](const Landmark& landmark) {
    return std::holds_alternative<SemiInfiniteLine>(landmark.kind);
  }));
}

void Map::follow_lines(const cv::Mat& image, const Camera& camera, const Options& options, Kalman& kalman,
                       std::vector<int>& deleted, std::vector<DepthHypotheses>& lines) {
  for (std::size_t i = landmarks_.size(); i-- > 0;) {
    Landmark& landmark = landmarks_[i];
    if (!std::holds_alternative<SemiInfiniteLine>(landmark.kind)) continue;
    search_along(image, kalman, camera, options, landmark);
    const auto line = std::get<SemiInfiniteLine>(landmark.kind);
    lines.push_back({landmark.id, line.particles});
    if (given_up(line, options.depth.particles)) {
      deleted.push_back(landmark.id);
      erase(i, kalman);
    } else if (converged(line, options.depth.particles)) {
      const Parameters y = kalman.state().storage_x.segment<6>(landmark.at);
      const double sigma = belief(line.particles).sigma_m;
      make_point(landmark, position(line, y), position_jacobian(line, y), kalman);
      kalman.blur(landmark.at, sigma * sigma * y.segment<3>(3) * y.segment<3>(3).transpose());
    }
  }
}

void Map::prune(Kalman& kalman, std::vector<int>& deleted) {
  for (std::size_t i = landmarks_.size(); i-- > 0;) {
    const Landmark& landmark = landmarks_[i];
    const bool unreliable = landmark.attempts >= 10 && 2 * landmark.successes < landmark.attempts;
    if (!unreliable && !behind(kalman.state(), landmark)) continue;
    deleted.push_back(landmark.id);
    erase(i, kalman);
  }
}

void Map::erase(std::size_t index, Kalman& kalman) {
  const int at = landmarks_[index].at, size = landmarks_[index].size();
  kalman.erase(at, size);
  landmarks_.erase(landmarks_.begin() + static_cast<std::ptrdiff_t>(index));
  for (Landmark& later : landmarks_)
    if (later.at > at) later.at -= size;
}

}  // namespace slam
