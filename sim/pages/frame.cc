#include "sim/pages/frame.h"

#include <Eigen/Eigenvalues>

#include "sim/score/run.h"

namespace sim::pages {

std::optional<FrameError> error_of(const Frame& frame) {
  if (!frame.truth || !frame.estimate) return std::nullopt;
  const Eigen::Vector3d e = frame.estimate->translation() - frame.truth->translation();
  FrameError all;
  all.error << e, score::yaw(frame.estimate->linear() * frame.truth->linear().transpose());
  if (!frame.covariance) return all;
  const files::Matrix6d& P = *frame.covariance;
  const Eigen::Vector3d vertical_C = frame.estimate->linear().transpose() * Eigen::Vector3d::UnitZ();
  const double yaw_variance = vertical_C.dot(P.topLeftCorner<3, 3>() * vertical_C);
  all.sigma << P.diagonal().tail<3>().cwiseSqrt(), yaw_variance < 0 ? 0 : std::sqrt(yaw_variance);
  if (const auto nees = score::pose_nees(*frame.truth, *frame.estimate, P)) all.nees = *nees;
  return all;
}

Eigen::Vector3d ellipse(const Eigen::Matrix2d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance);
  const Eigen::Vector2d half = kSigmas * solver.eigenvalues().cwiseMax(0).cwiseSqrt(),
                        along = solver.eigenvectors().col(1);
  return {half(1), half(0), std::atan2(along.y(), along.x())};
}

}  // namespace sim::pages
