#include "slam/consensus.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace slam {
namespace {

double mahalanobis_squared(const Eigen::Vector2d& nu, const Eigen::Matrix2d& S) {
  return S.llt().matrixL().solve(nu).squaredNorm();
}

/// νᵀS⁻¹ν of match j conditional on match i.
double distance_given(const StackedMeasurement& matches, int i, int j) {
  const Eigen::Matrix2d S_i = matches.S().block<2, 2>(2 * i, 2 * i),
                        S_ji = matches.S().block<2, 2>(2 * j, 2 * i);
  const Eigen::Matrix2d gain = S_i.llt().solve(S_ji.transpose()).transpose();
  const Eigen::Vector2d nu =
      matches.innovation().segment<2>(2 * j) - gain * matches.innovation().segment<2>(2 * i);
  const Eigen::Matrix2d S = matches.S().block<2, 2>(2 * j, 2 * j) - gain * S_ji.transpose();
  return mahalanobis_squared(nu, S);
}

/// Finds the matches that pass the gate when match i is the hypothesis; returns the sum of their νᵀS⁻¹ν.
double find_supporters(const StackedMeasurement& matches, int i, double gate,
                       std::vector<std::size_t>& supporters) {
  supporters.clear();
  double sum = 0;
  for (int j = 0; j < static_cast<int>(matches.count()); ++j) {
    const double d = i == j ? mahalanobis_squared(matches.innovation().segment<2>(2 * i),
                                                  matches.S().block<2, 2>(2 * i, 2 * i))
                            : distance_given(matches, i, j);
    if (!(d < gate)) continue;
    supporters.push_back(static_cast<std::size_t>(j));
    sum += d;
  }
  return sum;
}

}  // namespace

/// Adds to best_ the matches that pass the gate conditional on all of best_.
void Consensus::rescue(const StackedMeasurement& matches, double gate) {
  select(matches, best_, inliers_);
  whitening_.compute(inliers_);
  reserve_workspace(cross_, inliers_.rows, 2);
  auto cross = cross_.leftCols<2>().topRows(inliers_.rows);
  rescued_.clear();
  for (std::size_t j = 0; j < matches.count(); ++j) {
    if (std::binary_search(best_.begin(), best_.end(), j)) {
      rescued_.push_back(j);
      continue;
    }
    const int row = matches.first_row[j];
    for (std::size_t k = 0; k < best_.size(); ++k)
      cross.middleRows<2>(2 * static_cast<int>(k)) =
          matches.S().block<2, 2>(matches.first_row[best_[k]], row);
    whitening_.L().triangularView<Eigen::Lower>().solveInPlace(cross);
    const Eigen::Vector2d nu =
        matches.innovation().segment<2>(row) - cross.transpose() * whitening_.innovation();
    const Eigen::Matrix2d S = matches.S().block<2, 2>(row, row) - cross.transpose() * cross;
    if (mahalanobis_squared(nu, S) < gate) rescued_.push_back(j);
  }
  best_.swap(rescued_);
}

const std::vector<std::size_t>& Consensus::largest(const StackedMeasurement& matches, double gate) {
  best_.clear();
  double least = 0;
  for (int i = 0; i < static_cast<int>(matches.count()); ++i) {
    const double sum = find_supporters(matches, i, gate, supporters_);
    const bool more = supporters_.size() > best_.size();
    const bool closer = supporters_.size() == best_.size() && sum < least;
    if (!more && !closer) continue;
    best_.swap(supporters_);
    least = sum;
  }
  if (!best_.empty()) rescue(matches, gate);
  return best_;
}

}  // namespace slam
