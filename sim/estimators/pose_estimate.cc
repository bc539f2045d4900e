#include "sim/estimators/pose_estimate.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

namespace sim::estimators {
namespace {

constexpr double kMost_m = 1e9;  // beyond, squares of positions have no accuracy left
constexpr double kRotation =
    1e-6;  // by which R^T R of numbers that were written out may differ from the identity
constexpr double kSymmetric = 1e-6;  // relative to the largest element

void require_pose(const PoseEstimate& estimate) {
  if (!estimate.X_WC.matrix().allFinite()) throw EstimatorFailed("its pose is not finite");
  const Eigen::Matrix3d R = estimate.X_WC.linear();
  if (!(R.transpose() * R).isIdentity(kRotation) || R.determinant() < 0)
    throw EstimatorFailed("the orientation of its pose is no rotation matrix");
  if (estimate.X_WC.translation().cwiseAbs().maxCoeff() > kMost_m)
    throw EstimatorFailed("its position is more than 1e9 m away");
}

template <class Matrix>
void require_covariance(const Matrix& P, std::string_view of) {
  if (!P.allFinite()) throw EstimatorFailed(fmt::format("the covariance of {} is not finite", of));
  const double largest = P.cwiseAbs().maxCoeff();
  if ((P - P.transpose()).cwiseAbs().maxCoeff() > kSymmetric * largest)
    throw EstimatorFailed(fmt::format("the covariance of {} is not symmetric", of));
}

}  // namespace

void require_sound(const Answer& answer, slam::Stamp earliest, slam::Stamp newest) {
  const slam::Stamp t = answer.estimate.t;
  if (t < earliest || t > newest)
    throw EstimatorFailed(fmt::format("its pose has the stamp {} ns, expected one from {} to {} ns",
                                      t.count(), earliest.count(), newest.count()));
  require_pose(answer.estimate);
  if (answer.estimate.covariance) require_covariance(*answer.estimate.covariance, "its pose");
  for (const slam::MapPoint& point : answer.map) {
    if (!point.p_W.allFinite()) throw EstimatorFailed(fmt::format("its landmark {} is not finite", point.id));
    require_covariance(point.covariance, fmt::format("its landmark {}", point.id));
  }
}

std::string printable(std::string_view text) {
  std::string line;
  for (const char c : text) {
    const bool blank = c == '\n' || c == '\t' || c == '\r';
    line += blank ? ' ' : c >= ' ' && c <= '~' ? c : '?';
  }
  return line;
}

}  // namespace sim::estimators
