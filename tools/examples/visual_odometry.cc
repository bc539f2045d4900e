// Visual odometry with OpenCV: corners, optical flow, and the pose with the smallest residuals. The depths of
// corners come from the second gray camera of the rig.
//
// clang-format off
//     c++ -std=c++17 -O2 -DGAITSLAM_ESTIMATOR_MAIN -I sim/estimators -I /usr/include/opencv4 -o visual_odometry tools/examples/visual_odometry.cc -lopencv_video -lopencv_calib3d -lopencv_imgproc -lopencv_core
//     tools/gaitslam run scenarios/office_d435i_mid360.yaml 'estimator={program: ./visual_odometry}'
// clang-format on
//
// On Debian: apt-get install libopencv-video-dev libopencv-calib3d-dev. The program has no loop closure and
// gives no covariance.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/affine.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "gaitslam_estimator.h"

namespace {

using Pose = cv::Affine3d;

constexpr int kMostTracks = 400, kFewestPoints = 12;
constexpr double kApart_px = 6;  // between corners
constexpr double kForwardBackward_px = 0.5;
constexpr double kResidual_px = 1;  // limit for a static point
constexpr int64_t kSameTime_ns = 1000000;

Pose pose_of(const gaitslam_pose& X) {
  return Pose(cv::Matx33d(X.rotation), cv::Vec3d(X.translation_m[0], X.translation_m[1], X.translation_m[2]));
}

/// A corner while it is in view. Rays are points on the camera's plane z = 1.
struct Track {
  uint32_t id;
  cv::Point2f pixel;
  cv::Point2d ray;
  std::optional<cv::Point3d> p_W = {};
  double weight = 0;  // weight of p_W
};

/// Returns rays; the equidistant lens is within a fifth of a pixel of the actual lens of any model.
std::vector<cv::Point2d> rays(const gaitslam_lens& equidistant, const std::vector<cv::Point2f>& pixels) {
  std::vector<cv::Point2d> all(pixels.begin(), pixels.end());
  const double *f = equidistant.focal_px, *center = equidistant.center_px;
  const cv::Matx33d K(f[0], 0, center[0], 0, f[1], center[1], 0, 0, 1);
  if (!all.empty()) cv::fisheye::undistortPoints(all, all, K, cv::Vec4d(equidistant.parameters));
  return all;
}

/// Returns the reprojection error in the plane z = 1; infinite behind the camera.
double residual(const Pose& X_WC, const cv::Point3d& p_W, const cv::Point2d& ray) {
  const cv::Point3d p_C = X_WC.inv() * p_W;
  return p_C.z > 0.1 ? std::hypot(p_C.x / p_C.z - ray.x, p_C.y / p_C.z - ray.y) : HUGE_VAL;
}

/// Returns the point that fits both views, if it is in front of both.
std::optional<cv::Point3d> triangulated(const Pose& X_WA, const cv::Point2d& ray_A, const Pose& X_WB,
                                        const cv::Point2d& ray_B, double largest_residual) {
  const auto projection = [](const Pose& X) { return X.inv().matrix.get_minor<3, 4>(0, 0); };
  cv::Mat homogeneous;
  cv::triangulatePoints(projection(X_WA), projection(X_WB), std::vector{ray_A}, std::vector{ray_B},
                        homogeneous);
  const cv::Vec4d h(homogeneous.ptr<double>());
  if (std::abs(h[3]) < 1e-9) return std::nullopt;
  const cv::Point3d p_W(h[0] / h[3], h[1] / h[3], h[2] / h[3]);
  const bool fits =
      residual(X_WA, p_W, ray_A) < largest_residual && residual(X_WB, p_W, ray_B) < largest_residual;
  return fits ? std::optional(p_W) : std::nullopt;
}

/// A second camera, which shows the depths of the corners in a single frame.
class SecondEye {
 public:
  SecondEye(const gaitslam_sensors& sensors, uint32_t number)
      : number_(number),
        ahead_ns_(std::llround(1e9 * sensors.cameras[number].time_offset_s)),
        lens_(sensors.cameras[number].equidistant),
        X_CK_(pose_of(sensors.cameras[number].X_CK)) {}

  /// Returns the tracks' points in C. image: of camera 0; rig: has the sensor's image with the same stamp.
  std::vector<std::optional<cv::Point3d>> points(const cv::Mat& image, const std::vector<Track>& tracks,
                                                 const gaitslam_rig& rig, int64_t t_ns) const {
    std::vector<std::optional<cv::Point3d>> all(tracks.size());
    for (uint32_t i = 0; i < rig.counts.images; ++i) {
      const gaitslam_image& other = rig.images[i];
      if (other.camera != number_ || std::abs(other.t_ns - ahead_ns_ - t_ns) > kSameTime_ns) continue;
      const cv::Mat pixels(static_cast<int>(other.height_px), static_cast<int>(other.width_px), CV_8UC1,
                           const_cast<uint8_t*>(rig.data + other.at_byte), other.row_bytes);
      triangulate(image, pixels, tracks, all);
    }
    return all;
  }

