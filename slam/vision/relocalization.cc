#include "slam/vision/relocalization.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "slam/motion_model.h"

namespace slam {
namespace {

constexpr double kGridVariance_px2 = 1.0 / 12;  // variance of matches on the raw pixel grid
constexpr int kLeastSuccesses = 10;
// Variance of the position, relative to the squared distance.
constexpr double kLargestRelativeVariance = 0.04;
constexpr double kLeastCorrelation = 0.85;
constexpr double kInlierResidual_px = 4;
constexpr int kPoseIterations = 10;

constexpr std::size_t kMostTemplates = 40;  // in one heading
constexpr std::size_t kMostPlaces = 3000;   // in an image
constexpr int kPlaceStep_px = 2;
constexpr double kPlaceBlur_px = 1.2;  // blur, so that templates still match at a slight offset
constexpr std::size_t kMostDetections = 48;
constexpr double kHeightSigma_m = 0.03, kHeightGate = 3;
constexpr double kLeastAhead = 0.5;          // cosine of the angle to the heading that is searched
constexpr std::size_t kLeastHypothesis = 4;  // detections that agree
constexpr std::size_t kMostHypotheses = 3;
constexpr double kSamePlace_m = 0.2, kSameHeading_rad = 0.1;
constexpr double kVerifySigma_px = 2;
constexpr double kLikeFirstView = 0.9;  // cosine of the angle within which landmarks are mostly found
constexpr double kLeastShare = 0.5;     // fraction of the landmarks predicted in view
constexpr double kLead = 2;             // factor on the fraction of the second-best pose

constexpr double kLargestDifference = 5;  // standard deviations
constexpr double kConfirmation_s = 1, kLongestConfirmation_s = 2;
constexpr double kLargestMotionError = 0.5;  // fraction of the motion
constexpr double kLeastDifference_m = 0.05, kLeastDifference_rad = 0.05;
constexpr double kWalkingSigma_m_s = 0.3, kWalkingSigma_rad_s = 0.5;

/// A landmark found in the image, perhaps wrongly.
struct Detection {
  const Landmark* landmark;
  BearingObservation bearing;
  Eigen::Vector2d pixel;
  Eigen::Matrix3d P;  ///< covariance of the landmark's position
  double correlation;
};

/// A pose, and the detections that agree with it.
struct Hypothesis {
  Eigen::Isometry3d X_WC;
  std::vector<std::size_t> inliers = {};
  double squared_residuals = 0;  ///< px², summed over the inliers
};

bool is_better(const Hypothesis& a, const Hypothesis& b) {
  return std::pair(a.inliers.size(), -a.squared_residuals) >
         std::pair(b.inliers.size(), -b.squared_residuals);
}

/// The landmarks of known depth that have been found reliably.
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
  return all;
}

/// A landmark in the view of a camera: its pixel, and the change of view since it was first seen.
struct InView {
  const Landmark* landmark;
  Eigen::Vector3d p_W;
  Eigen::Vector2d pixel;
  Eigen::Matrix2d view_change;
};

std::vector<InView> in_view(const std::vector<const Landmark*>& landmarks, const State& state,
                            const Eigen::Isometry3d& X_WC, const Camera& camera) {
  std::vector<InView> all;
  for (const Landmark* landmark : landmarks) {
    const Eigen::Vector3d p_W = position(landmark->kind, landmark->parameters(state));
    const auto projection = camera.project(X_WC.inverse() * p_W);
    if (!projection) continue;
    const Eigen::Vector2d& pixel = projection->pixel;
    if (!camera.inside(pixel, kPatchSide)) continue;
    const Eigen::Vector3d normal_W = surface_normal(landmark->X_WC_first, p_W, landmark->tilt);
    if (const auto change = view_change(camera, landmark->X_WC_first, X_WC, p_W, normal_W, pixel))
      all.push_back({landmark, p_W, pixel, *change});
  }
  return all;
}

/// The landmarks first seen by a camera that faced roughly the same way as X_WC, from any position.
/// Pixels and views refer to that camera.
std::vector<InView> as_first_seen(const std::vector<const Landmark*>& landmarks, const State& state,
                                  const Eigen::Isometry3d& X_WC) {
  std::vector<InView> all;
  for (const Landmark* landmark : landmarks)
    if (landmark->X_WC_first.linear().col(2).dot(X_WC.linear().col(2)) > kLeastAhead)
      all.push_back({landmark, position(landmark->kind, landmark->parameters(state)), landmark->pixel_first,
                     Eigen::Matrix2d::Identity()});
  return all;
}

using Gray = Eigen::Matrix<float, Template::kPixels, 1>;

/// The textured places of an image, on a grid; the columns of gray are their blurred and normalized
/// surroundings.
struct Places {
  std::vector<cv::Point> at;
  Eigen::Matrix<float, Template::kPixels, Eigen::Dynamic> gray;
};

Places textured_places(const cv::Mat& image) {
  cv::Mat strength, blurred;
  cv::cornerMinEigenVal(image, strength, kPatchSide);
  cv::GaussianBlur(image, blurred, {}, kPlaceBlur_px);
  std::vector<std::pair<float, int>> all;
  const int margin = kPatchHalf + 1;
  for (int v = margin; v < image.rows - margin; v += kPlaceStep_px)
    for (int u = margin; u < image.cols - margin; u += kPlaceStep_px)
      all.emplace_back(-strength.ptr<float>(v)[u], v * image.cols + u);
  if (all.size() > kMostPlaces) {
    std::nth_element(all.begin(), all.begin() + kMostPlaces, all.end());
    all.resize(kMostPlaces);
  }
  Places places;
  places.gray.resize(Template::kPixels, static_cast<Eigen::Index>(all.size()));
  for (const auto& [negative, index] : all) {
    const cv::Point at(index % image.cols, index / image.cols);
    auto column = places.gray.col(static_cast<Eigen::Index>(places.at.size()));
    for (int j = 0; j < kPatchSide; ++j)
      for (int i = 0; i < kPatchSide; ++i)
        column(j * kPatchSide + i) = blurred.ptr<uchar>(at.y + j - kPatchHalf)[at.x + i - kPatchHalf];
    column.array() -= column.mean();
    column /= std::max(column.norm(), 1.0F);
    places.at.push_back(at);
  }
  return places;
}

/// The template of a landmark under a change of view, blurred like the places.
std::optional<Gray> blurred_template(const Landmark& landmark, const Eigen::Matrix2d& view_change) {
  SourcePatch patch = landmark.patch;
  const cv::Mat gray(kSourceSide, kSourceSide, CV_32F, patch.gray.data());
  cv::GaussianBlur(gray, gray, {}, kPlaceBlur_px);
  const auto blurred = warp(patch, view_change);
  return blurred ? std::optional<Gray>(blurred->gray) : std::nullopt;
}

/// The landmark near a pixel, if its template correlates well there.
std::optional<Detection> detection(const cv::Mat& image, const InView& seen, const Template& patch,
                                   const Eigen::Vector2d& near, const State& state, const Camera& camera) {
  const auto match = refine(image, patch, near);
  const auto ray = match ? camera.unproject(match->pixel) : std::nullopt;
  if (!ray || match->correlation < kLeastCorrelation) return std::nullopt;
  return Detection{seen.landmark,
                   {seen.p_W, ray->h.normalized()},
                   match->pixel,
                   position_covariance(state, *seen.landmark),
                   match->correlation};
}

/// The places in the image where landmarks may be, at most two for each landmark.
std::vector<Detection> detect(const cv::Mat& image, std::vector<InView> seen, const State& state,
                              const Camera& camera) {
  // Not std::stable_sort: its buffer is not aligned for Eigen's matrices.
  std::ranges::sort(seen, {},
                    [](const InView& v) { return std::pair(-v.landmark->successes, v.landmark->id); });
  if (seen.size() > kMostTemplates) seen.resize(kMostTemplates, seen.front());
  if (seen.size() < kLeastRecognized) return {};
  const Places places = textured_places(image);
  std::vector<Detection> all;
  for (const InView& landmark : seen) {
    const auto blurred = blurred_template(*landmark.landmark, landmark.view_change);
    const auto patch = warp(landmark.landmark->patch, landmark.view_change);
    if (!blurred || !patch) continue;
    Eigen::RowVectorXf correlation = blurred->transpose() * places.gray;
    for (int choice = 0; choice < 2; ++choice) {
      Eigen::Index best = 0;
      correlation.maxCoeff(&best);
      const cv::Point at = places.at[static_cast<std::size_t>(best)];
      for (std::size_t k = 0; k < places.at.size(); ++k)
        if (std::abs(places.at[k].x - at.x) <= kPatchHalf && std::abs(places.at[k].y - at.y) <= kPatchHalf)
          correlation(static_cast<Eigen::Index>(k)) = -1;
      if (const auto found = detection(image, landmark, *patch, {at.x, at.y}, state, camera))
        all.push_back(*found);
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.correlation > b.correlation; });
  if (all.size() > kMostDetections) all.resize(kMostDetections, all.front());
  return all;
}

Hypothesis hypothesis(const Eigen::Isometry3d& X_WC, const std::vector<Detection>& detections,
                      const Camera& camera) {
  Hypothesis found{X_WC};
  const Eigen::Isometry3d X_CW = X_WC.inverse();
  for (std::size_t i = 0; i < detections.size(); ++i) {
    const auto projection = camera.project(X_CW * detections[i].bearing.p_W);
    if (!projection) continue;
    const double squared = (projection->pixel - detections[i].pixel).squaredNorm();
    if (!(squared < kInlierResidual_px * kInlierResidual_px)) continue;
    found.inliers.push_back(i);
    found.squared_residuals += squared;
  }
  return found;
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
  return A.inverse() * b;
}

Vector6d solved(const Matrix6d& A, const Vector6d& b) { return A.ldlt().solve(b); }

/// Refines the pose by Gauss-Newton; the uncertainty of each landmark counts as noise of its pixel. Because
/// the landmarks share most of their error, many of them do not make the pose more certain than one.
/// Residuals larger than this noise enlarge the covariance.
Estimate refine(Eigen::Isometry3d X_WC, const std::vector<Detection>& detections,
                const std::vector<std::size_t>& inliers, const Camera& camera, double sigma_px) {
  Matrix6d information = Matrix6d::Identity();
  double squares = 0;
  for (int k = 0; k < kPoseIterations; ++k) {
    information.setZero();
    squares = 0;
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
      const Eigen::Matrix2d W = R.inverse();
      const Eigen::Vector2d residual = detections[i].pixel - projection->pixel;
      information += J.transpose() * W * J;
      gradient += J.transpose() * W * residual;
      squares += residual.dot(W * residual);
    }
    const Vector6d step = solved(information, gradient);
    X_WC.linear() = X_WC.linear() * rotation_matrix(quaternion_exp(step.head<3>()));
    X_WC.translation() += step.tail<3>();
  }
  const auto count = static_cast<double>(inliers.size());
  const double larger = count * std::max(1.0, squares / std::max(1.0, 2 * count - 6));
  Matrix6d covariance;
  for (int k = 0; k < 6; ++k) covariance.col(k) = larger * solved(information, Vector6d::Unit(k));
  return {Stamp(0), X_WC, covariance};
}

}  // namespace

