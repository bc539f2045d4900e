// Which matches are inliers: one match, taken for right, predicts all the others.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "slam/measurement.h"

namespace slam {

class Consensus {
 public:
  /// The inliers among the stacked matches (2 rows each) by the 1-point RANSAC of Civera et al. 2010. Each
  /// match serves once as the hypothesis, and the others are gated by their chi-square conditional on it, so
  /// that prior correlations count as in joint compatibility (Neira & Tardós 2001). Then those are rescued
  /// that pass the gate conditional on all the inliers. Returns rising indices, valid until the next call.
  /// gate: chi-square bound for a match of 2 rows.
  const std::vector<std::size_t>& largest(const StackedMeasurement& matches, double gate);

 private:
  void rescue(const StackedMeasurement& matches, double gate);

  std::vector<std::size_t> best_, supporters_, rescued_;
  StackedMeasurement inliers_;
  Whitening whitening_;
  Eigen::MatrixXd cross_;
};

}  // namespace slam