 private:
  void triangulate(const cv::Mat& left, const cv::Mat& right, const std::vector<Track>& tracks,
                   std::vector<std::optional<cv::Point3d>>& points) const {
    if (tracks.empty()) return;
    std::vector<cv::Point2f> from, to;
    for (const Track& track : tracks) from.push_back(track.pixel);
    std::vector<uint8_t> found;
    cv::calcOpticalFlowPyrLK(left, right, from, to, found, cv::noArray());
    const std::vector<cv::Point2d> right_rays = rays(lens_, to);
    for (std::size_t i = 0; i < tracks.size(); ++i)
      if (found[i])
        points[i] = triangulated({}, tracks[i].ray, X_CK_, right_rays[i], kResidual_px / lens_.focal_px[0]);
  }

  uint32_t number_;
  int64_t ahead_ns_;  // of its stamps
  gaitslam_lens lens_;
  Pose X_CK_;
};

/// Throws std::invalid_argument for options and without a second gray camera.
SecondEye second_eye(const std::string& options, const gaitslam_sensors& sensors) {
  if (!options.empty()) throw std::invalid_argument("unknown option, expected none");
  for (uint32_t i = 1; i < sensors.counts.cameras; ++i)
    if (sensors.cameras[i].kind == GAITSLAM_CAMERA_GRAY) return {sensors, i};
  throw std::invalid_argument("the rig has no second gray camera");
}

class VisualOdometry {
 public:
  std::string failure;  ///< cause for the last observation

  VisualOdometry(const gaitslam_start& start, const gaitslam_sensors& sensors, const std::string& options)
      : lens_(sensors.cameras[0].equidistant),
        residual_(kResidual_px / lens_.focal_px[0]),
        second_(second_eye(options, sensors)),
        X_WC_(pose_of(start.X_WC)) {
    cv::setNumThreads(1);
  }

  /// pixels: of camera 0, NULL if the image is lost.
  void process(const gaitslam_observation& observation, const uint8_t* pixels, const gaitslam_rig& rig) {
    if (observation.t_ns <= t_ns_) return;  // late or duplicate
    t_ns_ = observation.t_ns;
    const Pose last_X_WC = X_WC_;
    X_WC_ = X_WC_ * step_;  // constant velocity
    sees_ = pixels != nullptr;
    if (!sees_) return restart();
    const cv::Mat image =
        cv::Mat(static_cast<int>(observation.height_px), static_cast<int>(observation.width_px), CV_8UC1,
                const_cast<uint8_t*>(pixels))
            .clone();
    follow(image);
    if (locate())
      tracking_ = true, lost_ = false;
    else if (tracking_)
      restart();
    step_ = tracking_ ? last_X_WC.inv() * X_WC_ : Pose();
    add_corners(image);
    measure_depths(image, rig, observation.t_ns);
    before_ = image;
  }

  void write(gaitslam_answer& answer, const gaitslam_landmark** landmarks, const char** cause) {
    answer.t_ns = std::max<int64_t>(t_ns_, 0);
    std::copy_n(X_WC_.rotation().val, 9, answer.X_WC.rotation);
    std::copy_n(X_WC_.translation().val, 3, answer.X_WC.translation_m);
    answer.status = lost_ ? GAITSLAM_LOST : GAITSLAM_OK;
    if (lost_) *cause = sees_ ? "too few points are in view" : "the image is lost";
    map_.clear();
    for (const Track& track : tracks_)
      if (track.p_W) map_.push_back({track.id, 0, {track.p_W->x, track.p_W->y, track.p_W->z}, {}});
    answer.landmark_count = static_cast<uint32_t>(map_.size());
    *landmarks = map_.data();
  }

 private:
  /// Starts over: the camera is assumed to move at constant velocity until there are points again.
  void restart() {
    lost_ = lost_ || tracking_;
    tracking_ = false;
    tracks_.clear();
  }

  /// Tracks the corners into the new image, forward and backward.
  void follow(const cv::Mat& image) {
    if (tracks_.empty()) return;
    std::vector<cv::Point2f> from, to, back;
    for (const Track& track : tracks_) from.push_back(track.pixel);
    std::vector<uint8_t> found, found_back;
    cv::calcOpticalFlowPyrLK(before_, image, from, to, found, cv::noArray());
    cv::calcOpticalFlowPyrLK(image, before_, to, back, found_back, cv::noArray());
    const std::vector<cv::Point2d> now = rays(lens_, to);
    std::vector<Track> kept;
    const cv::Rect2f inside(2, 2, static_cast<float>(image.cols - 4), static_cast<float>(image.rows - 4));
    for (std::size_t i = 0; i < to.size(); ++i) {
      const bool same = found[i] && found_back[i] && cv::norm(back[i] - from[i]) < kForwardBackward_px;
      if (!same || !inside.contains(to[i])) continue;
      kept.push_back(tracks_[i]);
      kept.back().pixel = to[i], kept.back().ray = now[i];
    }
    tracks_ = std::move(kept);
  }

