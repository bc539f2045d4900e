#include "sim/score/loop_metrics.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "sim/score/errors.h"
#include "sim/score/scored.h"
#include "sim/score/trajectory_score.h"

namespace sim::score {
namespace {

using enum Worst;
using S = const Scored&;

// When an early landmark was first found again, the frame before that, and the last one not later than 1 s after.
struct Closure {
  Stamp found{0};
  PosePair before, after;
};
using C = const Closure&;

const PosePair* last_until(const Scored& s, Stamp t) {
  const auto last =
      std::find_if(s.pairs.rbegin(), s.pairs.rend(), [t](const PosePair& pair) { return pair.t <= t; });
  return last == s.pairs.rend() ? nullptr : &*last;
}

Value landmark_count(const Scored& s) {
  if (!s.no_loop.empty()) return Value::none(s.no_loop);
  return static_cast<double>(
      std::count_if(s.loop.begin(), s.loop.end(), [](const LoopLandmark& landmark) { return landmark.closes; }));
}

Value is_closed(const Scored& s) {
  const Value count = landmark_count(s);
  return count.value ? Value(*count.value >= 3 ? 1 : 0) : count;
}

// of(the closure), if there is one.
template <typename F>
Value of_closure(const Scored& s, F of) {
  if (!s.no_loop.empty()) return Value::none(s.no_loop);
  if (s.loop.empty()) return Value::none("no early landmark was found again");
  const auto earlier = [](const LoopLandmark& a, const LoopLandmark& b) { return a.found < b.found; };
  const Stamp found = std::min_element(s.loop.begin(), s.loop.end(), earlier)->found;
  const PosePair *before = last_until(s, found - Stamp(1)),
                 *after = last_until(s, found + std::chrono::seconds(1));
  if (!before || !after) return Value::none("no estimate before the closure");
  return of(Closure{found, *before, *after});
}

// The filter's, which always states one: no other estimator reports the landmarks that make a closure.
const Matrix6d& covariance(const Scored& s, const PosePair& at) {
  return std::find_if(s.run.estimate->begin(), s.run.estimate->end(),
                      [&](const EstimatedPose& pose) { return pose.t == at.t; })
      ->covariance.value();
}

double sigma(const Scored& s, const PosePair& at) {
  return std::sqrt(covariance(s, at).bottomRightCorner<3, 3>().trace());
}

double log_determinant_drop(const Scored& s, const Closure& closure) {
  return std::log(covariance(s, closure.before).determinant() / covariance(s, closure.after).determinant());
}

double error(const PosePair& at) { return position_errors({at}).front(); }

double correction(const Closure& closure, Relation relation) {
  return motion_errors({closure.before, closure.after}, {{0, 1}}, relation).front();
}

}  // namespace

MetricDefinitions loop_metrics() {
  const std::string before = " in the frame before loop_time_s",
                    after = " 1 s after loop_time_s, or at the last frame if that is earlier",
                    position_error = "Error of the camera's position, without alignment,",
                    position_sigma =
                        "Standard deviation of the camera's position by the filter, the root of the trace of "
                        "its covariance,",
                    corrected =
                        " of the correction: the difference between the estimated and the true motion from "
                        "the frame before loop_time_s to 1 s after it.";
  return {
      {"loop_landmarks", "1",
       "Number of landmarks that close the loop: begun before the plan has turned a quarter of its total "
       "turn; their surface point by truth out of the field of view for at least 5 s in one stretch; and "
       "after three quarters of the turn a match accepted within 3 px of where truth puts that surface "
       "point. Defined for plans that turn by at least 350 degrees.",
       Needs::estimate, landmark_count, smallest, kHeadline},
      {"loop_closed", "1", "1 if loop_landmarks is at least 3, else 0.", Needs::estimate, is_closed, smallest,
       kHeadline},
      {"loop_time_s", "s", "When an early landmark was first found again, wherever on the path: begun before the plan has turned a quarter of "
       "its total turn, out of the field of view for at least 5 s in one stretch, and matched within 3 px of where truth "
       "puts it.", Needs::estimate,
       [](S s) { return of_closure(s, [](C c) { return static_cast<double>(c.found.count()) * 1e-9; }); },
       largest, kHeadline},
      {"loop_error_before_m", "m", position_error + before + ".", Needs::scale,
       [](S s) { return of_closure(s, [](C c) { return error(c.before); }); }, largest, kHeadline},
      {"loop_error_after_m", "m", position_error + after + ".", Needs::scale,
       [](S s) { return of_closure(s, [](C c) { return error(c.after); }); }, largest, kHeadline},
      {"loop_sigma_before_m", "m", position_sigma + before + ".", Needs::scale,
       [](S s) { return of_closure(s, [&](C c) { return sigma(s, c.before); }); }},
      {"loop_sigma_after_m", "m", position_sigma + after + ".", Needs::scale,
       [](S s) { return of_closure(s, [&](C c) { return sigma(s, c.after); }); }},
      {"loop_logdet_drop", "1",
       "Log determinant of the pose's 6x6 covariance before the closure (see loop_error_before_m) minus that "
       "after it: twice the information, in nats, that the closure gave the filter.",
       Needs::estimate, [](S s) { return of_closure(s, [&](C c) { return log_determinant_drop(s, c); }); },
       smallest},
      {"loop_correction_m", "m", "Translation" + corrected, Needs::scale,
       [](S s) { return of_closure(s, [](C c) { return correction(c, Relation::trans_part); }); }},
      {"loop_correction_deg", "deg", "Rotation" + corrected, Needs::estimate,
       [](S s) { return of_closure(s, [](C c) { return correction(c, Relation::angle_rad) / kDegree; }); }}};
}

}  // namespace sim::score
