#include "sim/score/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "sim/score/run.h"

GAITSLAM_EMBED(gaitslam_metrics, GAITSLAM_METRICS)

namespace sim::score {
namespace {

constexpr double kFirstMotion_m = 0.001;

/// Beginnings of the metrics that compare orientations, or poses without alignment.
constexpr std::array kOfPoses{"rmse_m", "rotation_",   "rpe_",  "smoothed_rmse_m", "smoothed_rotation_",
                              "end_",   "drift_",      "nees_", "poses_with",      "landmark_",
                              "plan_",  "true_height_"};

std::optional<Stamp> first_motion(const Run& run) {
  if (run.plan_waist.empty() && !run.truth_camera.empty()) return run.truth_camera.front().t;
  for (const TimedPose& pose : run.plan_waist)
    if ((pose.X.translation() - run.plan_waist.front().X.translation()).norm() > kFirstMotion_m)
      return pose.t;
  return std::nullopt;
}

std::optional<Absent> why_no_estimate(const ScoreContext& c) {
  if (!c.run.estimate) return Absent{"the estimator was not run"};
  if (c.run.failed) return Absent{"the estimator failed: " + *c.run.failed};
  if (c.run.diverged) return Absent{"the estimator diverged: " + *c.run.diverged};
  if (!c.start) return Absent{c.run.plan_waist.empty() ? "the run has no true pose" : "the plan never moves"};
  if (c.run.estimate->empty()) return Absent{"the estimator never tracked"};
  if (c.pairs.empty()) return Absent{"no estimate has the stamp of a true pose"};
  return std::nullopt;
}

OrAbsent<std::vector<PoseNees>> nees_of(const std::vector<PosePair>& pairs, const Run& run) {
  std::vector<PoseNees> all;
  if (pairs.empty()) return all;
  const Similarity S = std::get<Similarity>(align(pairs, run.fitted ? Alignment::origin : Alignment::none));
  Matrix6d J = Matrix6d::Identity();
  J.bottomRightCorner<3, 3>() = S.R;
  auto pose = run.estimate->begin();
  for (const PosePair& pair : transformed(S, pairs)) {
    while (pose->t != pair.t) ++pose;
    if (!pose->covariance) continue;
    const auto nees = pose_nees(pair.X_true, pair.X_estimate, J * *pose->covariance * J.transpose());
    if (!nees) return Absent{"a covariance of the estimate is not positive definite"};
    all.push_back(*nees);
  }
  if (all.empty()) return Absent{"the estimator states no covariance"};
  return all;
}

OrAbsent<std::vector<LoopLandmark>> loop_of(const ScoreContext& c) {
  if (c.no_estimate) return *c.no_estimate;
  if (c.run.no_matches) return Absent{*c.run.no_matches};
  return loop_landmarks(c.run);
}

// "at 3.4 s, 8 % of 43.0 s" if the last moment is not the end of the plan and of the truth.
std::optional<std::string> note_of_end(const MetricDefinition& definition, const ScoreContext& context) {
  const Trajectory &camera = context.run.truth_camera, &waist = context.run.truth_waist;
  const bool of_walk = definition.needs == Needs::walk;
  if (camera.size() < 2 || (of_walk ? waist.empty() : context.pairs.empty())) return std::nullopt;
  const Stamp last = of_walk ? waist.back().t : context.pairs.back().t, interval = camera[1].t - camera[0].t,
              end = std::max(context.run.plan_end.value_or(Stamp(0)), camera.back().t);
  if (last + 2 * interval >= end || last >= end / 100 * 99) return std::nullopt;
  const double last_s = 1e-9 * static_cast<double>(last.count()),
               end_s = 1e-9 * static_cast<double>(end.count());
  return fmt::format("at {:.1f} s, {:.0f} % of {:.1f} s", last_s, 100 * last_s / end_s, end_s);
}

std::optional<std::string> note_of(const MetricDefinition& definition, const ScoreContext& context) {
  if (definition.note == Note::none) return std::nullopt;
  if (definition.note == Note::at_end) return note_of_end(definition, context);
  const std::size_t matched = context.pairs.size(), all = context.truth_camera.size();
  std::string note = matched * 100 < all * 99 ? fmt::format("{} of {} true poses", matched, all) : "";
  if (definition.note == Note::scale) {
    Similarity S = std::get<Similarity>(align(context.pairs, Alignment::sim3));
    std::vector<PosePair> unscaled = context.pairs;
    for (PosePair& pair : unscaled) pair.X_estimate.translation() /= context.run.scaled_by;
    S.scale *= context.run.scaled_by;
    const auto doubt = doubt_of_scale(S, unscaled);
    note += fmt::format("{}scale {:.4g}{}", note.empty() ? "" : ", ", S.scale,
                        doubt ? "; warning: " + *doubt : "");
  }
  return note.empty() ? std::nullopt : std::optional(note);
}

Metric compute(const MetricDefinition& definition, const ScoreContext& context) {
  const auto absent = [&](const std::string& reason) {
    return Metric{std::nullopt, definition.unit, reason};
  };
  const auto starts_name = [&](const char* beginning) { return definition.name.starts_with(beginning); };
  if (!context.run.truth_has_poses && std::ranges::any_of(kOfPoses, starts_name))
    return absent("the truth has positions only: see the errors after alignment, ate_...");
  if (definition.needs == Needs::scale && context.run.no_scale) return absent(*context.run.no_scale);
  if (definition.needs != Needs::walk && context.no_estimate) return absent(context.no_estimate->reason);
  const Value found = definition.compute(context);
  if (const auto* const none = std::get_if<Absent>(&found)) return absent(none->reason);
  const double number = std::get<double>(found);
  if (!std::isfinite(number)) return absent("the value is not finite");
  return {number, definition.unit, "", note_of(definition, context)};
}

// Formulas of the estimate.

using C = const ScoreContext&;
using Numbers = std::vector<double>;
using Pairs = std::vector<PosePair>;

Value ate(const Pairs& pairs, Alignment alignment) {
  return value_of(align(pairs, alignment), [&](const Similarity& S) -> Value {
    return root_mean_square(position_errors(transformed(S, pairs)));
  });
}

auto ate_by(Alignment alignment) {
  return [alignment](C c) { return ate(c.pairs, alignment); };
}

Value odometry_ate(C c) {
  if (c.run.odometry.empty()) return Absent{"odometry without images did not run beside the estimator"};
  return ate(pair_by_stamp(c.truth_camera, c.run.odometry), Alignment::se3);
}

// of(pairs of the true poses with the smoothed ones)
auto of_smoothed(Value (*of)(const Pairs&)) {
  return [of](C c) -> Value {
    if (c.run.smoothed.empty())
      return Absent{
          "nothing was smoothed: only the built-in filter does, with images and with space "
          "for its temporary file"};
    return of(pair_by_stamp(c.truth_camera, c.run.smoothed));
  };
}

Value scale_error(C c) {
  return value_of(align(c.pairs, Alignment::sim3),
                  [](const Similarity& S) -> Value { return 100 * (1 / S.scale - 1); });
}

double end_distance(C c) { return position_errors({c.pairs.back()}).front(); }

Value drift_percent(C c) {
  const double walked = path_length(c.truth_camera);
  if (walked <= 0) return Absent{"the true camera never moves"};
  return 100 * end_distance(c) / walked;
}

// The root mean square over 1 m of the true path of error(difference of the two motions).
auto rpe(double (*error)(const Eigen::Isometry3d&)) {
  return [error](C c) -> Value {
    Numbers errors;
    for (const Span& span : spans(c.pairs, {Spans::Unit::meters, 1, true, 0.1, true}))
      errors.push_back(error(relative_difference(c.pairs, span)));
    if (errors.empty()) return Absent{"the true path has no such spans"};
    return root_mean_square(errors);
  };
}

auto mean_nees(double PoseNees::*part) {
  return [part](C c) {
    return value_of(c.nees, [part](const std::vector<PoseNees>& all) -> Value {
      Numbers squares;
      for (const PoseNees& nees : all) squares.push_back(nees.*part);
      return mean(squares);
    });
  };
}

Value nis(C c, std::size_t sensor) {
  int frames = 0;
  double squares = 0, dof = 0;
  for (const StampedInnovation& innovation : c.run.innovations[sensor]) {
    if (innovation.t < *c.start || innovation.dof <= 0) continue;
    ++frames;
    squares += innovation.square;
    dof += innovation.dof;
  }
  if (frames < 2) return Absent{"the sensor was used in fewer than two frames"};
  return squares / dof;
}

// Bar-Shalom et al. 2001, eq. 5.4.2-8 with lag 1
Value lag1(C c, std::size_t sensor) {
  double products = 0, squares = 0;
  for (const StampedInnovation& innovation : c.run.innovations[sensor]) {
    if (innovation.t < *c.start) continue;
    products += innovation.lagged, squares += innovation.lagged_square;
  }
  if (squares <= 0) return Absent{"no innovations of consecutive frames were reported"};
  return products / squares;
}

// The fraction of the answers from the first planned motion on with readings of a sensor, or, of those with
// readings, with accepted ones.
Value fraction_in_use(C c, std::size_t sensor, bool of_accepted) {
  if (c.run.use.empty()) return Absent{"the estimator does not report which sensors it uses"};
  double all = 0, with_readings = 0, accepted = 0;
  for (const FrameUse& frame : c.run.use) {
    if (frame.t < *c.start) continue;
    ++all, with_readings += frame.readings[sensor], accepted += frame.accepted[sensor];
  }
  if (with_readings == 0 && of_accepted) return Absent{"the filter had no readings of the sensor"};
  return of_accepted ? accepted / with_readings : with_readings / all;
}

Value found_fraction(C c) {
  double searched = 0, found = 0;
  for (const FrameUse& frame : c.run.use)
    if (frame.t >= *c.start)
      searched += static_cast<double>(frame.searched), found += static_cast<double>(frame.found);
  return searched > 0 ? Value(found / searched) : Value(Absent{"the estimator searched for no landmark"});
}

Value landmark_rmse(C c) {
  const Numbers distances = landmark_errors(c.run);
  if (distances.empty()) return Absent{"the final map has no landmark with a known surface point"};
  return root_mean_square(distances);
}

Formulas estimate_formulas() {
  Formulas all{
      {"ate_se3_rmse_m", ate_by(Alignment::se3)},
      {"rmse_m", ate_by(Alignment::none)},
      {"ate_yaw_rmse_m", ate_by(Alignment::yaw_position)},
      {"ate_sim3_rmse_m", ate_by(Alignment::sim3)},
      {"scale_error_percent", scale_error},
      {"odometry_ate_se3_rmse_m", odometry_ate},
      {"smoothed_ate_se3_rmse_m", of_smoothed([](const Pairs& pairs) { return ate(pairs, Alignment::se3); })},
      {"smoothed_rmse_m", of_smoothed([](const Pairs& pairs) { return ate(pairs, Alignment::none); })},
      {"smoothed_rotation_rmse_deg", of_smoothed([](const Pairs& pairs) -> Value {
         return root_mean_square(orientation_errors(pairs)) / kDegree;
       })},
      {"poses_matched", [](C c) { return static_cast<double>(c.pairs.size()); }},
      {"true_poses",
       [](C c) -> Value {
         if (c.truth_camera.empty()) return Absent{"the plan never moves"};
         return static_cast<double>(c.truth_camera.size());
       }},
      {"rotation_rmse_deg", [](C c) { return root_mean_square(orientation_errors(c.pairs)) / kDegree; }},
      {"rpe_1m_m", rpe([](const Eigen::Isometry3d& E) { return E.translation().norm(); })},
      {"rpe_1m_deg",
       rpe([](const Eigen::Isometry3d& E) { return rotation_vector(E.linear()).norm() / kDegree; })},
      {"end_position_error_m", end_distance},
      {"drift_percent", drift_percent},
      {"end_yaw_error_deg", [](C c) { return std::abs(yaw_error(c.pairs.back())) / kDegree; }},
      {"poses_with_covariance",
       [](C c) {
         return value_of(c.nees, [](const std::vector<PoseNees>& nees) -> Value {
           return static_cast<double>(nees.size());
         });
       }},
      {"nees_position_mean", mean_nees(&PoseNees::position)},
      {"nees_orientation_mean", mean_nees(&PoseNees::orientation)},
      {"found_landmarks_fraction", found_fraction},
      {"landmark_rmse_m", landmark_rmse}};
  for (std::size_t i = 0; i < kUsedSensors.size(); ++i) {
    const auto add = [&](const char* name, const auto& of) {
      all[fmt::format(fmt::runtime(name), kUsedSensors[i])] = of;
    };
    if (i < kSensors.size()) add("nis_{}_mean", [i](C c) { return nis(c, i); });
    if (i < kSensors.size()) add("innovation_lag1_{}", [i](C c) { return lag1(c, i); });
    add("readings_{}_fraction", [i](C c) { return fraction_in_use(c, i, false); });
    add("accepted_{}_fraction", [i](C c) { return fraction_in_use(c, i, true); });
  }
  return all;
}

// The value of an enumeration, by the names of its values.
template <typename T>
T named(std::initializer_list<std::string_view> names, const std::string& word) {
  const auto* const found = std::ranges::find(names, word);
  if (found == names.end()) throw std::logic_error("metrics.txt: unknown word " + word);
  return static_cast<T>(found - names.begin());
}

void read_block(const std::string& block, MetricDefinitions& all) {
  for (const std::string& line : files::lines_of(block)) {
    if (line.starts_with('#')) continue;
    if (line.starts_with(' ')) {
      std::string& text = all.back().definition;
      text += line.substr(text.empty() ? 2 : 1);
      continue;
    }
    MetricDefinition& d = all.emplace_back();
    std::string needs, worst, headline, note;
    std::istringstream(line) >> d.name >> d.unit >> needs >> worst >> headline >> note;
    d.needs = named<Needs>({"walk", "estimate", "scale"}, needs);
    const auto expected = files::parse_number<double>(worst);
    d.direction = expected ? Direction::away_from(*expected)
                           : named<Worst>({"largest", "smallest", "magnitude"}, worst);
    d.headline = headline == "headline";
    d.note = named<Note>({"-", "at_end", "coverage", "scale"}, note);
  }
}

// The table of metrics.txt, with blocks for sensors that may not have all its metrics.
MetricDefinitions read_table() {
  MetricDefinitions all;
  for (std::string_view rest = gaitslam_metrics(); !rest.empty();) {
    const std::string_view block = rest.substr(0, rest.find("\n\n"));
    rest.remove_prefix(std::min(block.size() + 2, rest.size()));
    for (const std::string_view sensor : kUsedSensors) {
      read_block(fmt::format(fmt::runtime(block), fmt::arg("sensor", sensor),
                             fmt::arg("landmarks", kLandmarksOfLoop)),
                 all);
      if (block.find("{sensor}") == block.npos) break;
    }
  }
  return all;
}

}  // namespace

ScoreContext::ScoreContext(const Run& run_) : run(run_), start(first_motion(run_)) {
  if (start)
    for (const TimedPose& pose : run.truth_camera)
      if (pose.t >= *start) truth_camera.push_back(pose);
  if (start && run.estimate)
    for (const files::TumRow& pose : *run.estimate)
      if (pose.t >= *start) estimate.push_back(pose);
  pairs = pair_by_stamp(truth_camera, estimate);
  nees = nees_of(pairs, run);
  no_estimate = why_no_estimate(*this);
  loop = loop_of(*this);
}

const MetricDefinitions& metric_definitions() {
  static const MetricDefinitions definitions = [] {
    Formulas formulas = estimate_formulas();
    formulas.merge(walk_formulas());
    MetricDefinitions all = read_table();
    for (MetricDefinition& d : all)
      if (auto formula = formulas.extract(d.name)) d.compute = std::move(formula.mapped());
    if (!formulas.empty()) throw std::logic_error("metrics.txt lacks " + formulas.begin()->first);
    std::erase_if(all, [](const MetricDefinition& d) { return !d.compute; });
    return all;
  }();
  return definitions;
}

const MetricDefinition* find_metric(std::string_view name) {
  const auto& all = metric_definitions();
  const auto found = std::ranges::find(all, name, &MetricDefinition::name);
  return found == all.end() ? nullptr : &*found;
}

Direction direction_of(std::string_view name) {
  const MetricDefinition* defined = find_metric(name);
  return defined ? defined->direction : Direction();
}

Metrics evaluate(const Run& run) { return evaluate(ScoreContext(run)); }

Metrics evaluate(const ScoreContext& context) {
  Metrics metrics;
  for (const MetricDefinition& defined : metric_definitions())
    metrics.emplace(defined.name, compute(defined, context));
  return metrics;
}

}  // namespace sim::score