bool is_same_view(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.translation() - b.translation()).norm() < kSamePlace_m &&
         Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle() < kSameHeading_rad;
}

bool agree(const Estimate& found, const Estimate& predicted) {
  Vector6d difference;
  const Eigen::AngleAxisd turn(predicted.X_WC.linear().transpose() * found.X_WC.linear());
  difference << turn.angle() * turn.axis(), found.X_WC.translation() - predicted.X_WC.translation();
  const double squared = difference.dot(solved(found.covariance + predicted.covariance, difference));
  return squared >= 0 && squared < kLargestDifference * kLargestDifference;
}

bool RelocalizationConfirmer::moves_alike(const Estimate& found, const Estimate& predicted,
                                          bool plan_is_known) {
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

namespace {

/// The few best poses from all pairs of detections, each clearly different, near the height and heading of
/// X_WC.
std::vector<Hypothesis> hypotheses(const std::vector<Detection>& detections, const Eigen::Isometry3d& X_WC,
                                   double height_error_m, const Camera& camera) {
  std::vector<Hypothesis> best;
  for (std::size_t i = 0; i < detections.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      if (detections[i].landmark == detections[j].landmark) continue;
      for (const auto& X : poses_from_two(detections[i].bearing, detections[j].bearing, X_WC.linear())) {
        if (std::abs(X.translation().z() - X_WC.translation().z()) > height_error_m ||
            X.linear().col(2).dot(X_WC.linear().col(2)) < kLeastAhead)
          continue;
        Hypothesis found = hypothesis(X, detections, camera);
        if (found.inliers.size() < kLeastHypothesis) continue;
        auto other = std::find_if(best.begin(), best.end(),
                                  [&](const auto& kept) { return is_same_view(X, kept.X_WC); });
        if (other == best.end() && best.size() < kMostHypotheses) {
          best.push_back(std::move(found));
          continue;
        }
        if (other == best.end()) other = std::max_element(best.begin(), best.end(), is_better);  // the worst
        if (is_better(found, *other)) *other = std::move(found);
      }
    }
  return best;
}

/// A pose confirmed by landmarks predicted in view, and the fraction of these landmarks that was found.
struct Verified {
  Estimate pose;
  std::size_t found = 0;
  double share = 0;
};

Verified verify(const Estimate& pose, const cv::Mat& image, const std::vector<const Landmark*>& landmarks,
                const State& state, const Camera& camera, double sigma_px) {
  std::vector<Detection> found;
  std::size_t predicted = 0;
  for (const InView& seen : in_view(landmarks, state, pose.X_WC, camera)) {
    const Eigen::Vector3d now = pose.X_WC.translation() - seen.p_W,
                          first = seen.landmark->X_WC_first.translation() - seen.p_W;
    const auto patch = warp(seen.landmark->patch, seen.view_change);
    if (!patch || now.dot(first) < kLikeFirstView * now.norm() * first.norm()) continue;
    ++predicted;
    const auto near = search_ellipse(image, *patch, seen.pixel,
                                     kVerifySigma_px * kVerifySigma_px * Eigen::Matrix2d::Identity(), 3);
    if (const auto at = near ? detection(image, seen, *patch, near->pixel, state, camera) : std::nullopt)
      found.push_back(*at);
  }
  const auto first = hypothesis(pose.X_WC, found, camera).inliers;
  Verified verified{pose};
  if (first.size() < kLeastRecognized) return verified;
  verified.pose = refine(pose.X_WC, found, first, camera, sigma_px);
  verified.found = hypothesis(verified.pose.X_WC, found, camera).inliers.size();
  verified.share = static_cast<double>(verified.found) / static_cast<double>(predicted);
  return verified;
}

}  // namespace

std::optional<Estimate> relocalize(const cv::Mat& image, const std::vector<Landmark>& landmarks,
                                   const State& state, double turn, const Camera& camera, double sigma_px) {
  Eigen::Isometry3d X_WC = state.X_WC();
  X_WC.linear() = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) * X_WC.linear();
  const std::vector<const Landmark*> reliable = reliable_landmarks(landmarks, state);
  const std::vector<Detection> detections =
      detect(image, as_first_seen(reliable, state, X_WC), state, camera);
  const double sigma_z_m = std::sqrt(state.marginal<3>(kPosition)(2, 2));
  std::vector<Verified> poses;
  const auto verified = [&](const Estimate& pose) {
    return verify(pose, image, reliable, state, camera, sigma_px);
  };
  for (const Hypothesis& candidate :
       hypotheses(detections, X_WC, kHeightGate * std::hypot(sigma_z_m, kHeightSigma_m), camera))
    poses.push_back(
        verified(verified(refine(candidate.X_WC, detections, candidate.inliers, camera, sigma_px)).pose));
  const auto best = std::max_element(poses.begin(), poses.end(),
                                     [](const auto& a, const auto& b) { return a.found < b.found; });
  if (best == poses.end() || best->found < kLeastRecognized || best->share < kLeastShare) return std::nullopt;
  for (const Verified& other : poses) {
    if (kLead * other.share > best->share && !is_same_view(other.pose.X_WC, best->pose.X_WC))
      return std::nullopt;
  }
  return best->pose;
}

double Headings::next() {
  const int k = searched_++ % kCount;  // 0, 1, -1, 2, -2, ...
  return first_ + kStep * (k % 2 == 1 ? (k + 1) / 2 : -k / 2);
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
