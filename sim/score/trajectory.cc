#include "sim/score/trajectory.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <algorithm>
#include <array>

namespace sim::score {
namespace {

using Unit = Spans::Unit;

Trajectory::const_iterator first_not_before(const Trajectory& trajectory, Stamp t) {
  return std::ranges::lower_bound(trajectory, t, {}, &TimedPose::t);
}

constexpr std::array<std::string_view, 6> kNames{"none", "origin", "yaw", "se3", "sim3", "scale"};

// First and second moments of the paired positions, about their means.
struct Moments {
  Eigen::Vector3d mean_true = Eigen::Vector3d::Zero(), mean_estimate = Eigen::Vector3d::Zero();
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();  // mean of (true)(estimate)ᵀ
  double square_true = 0, square_estimate = 0;      // means of squared distances

  explicit Moments(const std::vector<PosePair>& pairs) {
    const double n = double(pairs.size());
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
  // A moment (m²) up to this is a rounding error: 1e-12 of the spread, or 1e-10 of the distance to 0.
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
    return Absent{"the positions have no horizontal spread: the rotation about z is not determined"};
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

bool turning(const Spans& which) { return which.unit == Unit::radians || which.unit == Unit::degrees; }

const Eigen::Isometry3d& pose(const PosePair& pair, const Spans& which) {
  return which.along_truth ? pair.X_true : pair.X_estimate;
}

// The angle between two orientations, in the unit of the spans.
double turn(const PosePair& from, const PosePair& to, const Spans& which) {
  const Eigen::Matrix3d R = pose(from, which).linear().transpose() * pose(to, which).linear();
  return rotation_vector(R).norm() * (which.unit == Unit::degrees ? 180 / std::numbers::pi : 1);
}

// Returns the position of each pose along the path: frames, meters, radians or degrees turned, or seconds.
std::vector<double> places(const std::vector<PosePair>& pairs, const Spans& which) {
  const auto place = [&](std::size_t i, double before) {
    if (which.unit == Unit::frames) return double(i);
    if (which.unit == Unit::seconds) return double((pairs[i].t - pairs[0].t).count()) * 1e-9;
    if (i == 0) return 0.0;
    if (turning(which)) return before + turn(pairs[i - 1], pairs[i], which);
    return before + (pose(pairs[i], which).translation() - pose(pairs[i - 1], which).translation()).norm();
  };
  std::vector<double> all;
  for (std::size_t i = 0; i < pairs.size(); ++i) all.push_back(place(i, i == 0 ? 0 : all.back()));
  return all;
}

// Stamps are whole ns, so lengths are equal if they differ by less than half a ns.
double rounding(const Spans& which) { return which.unit == Unit::seconds ? 0.5e-9 : 0; }

std::vector<Span> consecutive(const std::vector<double>& place, const Spans& which) {
  std::vector<Span> spans;
  bool begun = which.unit != Unit::meters;
  const double enough = which.delta - rounding(which);
  std::size_t from = 0;
  for (std::size_t i = 1; i < place.size(); ++i) {
    if (place[i] - place[from] < enough) continue;
    if (begun) spans.push_back({from, i});
    begun = true;
    from = i;
  }
  return spans;
}

std::vector<Span> from_each(const std::vector<double>& place, const Spans& which) {
  std::vector<Span> spans;
  const double slack = which.unit == Unit::frames ? 0 : which.tolerance * which.delta + rounding(which);
  for (std::size_t from = 0; from + 1 < place.size(); ++from) {
    const double wanted = place[from] + which.delta;  // the later pose nearest to it; the earlier of two
    const auto begin = place.begin() + std::ptrdiff_t(from) + 1;
    auto end = std::lower_bound(begin, place.end(), wanted);
    if (end == place.end() || (end != begin && wanted - *(end - 1) <= *end - place[from] - which.delta))
      --end;
    if (std::abs(*end - place[from] - which.delta) <= slack)
      spans.push_back({from, std::size_t(end - place.begin())});
  }
  return spans;
}

std::vector<Span> all_turns(const std::vector<PosePair>& pairs, const Spans& which) {
  std::vector<Span> spans;
  for (std::size_t from = 0; from < pairs.size(); ++from)
    for (std::size_t to = from + 1; to < pairs.size(); ++to)
      if (std::abs(turn(pairs[from], pairs[to], which) - which.delta) <= which.tolerance * which.delta)
        spans.push_back({from, to});
  return spans;
}

}  // namespace

std::vector<PosePair> pair_by_nearest(const Trajectory& truth, const Trajectory& estimate, Stamp most,
                                      Stamp offset) {
  Trajectory shifted = estimate;
  for (TimedPose& pose : shifted) pose.t += offset;
  const bool fewer_estimates = shifted.size() <= truth.size();
  const Trajectory &few = fewer_estimates ? shifted : truth, &many = fewer_estimates ? truth : shifted;
  std::vector<PosePair> pairs;
  auto last = many.end();  // the pose of the last pair, which is `last_apart` from its partner
  Stamp last_apart{0};
  for (const TimedPose& pose : few) {
    auto nearest = first_not_before(many, pose.t);
    if (nearest != many.begin() &&
        (nearest == many.end() || pose.t - (nearest - 1)->t <= nearest->t - pose.t))
      --nearest;
    if (nearest == many.end()) continue;
    const Stamp apart = std::chrono::abs(nearest->t - pose.t);
    if (apart > most || (nearest == last && apart >= last_apart)) continue;
    if (nearest == last) pairs.pop_back();
    const auto &of_truth = fewer_estimates ? *nearest : pose,
               &of_estimate = fewer_estimates ? pose : *nearest;
    pairs.push_back({of_estimate.t, of_truth.X, of_estimate.X});
    last = nearest;
    last_apart = apart;
  }
  return pairs;
}

std::vector<PosePair> pair_by_interpolation(const Trajectory& truth, const Trajectory& estimate,
                                            Stamp most_gap) {
  std::vector<PosePair> pairs;
  for (const TimedPose& pose : estimate) {
    const auto after = first_not_before(truth, pose.t);
    const bool between = after != truth.begin() && after != truth.end() && after->t != pose.t;
    if (between && after->t - (after - 1)->t > most_gap) continue;
    if (const auto X = interpolate(truth, pose.t)) pairs.push_back({pose.t, *X, pose.X});
  }
  return pairs;
}

std::optional<Eigen::Isometry3d> interpolate(const Trajectory& trajectory, Stamp t) {
  const auto after = first_not_before(trajectory, t);
  if (after == trajectory.end()) return std::nullopt;
  if (after->t == t) return after->X;
  if (after == trajectory.begin()) return std::nullopt;
  return files::interpolate(*(after - 1), *after, t);
}

double path_length(const Trajectory& trajectory) {
  double length = 0;
  for (std::size_t i = 1; i < trajectory.size(); ++i)
    length += (trajectory[i].X.translation() - trajectory[i - 1].X.translation()).norm();
  return length;
}

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  Eigen::Quaterniond q(R);
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();  // sine of half the angle
  return sine < 1e-12 ? Eigen::Vector3d(2 * q.vec())
                      : Eigen::Vector3d(2 * std::atan2(sine, q.w()) / sine * q.vec());
}

double yaw(const Eigen::Matrix3d& R) { return std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1)); }

