#include "slam/landmark_initialisation.h"

#include "slam/active_search.h"
#include "slam/corner_detector.h"

namespace slam {
namespace {

Landmark landmark_seen_from(const Eigen::Isometry3d& X_WC, Stamp t) {
  Landmark landmark;
  landmark.X_WC_first = X_WC;
  landmark.p_WC_inflated = X_WC.translation();
  landmark.initialised = landmark.last_visible = t;
  return landmark;
}

}  // namespace

std::optional<Landmark> initialise_landmark(const cv::Mat& image, Stamp t, const Eigen::Vector2i& pixel,
                                            const Camera& camera, const Options& options, Kalman& kalman) {
  const auto ray = camera.unproject(pixel.cast<double>());
  if (!ray) return std::nullopt;
  Landmark landmark = landmark_seen_from(kalman.state().X_WC(), t);
  landmark.patch = cut_patch(image, pixel);
  landmark.pixel_first = pixel.cast<double>();
  const double sigma_px = camera.sigma(landmark.pixel_first, options.vision.sigma_first_px);
  const RobotVector x = kalman.state().robot();
  if (options.depth.first_sight == FirstSight::particles) {
    landmark.kind = SemiInfiniteLine{uniform_prior(options.depth.particles)};
    landmark.at = kalman.append(initialise_line(x, *ray, sigma_px));
  } else {
    landmark.at = kalman.append(initialise_inverse_depth(
        x, *ray, sigma_px, camera.displacement(ray->h, landmark.pixel_first), options.depth));
  }
  return landmark;
}

std::optional<Landmark> initialise_known_landmark(const cv::Mat& image, Stamp t, const Eigen::Vector3d& p_W,
                                                  const Camera& camera, const Options& options,
                                                  Kalman& kalman) {
  Landmark landmark = landmark_seen_from(kalman.state().X_WC(), t);
  landmark.kind = Point{};
  landmark.at = kalman.append_point(p_W, options.known_landmarks.sigma_m);
  const auto predicted = predict_landmark(kalman, landmark, landmark.kind, camera, options.vision.sigma_px);
  const auto pixel = predicted ? corner_near(image, predicted->pixel, predicted->S) : std::nullopt;
  if (!pixel || !camera.inside(*pixel, kSourceHalf + 1)) {
    kalman.erase(landmark.at, Point::kSize);
    return std::nullopt;
  }
  landmark.patch = cut_patch_between(image, *pixel);
  landmark.pixel_first = *pixel;
  return landmark;
}

}  // namespace slam
