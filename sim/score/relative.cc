#include "sim/score/relative.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sim::score {
namespace {

using Unit = Spans::Unit;

bool turning(const Spans& which) { return which.unit == Unit::radians || which.unit == Unit::degrees; }

const Eigen::Isometry3d& pose(const PosePair& pair, const Spans& which) {
  return which.along_truth ? pair.X_true : pair.X_estimate;
}

// The angle between two orientations, in the unit of the spans.
double turn(const PosePair& from, const PosePair& to, const Spans& which) {
  const Eigen::Matrix3d R = pose(from, which).linear().transpose() * pose(to, which).linear();
  return rotation_vector(R).norm() * (which.unit == Unit::degrees ? 180 / std::numbers::pi : 1);
}

// The place of each pose along the path: frames, meters, radians or degrees turned, or seconds.
std::vector<double> places(const std::vector<PosePair>& pairs, const Spans& which) {
  std::vector<double> all;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto position = [&](std::size_t k) { return pose(pairs[k], which).translation(); };
    if (turning(which)) all.push_back(i == 0 ? 0 : all.back() + turn(pairs[i - 1], pairs[i], which));
    if (which.unit == Unit::frames) all.push_back(static_cast<double>(i));
    if (which.unit == Unit::seconds)
      all.push_back(static_cast<double>((pairs[i].t - pairs[0].t).count()) * 1e-9);
    if (which.unit == Unit::meters)
      all.push_back(i == 0 ? 0 : all.back() + (position(i) - position(i - 1)).norm());
  }
  return all;
}

// Stamps are whole ns: lengths are equal within half of one.
double rounding(const Spans& which) { return which.unit == Unit::seconds ? 0.5e-9 : 0; }

std::vector<Span> consecutive(const std::vector<double>& place, const Spans& which) {
  std::vector<Span> spans;
  bool begun = which.unit != Unit::meters;
  const double enough = which.delta - rounding(which);
  std::size_t from = 0;
  for (std::size_t i = 1; i < place.size(); ++i) {
    if (place[i] - place[from] < enough) continue;
    if (begun) spans.push_back({from, i});
    begun = true;
    from = i;
  }
  return spans;
}

// The later pose nearest to delta away from `from`; the earlier of two.
std::size_t nearest_end(const std::vector<double>& place, std::size_t from, double delta) {
  const auto begin = place.begin() + static_cast<std::ptrdiff_t>(from) + 1;
  auto end = std::lower_bound(begin, place.end(), place[from] + delta);
  if (end == place.end() || (end != begin && place[from] + delta - *(end - 1) <= *end - place[from] - delta))
    --end;
  return static_cast<std::size_t>(end - place.begin());
}

std::vector<Span> from_each(const std::vector<double>& place, const Spans& which) {
  std::vector<Span> spans;
  const double slack = which.unit == Unit::frames ? 0 : which.tolerance * which.delta + rounding(which);
  for (std::size_t from = 0; from + 1 < place.size(); ++from) {
    const std::size_t to = nearest_end(place, from, which.delta);
    if (std::abs(place[to] - place[from] - which.delta) <= slack) spans.push_back({from, to});
  }
  return spans;
}

std::size_t nearest_pose(const std::vector<PosePair>& pairs, Stamp t) {
  const auto nearer = [t](const PosePair& a, const PosePair& b) {
    return std::chrono::abs(a.t - t) < std::chrono::abs(b.t - t);
  };
  return static_cast<std::size_t>(std::min_element(pairs.begin(), pairs.end(), nearer) - pairs.begin());
}

std::vector<Span> all_turns(const std::vector<PosePair>& pairs, const Spans& which) {
  std::vector<Span> spans;
  for (std::size_t from = 0; from < pairs.size(); ++from)
    for (std::size_t to = from + 1; to < pairs.size(); ++to)
      if (std::abs(turn(pairs[from], pairs[to], which) - which.delta) <= which.tolerance * which.delta)
        spans.push_back({from, to});
  return spans;
}

std::vector<Span> between_footsteps(const std::vector<PosePair>& pairs, const Spans& which) {
  const auto steps = static_cast<std::size_t>(which.delta);
  std::vector<Span> spans;
  if (pairs.empty()) return spans;
  for (std::size_t i = 0; i + steps < which.footsteps.size(); i += which.all ? 1 : steps) {
    const Span span{nearest_pose(pairs, which.footsteps[i]), nearest_pose(pairs, which.footsteps[i + steps])};
    if (span.from < span.to) spans.push_back(span);
  }
  return spans;
}

}  // namespace

std::vector<Span> spans(const std::vector<PosePair>& pairs, const Spans& which) {
  if (which.unit == Unit::footsteps) return between_footsteps(pairs, which);
  if (turning(which) && which.all) return all_turns(pairs, which);
  const std::vector<double> place = places(pairs, which);
  return which.all ? from_each(place, which) : consecutive(place, which);
}

Eigen::Isometry3d relative_difference(const std::vector<PosePair>& pairs, const Span& span) {
  const PosePair &from = pairs[span.from], &to = pairs[span.to];
  const Eigen::Isometry3d truth = from.X_true.inverse() * to.X_true;
  return truth.inverse() * from.X_estimate.inverse() * to.X_estimate;
}

}  // namespace sim::score