std::vector<double> position_errors(const std::vector<PosePair>& pairs) {
  std::vector<double> errors;
  for (const PosePair& pair : pairs)
    errors.push_back((pair.X_true.translation() - pair.X_estimate.translation()).norm());
  return errors;
}

std::vector<double> orientation_errors(const std::vector<PosePair>& pairs) {
  std::vector<double> errors;
  for (const PosePair& pair : pairs)
    errors.push_back(rotation_vector(pair.X_estimate.linear().transpose() * pair.X_true.linear()).norm());
  return errors;
}

double yaw_error(const PosePair& pair) {
  return yaw(pair.X_true.linear() * pair.X_estimate.linear().transpose());
}

double height_range(const Trajectory& trajectory) {
  if (trajectory.empty()) return 0;
  const auto [least, greatest] = std::ranges::minmax_element(
      trajectory, {}, [](const TimedPose& pose) { return pose.X.translation().z(); });
  return greatest->X.translation().z() - least->X.translation().z();
}

Eigen::Vector3d drift(const Eigen::Isometry3d& X_WB_true, const Eigen::Isometry3d& X_PB,
                      const Eigen::Isometry3d& X_PB_start) {
  const double start = yaw(X_PB_start.linear());
  const Eigen::Vector3d shift = Eigen::AngleAxisd(-start, Eigen::Vector3d::UnitZ()) *
                                Eigen::Vector3d(X_WB_true.translation() - X_PB.translation());
  return {shift.x(), shift.y(), yaw(X_WB_true.linear() * X_PB.linear().transpose())};
}

