// Which matches belong together: one match's word on the state predicts all the others.
#pragma once

#include <cstddef>
#include <vector>

#include "slam/kalman.h"

namespace slam {

class Consensus {
 public:
  /// The matches (measurements of `joint`) that agree: 1-point RANSAC of Civera et al. 2010, with every match
  /// as the hypothesis once and each other match judged by its chi-square given the hypothesis (so prior
  /// correlations count, as in joint compatibility, Neira & Tardós 2001); then those that agree given all the
  /// consenting ones are rescued. Indices in rising order, good till the next call. gate: chi-square bound of
  /// a match of 2 rows.
  const std::vector<std::size_t>& largest(const Joint& joint, double gate);

 private:
  void consent_with(const Joint& joint, int i, double gate);
  void rescue(const Joint& joint, double gate);

  std::vector<std::size_t> best_, consent_, all_;  // consent_: with one match, its sum of squares distance_
  double distance_ = 0;
  Joint agreed_;
  Eigen::MatrixXd work_;
};

/// Replaces the noise R of each measurement by ratio² R in S.
void sharpen(Joint& joint, const std::vector<Measurement>& measurements, double ratio);

/// The part of a joint measurement that the given measurements make.
void select(const Joint& joint, const std::vector<std::size_t>& keep, Joint& selected);

}  // namespace slam
