#include "slam/vision/relocalization.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "slam/motion_model.h"

namespace slam {
namespace {

constexpr double kGridVariance_px2 = 1.0 / 12;  // of matches on the raw pixel grid
constexpr std::size_t kMostLandmarks = 40;
constexpr int kLeastSuccesses = 10;
constexpr double kLargestRelativeVariance = 0.04;  // of the position, relative to the squared distance
constexpr double kLeastCorrelation = 0.85;
constexpr double kInlierResidual_px = 4;
constexpr int kPoseIterations = 10;
constexpr double kSearchPeriod_s = 0.19;  // every sixth frame at 30 Hz
constexpr double kLargestDifference = 5;  // standard deviations
constexpr double kConfirmation_s = 1, kLongestConfirmation_s = 2;
constexpr double kLargestMotionError = 0.5;  // of the motion
constexpr double kLeastDifference_m = 0.05, kLeastDifference_rad = 0.05;
constexpr double kWalkingSigma_m_s = 0.3, kWalkingSigma_rad_s = 0.5;

/// A landmark found in the image, perhaps wrongly.
struct Detection {
  BearingObservation bearing;
  Eigen::Vector2d pixel;
  Eigen::Matrix3d P;  ///< covariance of the landmark's position
};

/// The detections that agree with a pose, and the sum of their squared residuals in px².
struct PoseInliers {
  std::vector<std::size_t> indices;
  double squared_residuals = 0;
};

/// The landmarks of known depth that have been found reliably, those found most often first.
std::vector<const Landmark*> reliable_landmarks(const std::vector<Landmark>& landmarks, const State& state) {
  std::vector<const Landmark*> all;
  for (const Landmark& landmark : landmarks) {
    if (landmark.successes < kLeastSuccesses || std::holds_alternative<SemiInfiniteLine>(landmark.kind))
      continue;
    const double distance =
        (position(landmark.kind, landmark.parameters(state)) - landmark.X_WC_first.translation()).norm();
    if (position_covariance(state, landmark).trace() < kLargestRelativeVariance * distance * distance)
      all.push_back(&landmark);
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto* a, const auto* b) { return a->successes > b->successes; });
  if (all.size() > kMostLandmarks) all.resize(kMostLandmarks);
  return all;
}

/// The best match of the unwarped patch anywhere in the image.
std::optional<Eigen::Vector2d> search_everywhere(const cv::Mat& gray, const Landmark& landmark) {
  const auto patch = warp(landmark.patch, Eigen::Matrix2d::Identity());
  if (!patch) return std::nullopt;
  Eigen::Matrix<float, Template::kPixels, 1> pixels = patch->gray;
  cv::Mat correlation;
  cv::matchTemplate(gray, cv::Mat(kPatchSide, kPatchSide, CV_32F, pixels.data()), correlation,
                    cv::TM_CCOEFF_NORMED);
  double best = 0;
  cv::Point at;
  cv::minMaxLoc(correlation, nullptr, &best, nullptr, &at);
  if (best < kLeastCorrelation) return std::nullopt;
  return Eigen::Vector2d(at.x + kPatchHalf, at.y + kPatchHalf);
}

std::vector<Detection> detect(const cv::Mat& image, const std::vector<Landmark>& landmarks,
                              const State& state, const Camera& camera) {
  cv::Mat gray;
  image.convertTo(gray, CV_32F);
  std::vector<Detection> all;
  for (const Landmark* landmark : reliable_landmarks(landmarks, state)) {
    const auto pixel = search_everywhere(gray, *landmark);
    const auto ray = pixel ? camera.unproject(*pixel) : std::nullopt;
    if (!ray) continue;
    const Eigen::Vector3d p_W = position(landmark->kind, landmark->parameters(state));
    all.push_back({{p_W, ray->h.normalized()}, *pixel, position_covariance(state, *landmark)});
  }
  return all;
}

PoseInliers inliers_of(const Eigen::Isometry3d& X_WC, const std::vector<Detection>& detections,
                       const Camera& camera) {
  PoseInliers inliers;
  for (std::size_t i = 0; i < detections.size(); ++i) {
    const auto projection = camera.project(X_WC.inverse() * detections[i].bearing.p_W);
    if (!projection || !((projection->pixel - detections[i].pixel).norm() < kInlierResidual_px)) continue;
    inliers.indices.push_back(i);
    inliers.squared_residuals += (projection->pixel - detections[i].pixel).squaredNorm();
  }
  return inliers;
}

/// The camera position nearest to both rays, given its orientation.
Eigen::Vector3d intersection(const BearingObservation& first, const BearingObservation& second,
                             const Eigen::Matrix3d& R_WC) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const BearingObservation* bearing : {&first, &second}) {
    const Eigen::Vector3d d = R_WC * bearing->direction_C;
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - d * d.transpose();
    A += across;
    b += across * bearing->p_W;
  }
  return A.ldlt().solve(b);
}

