#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "sim/files/text.h"
#include "sim/pages/paper.h"
#include "sim/score/statistics.h"

namespace sim::pages {
namespace {

constexpr double kAfter_s = 0.1;    // after an impact
constexpr double kLongest_s = 1.2;  // a step; longer is a pause

// |Change of the height in a frame| in the 0.1 s after the impact of a step, and in the rest of the step.
struct Step {
  Column after, rest;
};

std::vector<Step> steps(const Column& t, const Column& z, const Column& impacts) {
  std::vector<Step> all(impacts.size());
  for (std::size_t i = 1; i < t.size(); ++i) {
    const auto later = std::upper_bound(impacts.begin(), impacts.end(), t[i]);
    if (later == impacts.begin() || t[i] > *std::prev(later) + kLongest_s) continue;
    Step& step = all[static_cast<std::size_t>(later - impacts.begin() - 1)];
    (t[i] < *std::prev(later) + kAfter_s ? step.after : step.rest).push_back(std::abs(z[i] - z[i - 1]));
  }
  std::erase_if(all, [](const Step& step) { return step.after.empty() || step.rest.empty(); });
  return all;
}

// The links found in the runs of one filter.
struct Links {
  Column ratios;
  std::size_t linked = 0;

  void add(const std::optional<ImpactLink>& link) {
    if (!link) return;
    ratios.push_back(link->ratio);
    linked += link->p < 0.05 && link->ratio > 1 ? 1 : 0;
  }
  std::string text() const {
    return fmt::format("{:.2f} times the rest of the step, significant at 5 % in {} of {}",
                       score::mean(ratios), linked, files::counted(ratios.size(), "run"));
  }
};

// Times of foot impacts (s, rising).
Column impacts_of(const RunData& run) {
  Column all;
  if (!run.feet) return all;
  const Column begin = run.feet->seconds("begin");
  for (std::size_t i = 0; i < begin.size(); ++i)
    if (run.feet->text("phase")[i] == "put_down") all.push_back(begin[i]);
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace

std::optional<ImpactLink> impact_link(const Column& t, const Column& z, const Column& impacts) {
  if (t.size() < 100) return std::nullopt;
  const std::vector<Step> all = steps(t, z, impacts);
  if (all.size() < 5) return std::nullopt;
  Column differences, after, rest;
  for (const Step& step : all) {
    after.push_back(score::mean(step.after)), rest.push_back(score::mean(step.rest));
    differences.push_back(after.back() - rest.back());
  }
  return ImpactLink{score::wilcoxon_signed_rank(differences),
                    score::mean(after) / std::max(1e-12, score::mean(rest))};
}

PaperRow impact_row(const std::vector<RunData>& runs, const std::string& filter) {
  PaperRow row{"Experiment 1, " + filter + ": do changes of the height follow foot impacts? (V-A)",
               "no link found", runs.empty() ? "not run" : "too few steps to tell"};
  Links height, error;
  for (const RunData& run : runs) {
    if (!run.estimate || !run.errors) continue;
    const Column impacts = impacts_of(run);
    height.add(impact_link(run.estimate->t, run.estimate->z, impacts));
    error.add(impact_link(run.errors->t, run.errors->z, impacts));
  }
  if (height.ratios.empty() || error.ratios.empty()) return row;
  row.bench = "estimated height: " + height.text() + "; its error: " + error.text();
  row.agreement = 2 * height.linked > height.ratios.size() ? Agreement::differs : Agreement::agrees;
  return row;
}

}  // namespace sim::pages
