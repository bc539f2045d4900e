#include "sim/score/relative_metrics.h"

#include "sim/score/scored.h"
#include "sim/score/trajectory_score.h"

namespace sim::score {
namespace {

using S = const Scored&;

// In m, or (Relation::angle_rad) in degrees.
Value rmse(const Scored& s, const std::vector<Span>& over, Relation relation) {
  std::vector<double> errors = motion_errors(s.pairs, over, relation);
  if (errors.empty()) return Value::none("the true path has no such spans");
  if (relation == Relation::angle_rad)
    for (double& error : errors) error /= kDegree;
  return root_mean_square(errors);
}

Value over_footsteps(const Scored& s, Relation relation) {
  if (!s.run.planned) return Value::none("the planned footsteps are not known");
  std::vector<Stamp> walked;
  for (const Stamp t : s.run.planned->footsteps)
    if (t >= s.pairs.front().t && t <= s.pairs.back().t) walked.push_back(t);
  return rmse(s, spans_between(s.pairs, walked), relation);
}

void add(MetricDefinitions& all, const std::string& name, const std::string& span,
         const std::function<Value(const Scored&, Relation)>& rmse_over, bool headline = false) {
  const std::string text = "Relative pose error: root mean square ";
  all.push_back({"rpe_" + name + "_m", "m", text + "translation error of the motion " + span, Needs::scale,
                 [rmse_over](S s) { return rmse_over(s, Relation::trans_part); }, Worst::largest, headline});
  all.push_back({"rpe_" + name + "_deg", "deg", text + "rotation error of the motion " + span,
                 Needs::estimate, [rmse_over](S s) { return rmse_over(s, Relation::angle_rad); },
                 Worst::largest, headline});
}

auto over(const Spans& which) {
  return [which](S s, Relation relation) { return rmse(s, spans(s.pairs, which), relation); };
}

}  // namespace

MetricDefinitions relative_metrics() {
  struct Length {
    const char *name, *words;
    double metres;
  };
  MetricDefinitions all;
  for (const auto& [name, words, metres] : {Length{"25cm", "25 cm", 0.25},
                                            {"50cm", "50 cm", 0.5},
                                            {"1m", "1 m", 1},
                                            {"2m", "2 m", 2},
                                            {"4m", "4 m", 4}})
    add(all, name,
        std::string("over ") + words +
            " of the true path, from each frame to the one whose distance is nearest to that, within 10 %.",
        over({Spans::Unit::metres, metres, true, 0.1, true}), metres == 1);
  add(all, "1s", "over 1 s, from each frame.", over({Spans::Unit::seconds, 1, true}));
  add(all, "step", "from one planned landing of a foot to the next.", over_footsteps);
  return all;
}

}  // namespace sim::score