  /// Estimates the pose from points with depth, and drops outliers. Returns false if there are too few.
  bool locate() {
    Pose X_WC = X_WC_;
    for (const double outlier : {8, 4, 1, 1}) {
      std::vector<cv::Point3d> points;
      std::vector<cv::Point2d> seen;
      for (const Track& track : tracks_)
        if (track.p_W && residual(X_WC, *track.p_W, track.ray) < outlier * residual_)
          points.push_back(*track.p_W), seen.push_back(track.ray);
      if (points.size() < kFewestPoints) return false;
      const Pose X_CW = X_WC.inv();
      cv::Vec3d turn = X_CW.rvec(), shift = X_CW.translation();
      cv::solvePnPRefineLM(points, seen, cv::Matx33d::eye(), cv::noArray(), turn, shift);
      X_WC = Pose(turn, shift).inv();
    }
    X_WC_ = X_WC;
    keep([&](const Track& t) { return !t.p_W || residual(X_WC, *t.p_W, t.ray) < 2 * residual_; });
    return true;
  }

  template <class Condition>
  void keep(const Condition& condition) {
    const auto end = std::stable_partition(tracks_.begin(), tracks_.end(), condition);
    tracks_.erase(end, tracks_.end());
  }

  /// Updates each map point, the mean of all its measurements. Weights are inverse squares of the error,
  /// which grows with z².
  void measure_depths(const cv::Mat& image, const gaitslam_rig& rig, int64_t t_ns) {
    const auto points = second_.points(image, tracks_, rig, t_ns);
    for (std::size_t i = 0; i < tracks_.size(); ++i) {
      if (!points[i]) continue;
      Track& track = tracks_[i];
      const double weight = std::pow(std::max(points[i]->z, 0.1), -4);
      const cv::Point3d p_W = X_WC_ * *points[i];
      track.p_W = (track.weight * track.p_W.value_or(p_W) + weight * p_W) / (track.weight + weight);
      track.weight += weight;
    }
    keep([](const Track& track) { return track.p_W.has_value(); });
  }

  void add_corners(const cv::Mat& image) {
    if (tracks_.size() > 3 * kMostTracks / 4) return;
    cv::Mat free(image.size(), CV_8UC1, cv::Scalar(255));
    for (const Track& track : tracks_)
      cv::circle(free, track.pixel, static_cast<int>(kApart_px), cv::Scalar(0), cv::FILLED);
    std::vector<cv::Point2f> corners;
    cv::goodFeaturesToTrack(image, corners, kMostTracks - static_cast<int>(tracks_.size()), 0.01, kApart_px,
                            free);
    const std::vector<cv::Point2d> now = rays(lens_, corners);
    for (std::size_t i = 0; i < corners.size(); ++i) tracks_.push_back({next_id_++, corners[i], now[i]});
  }

  gaitslam_lens lens_;
  double residual_;  // of a static point, in the plane z = 1
  SecondEye second_;
  Pose X_WC_, step_;  // step_: from the last frame
  int64_t t_ns_ = -1;
  bool sees_ = false;      // an image
  bool tracking_ = false;  // the pose comes from points
  bool lost_ = false;
  cv::Mat before_;
  std::vector<Track> tracks_;
  uint32_t next_id_ = 0;
  std::vector<gaitslam_landmark> map_;
};

}  // namespace

// Exceptions from the class are reported as failures.

void* gaitslam_estimator_create(const gaitslam_start* start, const gaitslam_sensors* sensors,
                                const char* options, char* error, size_t error_bytes) try {
  return new VisualOdometry(*start, *sensors, options);
} catch (const std::exception& e) {
  std::snprintf(error, error_bytes, "%s", e.what());
  return nullptr;
}

int gaitslam_estimator_observe(void* estimator, const gaitslam_observation* observation,
                               const gaitslam_reading*, const gaitslam_reading*, const uint8_t* image,
                               const gaitslam_rig* rig, gaitslam_answer* answer,
                               const gaitslam_landmark** landmarks, const char** cause) {
  VisualOdometry& odometry = *static_cast<VisualOdometry*>(estimator);
  try {
    odometry.process(*observation, image, *rig);
    odometry.write(*answer, landmarks, cause);
    return 0;
  } catch (const std::exception& e) {
    odometry.failure = e.what();
    *cause = odometry.failure.c_str();
    return 1;
  }
}

void gaitslam_estimator_destroy(void* estimator) { delete static_cast<VisualOdometry*>(estimator); }
