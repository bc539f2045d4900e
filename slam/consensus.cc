#include "slam/consensus.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

namespace slam {
namespace {

/// νᵀS⁻¹ν of match j once match i has been believed.
double distance_given(const Joint& joint, int i, int j) {
  const Eigen::Matrix2d S_i = joint.S().block<2, 2>(2 * i, 2 * i), S_ji = joint.S().block<2, 2>(2 * j, 2 * i);
  const Eigen::Matrix2d gain = S_i.llt().solve(S_ji.transpose()).transpose();
  const Eigen::Vector2d nu =
      joint.innovation().segment<2>(2 * j) - gain * joint.innovation().segment<2>(2 * i);
  const Eigen::Matrix2d S = joint.S().block<2, 2>(2 * j, 2 * j) - gain * S_ji.transpose();
  return S.llt().matrixL().solve(nu).squaredNorm();
}

}  // namespace

void Consensus::consent_with(const Joint& joint, int i, double gate) {
  const int count = static_cast<int>(joint.first_row.size()) - 1;
  consent_.clear();
  distance_ = 0;
  for (int j = 0; j < count; ++j) {
    const Eigen::Vector2d nu = joint.innovation().segment<2>(2 * j);
    const double d = i == j ? joint.S().block<2, 2>(2 * i, 2 * i).llt().matrixL().solve(nu).squaredNorm()
                            : distance_given(joint, i, j);
    if (!(d < gate)) continue;
    consent_.push_back(static_cast<std::size_t>(j));
    distance_ += d;
  }
}

/// Adds to best_ the matches that pass the gate given all of it.
void Consensus::rescue(const Joint& joint, double gate) {
  select(joint, best_, agreed_);
  const int rows = agreed_.rows;
  make_room(work_, rows, rows + 3);
  auto L = work_.topLeftCorner(rows, rows);
  auto white = work_.col(rows).head(rows);
  auto cross = work_.middleCols<2>(rows + 1).topRows(rows);
  L = agreed_.S();
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(L);
  white = agreed_.innovation();
  llt.matrixL().solveInPlace(white);
  all_.clear();
  for (std::size_t j = 0; j + 1 < joint.first_row.size(); ++j) {
    if (std::binary_search(best_.begin(), best_.end(), j)) {
      all_.push_back(j);
      continue;
    }
    const int row = joint.first_row[j];
    for (std::size_t k = 0; k < best_.size(); ++k)
      cross.middleRows<2>(2 * static_cast<int>(k)) = joint.S().block<2, 2>(joint.first_row[best_[k]], row);
    llt.matrixL().solveInPlace(cross);
    const Eigen::Vector2d nu = joint.innovation().segment<2>(row) - cross.transpose() * white;
    const Eigen::Matrix2d S = joint.S().block<2, 2>(row, row) - cross.transpose() * cross;
    if (S.llt().matrixL().solve(nu).squaredNorm() < gate) all_.push_back(j);
  }
  best_.swap(all_);
}

const std::vector<std::size_t>& Consensus::largest(const Joint& joint, double gate) {
  best_.clear();
  double least = 0;
  for (int i = 0; i + 1 < static_cast<int>(joint.first_row.size()); ++i) {
    consent_with(joint, i, gate);
    const bool more = consent_.size() > best_.size();
    const bool closer = consent_.size() == best_.size() && distance_ < least;
    if (!more && !closer) continue;
    best_.swap(consent_);
    least = distance_;
  }
  if (!best_.empty()) rescue(joint, gate);
  return best_;
}

void sharpen(Joint& joint, const std::vector<Measurement>& measurements, double ratio) {
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    const Measurement& m = measurements[i];
    joint.S().block(joint.first_row[i], joint.first_row[i], m.rows, m.rows) -= (1 - ratio * ratio) * m.R;
  }
}

void select(const Joint& joint, const std::vector<std::size_t>& keep, Joint& selected) {
  selected.first_row.assign(1, 0);
  for (const std::size_t i : keep)
    selected.first_row.push_back(selected.first_row.back() + joint.first_row[i + 1] - joint.first_row[i]);
  selected.resize(joint.size, selected.first_row.back());
  for (std::size_t k = 0; k < keep.size(); ++k) {
    const int from = joint.first_row[keep[k]], to = selected.first_row[k];
    const int rows = selected.first_row[k + 1] - to;
    selected.innovation().segment(to, rows) = joint.innovation().segment(from, rows);
    selected.PHt().middleCols(to, rows) = joint.PHt().middleCols(from, rows);
    for (std::size_t l = 0; l < keep.size(); ++l) {
      const int column = joint.first_row[keep[l]], count = joint.first_row[keep[l] + 1] - column;
      selected.S().block(to, selected.first_row[l], rows, count) = joint.S().block(from, column, rows, count);
    }
  }
}

}  // namespace slam