std::string name_of(Alignment alignment) { return std::string(kNames[std::size_t(alignment)]); }

std::optional<Alignment> alignment_of(const std::string& name) {
  const auto found = std::ranges::find(kNames, name);
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
  if (pairs.empty()) return Absent{"no pose has a true pose at the same time"};
  if (alignment == Alignment::none) return Similarity{};
  if (alignment == Alignment::origin) {
    const Eigen::Isometry3d X = pairs.front().X_true * pairs.front().X_estimate.inverse();
    return Similarity{1, X.linear(), X.translation()};
  }
  if (alignment == Alignment::yaw_position) return align_yaw(Moments(pairs));
  return align_umeyama(Moments(pairs), alignment);
}

std::optional<std::string> doubt_of_scale(const Similarity& S, const std::vector<PosePair>& pairs) {
  constexpr double kFollows = 0.5, kFar = 2;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const PosePair& pair : pairs) mean += pair.X_true.translation() / double(pairs.size());
  double extent = 0, error = 0;
  for (const PosePair& pair : transformed(S, pairs)) {
    extent += (pair.X_true.translation() - mean).squaredNorm();
    error += (pair.X_true.translation() - pair.X_estimate.translation()).squaredNorm();
  }
  const auto rms = [&](double sum) { return std::sqrt(sum / double(pairs.size())); };
  if (!(rms(error) <= kFollows * rms(extent)))
    return fmt::format(
        "the scale {:.4g} is meaningless: the error {:.2g} m is not small compared with the true motion "
        "of {:.2g} m",
        S.scale, rms(error), rms(extent));
  if (!(S.scale > 1 / kFar && S.scale < kFar))
    return fmt::format(
        "the scale {:.4g} is far from 1, which happens only if the estimator cannot observe the scale",
        S.scale);
  return std::nullopt;
}

std::vector<PosePair> transformed(const Similarity& S, std::vector<PosePair> pairs) {
  for (PosePair& pair : pairs) pair.X_estimate = S * pair.X_estimate;
  return pairs;
}

std::vector<Span> spans(const std::vector<PosePair>& pairs, const Spans& which) {
  if (turning(which) && which.all) return all_turns(pairs, which);
  const std::vector<double> place = places(pairs, which);
  return which.all ? from_each(place, which) : consecutive(place, which);
}

Eigen::Isometry3d relative_difference(const std::vector<PosePair>& pairs, const Span& span) {
  const PosePair &from = pairs[span.from], &to = pairs[span.to];
  const Eigen::Isometry3d truth = from.X_true.inverse() * to.X_true;
  return truth.inverse() * from.X_estimate.inverse() * to.X_estimate;
}

std::optional<PoseNees> pose_nees(const Eigen::Isometry3d& X_WC_true, const Eigen::Isometry3d& X_WC_estimate,
                                  const Matrix6d& covariance) {
  const Eigen::Vector3d turn = rotation_vector(X_WC_estimate.linear().transpose() * X_WC_true.linear());
  const Eigen::Vector3d shift = X_WC_true.translation() - X_WC_estimate.translation();
  const auto normalized_square = [](const Eigen::Vector3d& error,
                                    const Eigen::Matrix3d& block) -> std::optional<double> {
    const Eigen::LLT<Eigen::Matrix3d> llt(block);
    if (llt.info() != Eigen::Success || !block.allFinite()) return std::nullopt;
    return error.dot(llt.solve(error));
  };
  const auto orientation = normalized_square(turn, covariance.topLeftCorner<3, 3>());
  const auto position = normalized_square(shift, covariance.bottomRightCorner<3, 3>());
  if (!orientation || !position) return std::nullopt;
  return PoseNees{*orientation, *position};
}

}  // namespace sim::score
