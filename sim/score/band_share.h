// Consistency of many runs together: their mean normalised square at each moment, compared with its
// confidence interval.
#pragma once

#include <optional>
#include <vector>

namespace sim::score {

inline constexpr double kSettled_s = 5;  ///< earlier moments are not judged: the start is given

/// mean: over all moments; inside, below: fraction of the moments at which the mean over the runs is inside
/// its 95 % confidence interval, or below it.
struct BandShare {
  double mean = 0, inside = 0, below = 0;
};

/// moments: for each moment the normalised squares (dof degrees of freedom) of the independent runs that have
/// one. Nothing if no run has any.
std::optional<BandShare> share_in_band(const std::vector<std::vector<double>>& moments, int dof);

}  // namespace sim::score
