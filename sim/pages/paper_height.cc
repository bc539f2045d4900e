#include "sim/pages/paper_height.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/files/number.h"
#include "sim/pages/units.h"
#include "sim/score/significance.h"
#include "sim/score/statistics.h"

namespace sim::pages {
namespace {

constexpr double kAfter_s = 0.1;    // after an impact
constexpr double kLongest_s = 1.2;  // a step; longer is a pause
constexpr double kBin_s = 1.0 / 30;

double correlation(const Column& a, const Column& b) {
  const double mean_a = score::mean(a), mean_b = score::mean(b);
  double ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double da = a[i] - mean_a, db = b[i] - mean_b;
    ab += da * db, aa += da * da, bb += db * db;
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

// |change since the frame before|, from the second frame on.
Column changes(const Column& z) {
  Column out;
  for (std::size_t i = 1; i < z.size(); ++i) out.push_back(std::abs(z[i] - z[i - 1]));
  return out;
}

// The last impact that is not after t, or the end.
Column::const_iterator before(const Column& impacts, double t) {
  const auto after = std::upper_bound(impacts.begin(), impacts.end(), t);
  return after == impacts.begin() ? impacts.end() : std::prev(after);
}

Column shortly_after(const Column& t, const Column& impacts) {
  Column flags;
  for (std::size_t i = 1; i < t.size(); ++i) {
    const auto impact = before(impacts, t[i]);
    flags.push_back(impact != impacts.end() && t[i] < *impact + kAfter_s ? 1 : 0);
  }
  return flags;
}

// Changes of the height in the 0.1 s after the impact of a step, and in the rest of the step.
struct Step {
  Column after, rest;
};

std::vector<Step> steps(const Column& t, const Column& change, const Column& impacts) {
  std::vector<Step> all(impacts.size());
  for (std::size_t i = 1; i < t.size(); ++i) {
    const auto impact = before(impacts, t[i]);
    if (impact == impacts.end() || t[i] > *impact + kLongest_s) continue;
    Step& step = all[static_cast<std::size_t>(impact - impacts.begin())];
    (t[i] < *impact + kAfter_s ? step.after : step.rest).push_back(change[i - 1]);
  }
  std::erase_if(all, [](const Step& step) { return step.after.empty() || step.rest.empty(); });
  return all;
}

// Frames of all runs by the time since the last impact.
struct Bins {
  std::array<double, 24> sum{}, count{};  // of 1/30 s: a step of 0.8 s
  void add(const Column& t, const Column& change, const Column& impacts) {
    for (std::size_t i = 1; i < t.size(); ++i) {
      const auto impact = before(impacts, t[i]);
      if (impact == impacts.end()) continue;
      const auto bin = static_cast<std::size_t>((t[i] - *impact) / kBin_s);
      if (bin >= sum.size()) continue;
      sum[bin] += change[i - 1];
      ++count[bin];
    }
  }
  Line line(const std::string& name, Role role) const {
    Line line{name, role};
    for (std::size_t i = 0; i < sum.size(); ++i) {
      if (count[i] == 0) continue;
      line.x.push_back((static_cast<double>(i) + 0.5) * kBin_s);
      line.y.push_back(kMm * sum[i] / count[i]);
    }
    return line;
  }
};

// The links found in the runs of one filter.
struct Verdicts {
  Column correlations, ratios;
  int linked = 0;
  void add(const std::optional<ImpactLink>& link) {
    if (!link) return;
    correlations.push_back(link->correlation);
    ratios.push_back(link->ratio);
    linked += link->p < 0.05 && link->ratio > 1;
  }
  std::string text() const {
    return fmt::format(
        "correlation {:.2f}, {:.2f} times the rest of the step, significant at 5 % in {} of {}",
        score::mean(correlations), score::mean(ratios), linked, files::counted(correlations.size(), "run"));
  }
};

}  // namespace

std::optional<ImpactLink> impact_link(const Column& t, const Column& z, const Column& impacts) {
  if (t.size() < 100) return std::nullopt;
  const Column change = changes(z);
  const std::vector<Step> all = steps(t, change, impacts);
  if (all.size() < 5) return std::nullopt;
  Column differences, after, rest;
  for (const Step& step : all) {
    after.push_back(score::mean(step.after)), rest.push_back(score::mean(step.rest));
    differences.push_back(after.back() - rest.back());
  }
  return ImpactLink{correlation(change, shortly_after(t, impacts)), score::wilcoxon_signed_rank(differences),
                    score::mean(after) / std::max(1e-12, score::mean(rest))};
}

Column impacts(const RunData& run) {
  Column all;
  if (!run.feet) return all;
  const Column begin = run.feet->seconds("begin");
  const auto& phase = run.feet->text("phase");
  for (std::size_t i = 0; i < begin.size(); ++i)
    if (phase[i] == "put_down") all.push_back(begin[i]);
  std::sort(all.begin(), all.end());
  return all;
}

PaperRow impact_row(const std::vector<RunData>& runs, const std::string& filter) {
  PaperRow row{"Experiment 1, " + filter + ": do changes of the height follow foot impacts? (V-A)",
               "no link found", "not run"};
  Verdicts height, error;
  for (const RunData& run : runs) {
    if (!run.estimate || !run.errors) continue;
    const Column feet = impacts(run);
    height.add(impact_link(run.estimate->t, run.estimate->z, feet));
    error.add(impact_link(run.errors->t, run.errors->z, feet));
  }
  if (!runs.empty()) row.bench = "too few steps to tell";
  if (height.correlations.empty() || error.correlations.empty()) return row;
  row.bench = "estimated height: " + height.text() + "; its error: " + error.text();
  row.agreement = 2 * static_cast<std::size_t>(height.linked) > height.correlations.size()
                      ? Agreement::differs
                      : Agreement::agrees;
  return row;
}

Figure impact_figure(const std::vector<RunData>& runs) {
  Figure f{"figure_8_impacts",
           "Figure 8, continued: change of height by the time since a foot touched the ground",
           "time since a foot touched the ground [s]", "mean |change in a frame| [mm]"};
  Bins truth, estimate, error;
  bool any = false;
  for (const RunData& run : runs) {
    const Column feet = impacts(run);
    if (!run.estimate || !run.errors || feet.empty()) continue;
    any = true;
    truth.add(run.truth.t, changes(run.truth.z), feet);
    estimate.add(run.estimate->t, changes(run.estimate->z), feet);
    error.add(run.errors->t, changes(run.errors->z), feet);
  }
  if (any)
    f.lines = {truth.line("truth", Role::truth), estimate.line("estimate", Role::estimate),
               error.line("error of the estimate", Role::second)};
  return f;
}

}  // namespace sim::pages
