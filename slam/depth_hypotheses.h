// What is believed of the depth of a landmark that is still a line (Davison 2003; Fig. 3 of the paper).
#pragma once

#include <vector>

namespace slam {

/// One hypothesis of how far along the line the landmark is.
struct DepthParticle {
  double depth_m, probability;
};

/// All hypotheses of one landmark; the probabilities' sum is 1.
struct DepthHypotheses {
  int landmark = 0;
  std::vector<DepthParticle> particles;
};

}  // namespace slam
