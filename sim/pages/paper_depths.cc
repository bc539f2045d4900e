#include "sim/pages/paper_depths.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "sim/pages/run_data.h"

namespace sim::pages {
namespace {

constexpr double kKnown = 0.3;  // standard deviation by mean: Davison 2003

struct Hypotheses {
  Column depth, probability;
};

// By landmark and time.
using History = std::map<double, Hypotheses>;

std::map<double, History> read(const std::filesystem::path& file) {
  const Table table(file);
  const Column t = table.seconds("timestamp"), landmark = table.numbers("landmark"),
               depth = table.numbers("depth"), probability = table.numbers("probability");
  std::map<double, History> all;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    Hypotheses& at = all[landmark[i]][t[i]];
    at.depth.push_back(depth[i]);
    at.probability.push_back(probability[i]);
  }
  return all;
}

double relative_sigma(const Hypotheses& h) {
  double mean = 0, square = 0;
  for (std::size_t i = 0; i < h.depth.size(); ++i) {
    mean += h.probability[i] * h.depth[i];
    square += h.probability[i] * h.depth[i] * h.depth[i];
  }
  return std::sqrt(std::max(0.0, square - mean * mean)) / mean;
}

}  // namespace

Figure depths_figure(const std::filesystem::path& depths_csv) {
  Figure f{"figure_3", "Figure 3: depth hypotheses of a new landmark collapse to a peak", "depth [m]",
           "probability of a hypothesis"};
  const History* longest = nullptr;
  const auto all = read(depths_csv);
  for (const auto& [landmark, history] : all)
    if (relative_sigma(history.rbegin()->second) < kKnown && (!longest || history.size() > longest->size()))
      longest = &history;
  if (!longest) return f;
  constexpr Role kRoles[] = {Role::third, Role::second, Role::first, Role::estimate};
  const std::size_t last = longest->size() - 1;
  for (std::size_t k = 0; k < std::size(kRoles); ++k) {
    const std::size_t image = k * last / (std::size(kRoles) - 1);
    const Hypotheses& h = std::next(longest->begin(), static_cast<std::ptrdiff_t>(image))->second;
    f.lines.push_back({fmt::format("after {} image{}", image + 1, image == 0 ? "" : "s"), kRoles[k], h.depth,
                       h.probability});
  }
  return f;
}

}  // namespace sim::pages
