#include "sim/report/paper_height.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace sim::report {
namespace {

constexpr double kAfter_s = 0.1;

double correlation(const Column& a, const Column& b, std::size_t shift) {
  const std::size_t n = a.size();
  double mean_a = 0, mean_b = 0, ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < n; ++i)
    mean_a += a[i] / static_cast<double>(n), mean_b += b[i] / static_cast<double>(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double da = a[i] - mean_a, db = b[(i + shift) % n] - mean_b;
    ab += da * db, aa += da * da, bb += db * db;
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

Column shortly_after(const Column& t, const Column& impacts) {
  Column flags;
  for (const double at : t) {
    const bool hit = std::any_of(impacts.begin(), impacts.end(),
                                 [&](double impact) { return at >= impact && at < impact + kAfter_s; });
    flags.push_back(hit ? 1 : 0);
  }
  return flags;
}

Column impacts_of(const Table& feet) {
  Column all;
  const Column begin = feet.seconds("begin");
  const auto& phase = feet.text("phase");
  for (std::size_t i = 0; i < begin.size(); ++i)
    if (phase[i] == "put_down") all.push_back(begin[i]);
  return all;
}

}  // namespace

std::optional<ImpactLink> impact_link(const Column& t, const Column& z, const Column& impacts) {
  if (t.size() < 100 || impacts.empty()) return std::nullopt;
  Column change;
  for (std::size_t i = 1; i < z.size(); ++i) change.push_back(std::abs(z[i] - z[i - 1]));
  const Column after = shortly_after({t.begin() + 1, t.end()}, impacts);
  ImpactLink link{correlation(change, after, 0), 0, static_cast<int>(change.size())};
  for (std::size_t shift = 0; shift < change.size(); ++shift)
    if (std::abs(correlation(change, after, shift)) >= std::abs(link.correlation))
      link.p += 1.0 / static_cast<double>(change.size());
  return link;
}

PaperRow impact_row(const std::vector<RunData>& runs) {
  PaperRow row{"Jumps of the estimated height and foot impacts (V-A)", "no link found", "not run", ""};
  int linked = 0, judged = 0;
  double sum = 0;
  for (const RunData& run : runs) {
    if (!run.estimate || !run.feet) continue;
    const auto link = impact_link(run.estimate->t, run.estimate->z, impacts_of(*run.feet));
    if (!link) continue;
    ++judged;
    linked += link->p < 0.05;
    sum += link->correlation;
  }
  if (judged == 0) return row;
  row.bench = fmt::format("correlation {:.2f} (mean); significant at 5 % in {} of {} runs", sum / judged,
                          linked, judged);
  row.verdict = linked * 2 > judged ? "differs" : "agrees";
  return row;
}

}  // namespace sim::report
