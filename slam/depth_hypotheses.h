// The depth distribution of a landmark that is still a line (Davison 2003; Stasse et al. 2006, Fig. 3).
#pragma once

#include <vector>

namespace slam {

/// One hypothesis of the landmark's distance along the line.
struct DepthParticle {
  double depth_m, probability;
};

/// All hypotheses of one landmark; their probabilities sum to 1.
struct DepthHypotheses {
  int landmark = 0;
  std::vector<DepthParticle> particles;
};

}  // namespace slam