/// Refines the pose by Gauss-Newton; the uncertainty of each landmark counts as noise of its pixel.
Estimate refine(Eigen::Isometry3d X_WC, const std::vector<Detection>& detections,
                const std::vector<std::size_t>& inliers, const Camera& camera, double sigma_px) {
  Matrix6d information = Matrix6d::Identity();
  for (int k = 0; k < kPoseIterations; ++k) {
    information.setZero();
    Vector6d gradient = Vector6d::Zero();
    for (const std::size_t i : inliers) {
      const Eigen::Vector3d h = X_WC.inverse() * detections[i].bearing.p_W;
      const auto projection = camera.project(h);
      if (!projection) continue;
      Eigen::Matrix<double, 2, 6> J;
      J << projection->J * cross_matrix(h), -projection->J * X_WC.linear().transpose();
      const Matrix23d J_p = projection->J * X_WC.linear().transpose();
      const Eigen::Matrix2d R = (sigma_px * sigma_px + kGridVariance_px2) * Eigen::Matrix2d::Identity() +
                                J_p * detections[i].P * J_p.transpose();
      const Eigen::Matrix<double, 6, 2> JtW = R.llt().solve(J).transpose();
      information += JtW * J;
      gradient += JtW * (detections[i].pixel - projection->pixel);
    }
    const Vector6d step = information.ldlt().solve(gradient);
    X_WC.linear() = X_WC.linear() * rotation_matrix(quaternion_exp(step.head<3>()));
    X_WC.translation() += step.tail<3>();
  }
  return {Stamp(0), X_WC, information.ldlt().solve(Matrix6d::Identity())};
}

/// True if two poses are the same within their uncertainties.
bool agree(const Estimate& found, const Estimate& predicted) {
  Vector6d difference;
  const Eigen::AngleAxisd turn(predicted.X_WC.linear().transpose() * found.X_WC.linear());
  difference << turn.angle() * turn.axis(), found.X_WC.translation() - predicted.X_WC.translation();
  const Eigen::LDLT<Matrix6d> sum(found.covariance + predicted.covariance);
  return sum.info() == Eigen::Success && sum.isPositive() &&
         difference.dot(sum.solve(difference)) < kLargestDifference * kLargestDifference;
}

}  // namespace

bool RelocalizationConfirmer::is_due(Stamp t) {
  if (searched_ && seconds(t - *searched_) < kSearchPeriod_s) return false;
  searched_ = t;
  return true;
}

