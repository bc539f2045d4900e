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
};

Moments moments(const std::vector<PosePair>& pairs) {
  Moments m;
  const double n = static_cast<double>(pairs.size());
  for (const PosePair& pair : pairs) {
    m.mean_true += pair.X_true.translation() / n;
    m.mean_estimate += pair.X_estimate.translation() / n;
  }
  for (const PosePair& pair : pairs) {
    const Eigen::Vector3d a = pair.X_true.translation() - m.mean_true,
                          b = pair.X_estimate.translation() - m.mean_estimate;
    m.cross += a * b.transpose() / n;
    m.square_true += a.squaredNorm() / n;
    m.square_estimate += b.squaredNorm() / n;
  }
  return m;
}

// A moment (m²) not above this is a rounding error: 1e-12 of the spread, or distances of 1e-10 of that from
// the origin.
double rounding_error(const Moments& m) {
  return 1e-12 * std::sqrt(m.square_true * m.square_estimate) +
         1e-20 * m.mean_true.norm() * m.mean_estimate.norm();
}

Similarity about_means(const Moments& m, const Eigen::Matrix3d& R, double scale) {
  return {scale, R, m.mean_true - scale * R * m.mean_estimate};
}

Similarity align_origin(const PosePair& first) {
  const Eigen::Isometry3d X = first.X_true * first.X_estimate.inverse();
  return {1, X.linear(), X.translation()};
}

OrAbsent<Similarity> align_yaw(const Moments& m) {
  const double sine = m.cross(1, 0) - m.cross(0, 1), cosine = m.cross(0, 0) + m.cross(1, 1);
  if (!(std::hypot(sine, cosine) > rounding_error(m)))
    return Absent{"the positions do not spread horizontally: the rotation about z is not determined"};
  return about_means(
      m, Eigen::AngleAxisd(std::atan2(sine, cosine), Eigen::Vector3d::UnitZ()).toRotationMatrix(), 1);
}

// Umeyama 1991, eqs. (39)-(43).
OrAbsent<Similarity> align_umeyama(const Moments& m, bool with_scale) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m.cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d D = svd.singularValues();
  if (!(D(0) > rounding_error(m))) return Absent{"all positions coincide"};
  if (!(D(1) > rounding_error(m)))
    return Absent{"the positions are on one line: the rotation about it is not determined"};
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) signs(2) = -1;
  const Eigen::Matrix3d R = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  return about_means(m, R, with_scale ? D.dot(signs) / m.square_estimate : 1);
}

// The scale of Umeyama's alignment, without its rotation and translation.
OrAbsent<Similarity> align_scale(const Moments& m) {
  const auto full = align_umeyama(m, true);
  if (const auto* none = std::get_if<Absent>(&full)) return *none;
  return Similarity{std::get<Similarity>(full).scale, Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()};
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
  switch (alignment) {
    case Alignment::none:
      return Similarity{};
    case Alignment::origin:
      return align_origin(pairs.front());
    case Alignment::yaw_position:
      return align_yaw(moments(pairs));
    case Alignment::se3:
      return align_umeyama(moments(pairs), false);
    case Alignment::sim3:
      return align_umeyama(moments(pairs), true);
    case Alignment::scale:
      return align_scale(moments(pairs));
  }
  return Absent{"unknown alignment"};
}

std::vector<PosePair> transformed(const Similarity& S, std::vector<PosePair> pairs) {
  for (PosePair& pair : pairs) pair.X_estimate = S * pair.X_estimate;
  return pairs;
}

}  // namespace sim::score
