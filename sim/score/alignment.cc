#include "sim/score/alignment.h"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace sim::score {
namespace {

constexpr std::array<std::string_view, 6> kNames{"none", "origin", "yaw", "se3", "sim3", "scale"};

// First and second moments of the paired positions, about their means.
struct Moments {
  Eigen::Vector3d mean_true = Eigen::Vector3d::Zero(), mean_estimate = Eigen::Vector3d::Zero();
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();  // mean of (true)(estimate)ᵀ
  double square_true = 0, square_estimate = 0;      // means of squared distances

  explicit Moments(const std::vector<PosePair>& pairs) {
    const double n = static_cast<double>(pairs.size());
    for (const PosePair& pair : pairs) {
      mean_true += pair.X_true.translation() / n;
      mean_estimate += pair.X_estimate.translation() / n;
    }
    for (const PosePair& pair : pairs) {
      const Eigen::Vector3d a = pair.X_true.translation() - mean_true,
                            b = pair.X_estimate.translation() - mean_estimate;
      cross += a * b.transpose() / n;
      square_true += a.squaredNorm() / n;
      square_estimate += b.squaredNorm() / n;
    }
  }
  // A moment (m²) not above this is a rounding error: 1e-12 of the spread, or distances of 1e-10 of that from
  // the origin.
  double rounding_error() const {
    return 1e-12 * std::sqrt(square_true * square_estimate) + 1e-20 * mean_true.norm() * mean_estimate.norm();
  }
  Similarity about_means(const Eigen::Matrix3d& R, double scale) const {
    return {scale, R, mean_true - scale * R * mean_estimate};
  }
};

OrAbsent<Similarity> align_yaw(const Moments& m) {
  const double sine = m.cross(1, 0) - m.cross(0, 1), cosine = m.cross(0, 0) + m.cross(1, 1);
  if (!(std::hypot(sine, cosine) > m.rounding_error()))
    return Absent{"the positions do not spread horizontally: the rotation about z is not determined"};
  const Eigen::AngleAxisd turn(std::atan2(sine, cosine), Eigen::Vector3d::UnitZ());
  return m.about_means(turn.toRotationMatrix(), 1);
}

// Umeyama 1991, eqs. (39)-(43): se3, sim3 or scale.
OrAbsent<Similarity> align_umeyama(const Moments& m, Alignment alignment) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m.cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d D = svd.singularValues();
  if (!(D(0) > m.rounding_error())) return Absent{"all positions coincide"};
  if (!(D(1) > m.rounding_error()))
    return Absent{"the positions are on one line: the rotation about it is not determined"};
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) signs(2) = -1;
  const double scale = D.dot(signs) / m.square_estimate;
  if (alignment == Alignment::scale) return Similarity{scale};
  const Eigen::Matrix3d R = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  return m.about_means(R, alignment == Alignment::sim3 ? scale : 1);
}

}  // namespace

std::string name_of(Alignment alignment) { return std::string(kNames[static_cast<std::size_t>(alignment)]); }

std::optional<Alignment> alignment_of(const std::string& name) {
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<Alignment>(found - kNames.begin());
}

Eigen::Isometry3d Similarity::operator*(const Eigen::Isometry3d& X) const {
  Eigen::Isometry3d Y = Eigen::Isometry3d::Identity();
  Y.linear() = R * X.linear();
  Y.translation() = scale * R * X.translation() + translation;
  return Y;
}

OrAbsent<Similarity> align(const std::vector<PosePair>& pairs, Alignment alignment) {
  if (pairs.empty()) return Absent{"no pose has a true one of the same time"};
  if (alignment == Alignment::none) return Similarity{};
  if (alignment == Alignment::origin) {
    const Eigen::Isometry3d X = pairs.front().X_true * pairs.front().X_estimate.inverse();
    return Similarity{1, X.linear(), X.translation()};
  }
  if (alignment == Alignment::yaw_position) return align_yaw(Moments(pairs));
  return align_umeyama(Moments(pairs), alignment);
}

std::vector<PosePair> transformed(const Similarity& S, std::vector<PosePair> pairs) {
  for (PosePair& pair : pairs) pair.X_estimate = S * pair.X_estimate;
  return pairs;
}

}  // namespace sim::score
