// Whether many runs together are as sure as they should be: their mean normalised square, moment by moment,
// against its band.
#pragma once

#include <optional>
#include <vector>

namespace sim::score {

inline constexpr double kSettled_s = 5;  ///< moments before are not judged: the start is known by decree

/// mean: over all moments; inside, below: in what part of them the mean over the runs is in its 95 % band, or
/// below it.
struct BandShare {
  double mean = 0, inside = 0, below = 0;
};

/// moments: of each, the normalised squares (dof degrees of freedom) of those independent runs that have one
/// then. Nothing when no run ever has.
std::optional<BandShare> share_in_band(const std::vector<std::vector<double>>& moments, int dof);

}  // namespace sim::score
