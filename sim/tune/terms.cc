#include "sim/tune/terms.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

namespace sim::tune {
namespace {

const double kLn2Pi = std::log(2 * std::numbers::pi);

// Over the scored frames.
std::optional<double> mean_pose_nll(const score::ScoreContext& scored) {
  double sum = 0;
  auto pose = scored.run.estimate->begin();
  for (const score::PosePair& pair : scored.pairs) {
    while (pose->t != pair.t) ++pose;
    if (!pose->covariance) return std::nullopt;
    const auto nll = pose_nll(pair.X_true, pair.X_estimate, *pose->covariance);
    if (!nll) return std::nullopt;
    sum += *nll;
  }
  return sum / static_cast<double>(scored.pairs.size());
}

double mean_innovation_nll(const tracking::Tracked& tracked, double image_px2) {
  double sum = 0;
  for (const tracking::TrackedFrame& frame : tracked.frames) sum += innovation_nll(frame.report, image_px2);
  return sum / static_cast<double>(tracked.frames.size());
}

// The sum of what is said of each part, of those that have values.
double sum_of_consistencies(const score::Metrics& metrics, const std::vector<std::string>& parts,
                            const std::string& mean, const std::string& variance, double expected_mean,
                            double expected_variance) {
  double sum = 0;
  for (const std::string& part : parts) {
    const auto& m = metrics.at(part + mean).value;
    const auto& v = metrics.at(part + variance).value;
    if (m && v) sum += consistency(*m, expected_mean, *v, expected_variance);
  }
  return sum;
}

}  // namespace

std::optional<double> pose_nll(const Eigen::Isometry3d& X_WC_true, const Eigen::Isometry3d& X_WC_estimate,
                               const score::Matrix6d& covariance) {
  const Eigen::LLT<score::Matrix6d> llt(covariance);
  if (llt.info() != Eigen::Success || !covariance.allFinite()) return std::nullopt;
  Eigen::Matrix<double, 6, 1> error;
  error << score::rotation_vector(X_WC_estimate.linear().transpose() * X_WC_true.linear()),
      X_WC_true.translation() - X_WC_estimate.translation();
  const double log_determinant = 2 * llt.matrixLLT().diagonal().array().log().sum();
  return (llt.matrixL().solve(error).squaredNorm() + log_determinant + 6 * kLn2Pi) / 2;
}

double nll(const slam::Nis& nis) { return (nis.value + nis.log_determinant + nis.dof * kLn2Pi) / 2; }

double innovation_nll(const slam::FrameReport& report, double image_px2) {
  double sum = 0;
  for (const slam::SensorInnovation& innovation : report.innovations)
    if (innovation.sensor != "vision") sum += nll(innovation.nis);  // matches count with the update's noise
  if (report.update) sum += nll(*report.update);
  const auto in_vain = report.searched.size() - report.matched.size();
  return sum + static_cast<double>(in_vain) * std::log(image_px2);
}

double consistency(double mean, double expected_mean, double variance, double expected_variance) {
  return std::abs(std::log(mean / expected_mean)) + std::abs(std::log(variance / expected_variance));
}

std::optional<Terms> terms(const score::ScoreContext& scored, const tracking::Tracked& tracked,
                           const score::Metrics& metrics, const slam::CameraIntrinsics& camera) {
  const auto rmse = metrics.at("rmse_m").value;
  if (scored.no_estimate || !rmse) return std::nullopt;
  const auto pose = mean_pose_nll(scored);
  if (!pose) return std::nullopt;
  Terms terms;
  terms.pose_nll = *pose;
  terms.innovation_nll = mean_innovation_nll(tracked, 1.0 * camera.width_px * camera.height_px);
  terms.consistency =
      sum_of_consistencies(metrics, {"nees_position", "nees_orientation"}, "_mean", "_variance", 3, 6);
  std::vector<std::string> nis;
  for (const std::string_view sensor : score::kSensors) nis.push_back("nis_" + std::string(sensor));
  terms.nis_consistency = sum_of_consistencies(metrics, nis, "_mean", "_variance", 1, 1);
  terms.rmse_m = *rmse;
  return terms;
}

}  // namespace sim::tune
