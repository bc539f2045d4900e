#include "sim/score/relative.h"

#include <algorithm>
#include <cmath>

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
  const auto place = [&](std::size_t i, double before) {
    if (which.unit == Unit::frames) return static_cast<double>(i);
    if (which.unit == Unit::seconds) return static_cast<double>((pairs[i].t - pairs[0].t).count()) * 1e-9;
    if (i == 0) return 0.0;
    if (turning(which)) return before + turn(pairs[i - 1], pairs[i], which);
    return before + (pose(pairs[i], which).translation() - pose(pairs[i - 1], which).translation()).norm();
  };
  std::vector<double> all;
  for (std::size_t i = 0; i < pairs.size(); ++i) all.push_back(place(i, i == 0 ? 0 : all.back()));
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

std::vector<Span> from_each(const std::vector<double>& place, const Spans& which) {
  std::vector<Span> spans;
  const double slack = which.unit == Unit::frames ? 0 : which.tolerance * which.delta + rounding(which);
  for (std::size_t from = 0; from + 1 < place.size(); ++from) {
    const double wanted = place[from] + which.delta;  // the later pose nearest to it; the earlier of two
    const auto begin = place.begin() + static_cast<std::ptrdiff_t>(from) + 1;
    auto end = std::lower_bound(begin, place.end(), wanted);
    if (end == place.end() || (end != begin && wanted - *(end - 1) <= *end - place[from] - which.delta))
      --end;
    if (std::abs(*end - place[from] - which.delta) <= slack)
      spans.push_back({from, static_cast<std::size_t>(end - place.begin())});
  }
  return spans;
}

std::vector<Span> all_turns(const std::vector<PosePair>& pairs, const Spans& which) {
  std::vector<Span> spans;
  for (std::size_t from = 0; from < pairs.size(); ++from)
    for (std::size_t to = from + 1; to < pairs.size(); ++to)
      if (std::abs(turn(pairs[from], pairs[to], which) - which.delta) <= which.tolerance * which.delta)
        spans.push_back({from, to});
  return spans;
}

}  // namespace

std::vector<Span> spans(const std::vector<PosePair>& pairs, const Spans& which) {
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
