#include <cmath>

#include "sim/score/metrics.h"
#include "sim/score/run.h"

namespace sim::score {
namespace {

using C = const ScoreContext&;
using enum Worst;

// A pose is correct within this distance and angle.
constexpr double kCorrect_m = 0.1, kCorrect_rad = 3 * kDegree;
constexpr double kRelocalization_s = 60;  // time constant of the score by Shi et al. 2020 (OpenLORIS-Scene)

bool is_correct(const PosePair& pair) {
  return position_errors({pair}).front() < kCorrect_m && orientation_errors({pair}).front() < kCorrect_rad;
}

/// All estimated poses with a true one, also before the first planned motion.
std::vector<PosePair> poses(C c) {
  Trajectory estimate;
  if (c.run.estimate) estimate.assign(c.run.estimate->begin(), c.run.estimate->end());
  return pair_by_stamp(c.run.truth_camera, estimate);
}

/// A metric of a run with a loaded map.
MetricDefinition map_metric(const std::string& name, const std::string& unit, const std::string& definition,
                            Value (*of)(C, const LoadedMap&), Direction direction) {
  return {name,
          unit,
          definition,
          Needs::walk,
          [of](C c) -> Value {
            if (!c.run.loaded_map) return Absent{"no map of an earlier session was loaded"};
            return of(c, *c.run.loaded_map);
          },
          direction};
}

Value time_to_localize(C c, const LoadedMap& map) {
  const std::vector<PosePair> all = poses(c);
  if (map.refused || all.empty()) return Absent{"the estimator did not localize in the map"};
  return 1e-9 * double((all.front().t - c.run.truth_camera.front().t).count());
}

Value first_pose_correct(C c, const LoadedMap& map) {
  const std::vector<PosePair> all = poses(c);
  if (map.refused || all.empty()) return Absent{"the estimator did not localize in the map"};
  return double(is_correct(all.front()));
}

Value false_localizations(C c, const LoadedMap&) {
  int count = 0;
  bool tracks = false;
  const std::vector<PosePair> all = poses(c);
  for (const TimedHealth& health : c.run.health) {
    const auto pair = std::ranges::lower_bound(all, health.t, {}, &PosePair::t);
    if (health.tracks && !tracks && pair != all.end() && pair->t == health.t && !is_correct(*pair)) ++count;
    tracks = health.tracks;
  }
  return double(count);
}

Value fraction(C c, bool correct) {
  const std::vector<PosePair> all = poses(c);
  if (c.run.truth_camera.empty()) return Absent{"the run has no true pose"};
  return double(std::ranges::count(all, correct, is_correct)) / double(c.run.truth_camera.size());
}

}  // namespace

MetricDefinitions map_metrics() {
  const std::string correct = " (within 0.1 m and 3 degrees of the truth, in the map's frame)";
  return {
      map_metric("time_to_localize_s", "s", "Time from the first frame to the first pose in the loaded map.",
                 time_to_localize, largest),
      map_metric("first_pose_correct", "1",
                 "1 if the first pose in the loaded map is correct" + correct + ".", first_pose_correct,
                 smallest),
      map_metric("false_localizations", "1",
                 "How often tracking began or resumed with a pose that is not correct" + correct + ".",
                 false_localizations, largest),
      map_metric(
          "wrong_fraction", "1",
          "Fraction of the true poses with an estimate that is not correct" + correct + ".",
          [](C c, const LoadedMap&) { return fraction(c, false); }, largest),
      map_metric(
          "correct_fraction", "1", "Fraction of the true poses with a correct estimate" + correct + ".",
          [](C c, const LoadedMap&) { return fraction(c, true); }, smallest),
      map_metric(
          "reloc_score", "1",
          "exp(-time_to_localize_s / 60 s), or 0 if the first pose is not correct or missing.",
          [](C c, const LoadedMap& map) -> Value {
            const Value first = first_pose_correct(c, map);
            if (std::holds_alternative<Absent>(first) || std::get<double>(first) == 0) return 0.0;
            return std::exp(-std::get<double>(time_to_localize(c, map)) / kRelocalization_s);
          },
          smallest),
      map_metric(
          "rmse_in_map_m", "m",
          "rmse_m of the poses in the loaded map, also before the first planned motion.",
          [](C c, const LoadedMap& map) -> Value {
            const std::vector<PosePair> all = poses(c);
            if (map.refused || all.empty()) return Absent{"the estimator did not localize in the map"};
            return root_mean_square(position_errors(all));
          },
          largest),
      map_metric(
          "map_reused_fraction", "1",
          "Fraction of the accepted matches that are landmarks of the loaded map.",
          [](C, const LoadedMap& map) -> Value {
            if (map.matches == 0) return Absent{"no match was accepted"};
            return double(map.reused) / double(map.matches);
          },
          smallest),
      map_metric(
          "refused_wrong_map", "1", "1 if the loaded map was not recognized, so that a new one was started.",
          [](C, const LoadedMap& map) -> Value { return double(map.refused); }, largest),
      {"memory_bytes", "1", "Size of the saved map, map.bin.", Needs::walk,
       [](C c) -> Value {
         if (!c.run.map_bytes) return Absent{"no map was saved"};
         return double(*c.run.map_bytes);
       },
       largest}};
}

}  // namespace sim::score
