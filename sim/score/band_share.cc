#include "sim/score/band_share.h"

#include <map>

#include "sim/score/consistency.h"
#include "sim/score/statistics.h"

namespace sim::score {

std::optional<BandShare> share_in_band(const std::vector<std::vector<double>>& moments, int dof) {
  std::map<std::size_t, Band> bands;  // by the number of runs, since a quantile is slow to compute
  std::vector<double> means;
  double inside = 0, below = 0;
  for (const std::vector<double>& squares : moments) {
    if (squares.empty()) continue;
    auto band = bands.find(squares.size());
    if (band == bands.end())
      band = bands.emplace(squares.size(), mean_band(dof, static_cast<int>(squares.size()))).first;
    means.push_back(mean(squares));
    below += means.back() < band->second.low;
    inside += means.back() >= band->second.low && means.back() <= band->second.high;
  }
  if (means.empty()) return std::nullopt;
  const auto count = static_cast<double>(means.size());
  return BandShare{mean(means), inside / count, below / count};
}

}  // namespace sim::score