bool RelocalizationConfirmer::confirms(const Estimate& found, const Estimate& predicted, bool plan_is_known) {
  if (agree(found, predicted)) return true;
  if (!first_ || seconds(found.t - first_->found.t) > kLongestConfirmation_s) first_ = {found, predicted};
  if (seconds(found.t - first_->found.t) < kConfirmation_s) return false;
  const Eigen::Isometry3d a = first_->found.X_WC.inverse() * found.X_WC,
                          b = first_->predicted.X_WC.inverse() * predicted.X_WC;
  first_ = {found, predicted};
  const auto alike = [](double difference, double least, double of_a, double of_b) {
    return difference < std::max(least, kLargestMotionError * std::max(of_a, of_b));
  };
  const auto angle = [](const Eigen::Matrix3d& R) { return Eigen::AngleAxisd(R).angle(); };
  return alike(angle(a.linear().transpose() * b.linear()), kLeastDifference_rad, angle(a.linear()),
               angle(b.linear())) &&
         (!plan_is_known || alike((a.translation() - b.translation()).norm(), kLeastDifference_m,
                                  a.translation().norm(), b.translation().norm()));
}

std::vector<Eigen::Isometry3d> poses_from_two(const BearingObservation& first,
                                              const BearingObservation& second, const Eigen::Matrix3d& R_WC) {
  const Eigen::Vector3d n = R_WC * first.direction_C.cross(second.direction_C), p = second.p_W - first.p_W;
  const double a = p.x() * n.x() + p.y() * n.y(), b = p.y() * n.x() - p.x() * n.y(), c = p.z() * n.z();
  const double r = std::hypot(a, b);  // a cos ψ + b sin ψ + c = 0
  if (!(r > std::abs(c))) return {};
  std::vector<Eigen::Isometry3d> poses;
  for (const double sign : {-1.0, 1.0}) {
    const double yaw = std::atan2(b, a) + sign * std::acos(-c / r);
    Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
    X_WC.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * R_WC;
    X_WC.translation() = intersection(first, second, X_WC.linear());
    const auto in_front = [&](const BearingObservation& bearing) {
      return (X_WC.inverse() * bearing.p_W).dot(bearing.direction_C) > 0;
    };
    if (X_WC.translation().allFinite() && in_front(first) && in_front(second)) poses.push_back(X_WC);
  }
  return poses;
}

std::optional<Estimate> relocalize(const cv::Mat& image, const std::vector<Landmark>& landmarks,
                                   const State& state, const Camera& camera, double sigma_px) {
  const std::vector<Detection> detections = detect(image, landmarks, state, camera);
  PoseInliers best;
  Eigen::Isometry3d X_best = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < detections.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      for (const auto& X_WC :
           poses_from_two(detections[i].bearing, detections[j].bearing, state.X_WC().linear())) {
        PoseInliers inliers = inliers_of(X_WC, detections, camera);
        if (std::pair(inliers.indices.size(), -inliers.squared_residuals) <=
            std::pair(best.indices.size(), -best.squared_residuals))
          continue;
        best = std::move(inliers);
        X_best = X_WC;
      }
  if (best.indices.size() < kLeastRecognized) return std::nullopt;
  return refine(X_best, detections, best.indices, camera, sigma_px);
}

RobotState relocalized_state(const Estimate& found, const State& before) {
  constexpr int kOthers = kRobot - kCamera;
  RobotState robot{initial_mean(found.X_WC), RobotMatrix::Zero()};
  robot.x.tail<kOthers>() = before.robot().tail<kOthers>();
  Eigen::Matrix<double, 7, 6> J = Eigen::Matrix<double, 7, 6>::Zero();
  J.block<3, 3>(kPosition, 3).setIdentity();
  J.block<4, 3>(kOrientation, 0) = small_rotation_jacobian(robot.x.segment<4>(kOrientation));
  robot.P.topLeftCorner<7, 7>() = J * found.covariance * J.transpose();
  robot.P.diagonal().segment<3>(kVelocity).setConstant(kWalkingSigma_m_s * kWalkingSigma_m_s);
  robot.P.diagonal().segment<3>(kRate).setConstant(kWalkingSigma_rad_s * kWalkingSigma_rad_s);
  robot.P.bottomRightCorner<kOthers, kOthers>() = before.marginal<kOthers>(kCamera);
  return robot;
}

}  // namespace slam
