#include <algorithm>

#include "sim/score/metrics.h"
#include "sim/score/run.h"

namespace sim::score {
namespace {

using enum Worst;
using C = const ScoreContext&;
using Loop = std::vector<LoopLandmark>;

Value landmark_count(C c) {
  return value_of(c.loop, [](const Loop& loop) -> Value {
    const auto closes = [](const LoopLandmark& landmark) { return landmark.closes; };
    return static_cast<double>(std::count_if(loop.begin(), loop.end(), closes));
  });
}

Value is_closed(C c) {
  return value_of(landmark_count(c), [](double count) -> Value { return count >= 3 ? 1.0 : 0.0; });
}

const PosePair* last_until(C c, Stamp t) {
  const auto last =
      std::find_if(c.pairs.rbegin(), c.pairs.rend(), [t](const PosePair& pair) { return pair.t <= t; });
  return last == c.pairs.rend() ? nullptr : &*last;
}

// The first early landmark that was found again, and the errors (m) of the last positions before it and until
// 1 s after it.
struct Closure {
  double time_s = 0, error_before = 0, error_after = 0;
};

OrAbsent<Closure> closure(C c) {
  if (const auto* absent = std::get_if<Absent>(&c.loop)) return *absent;
  const Loop& loop = std::get<Loop>(c.loop);
  if (loop.empty()) return Absent{"no early landmark was found again"};
  const auto is_earlier = [](const LoopLandmark& a, const LoopLandmark& b) { return a.found < b.found; };
  const Stamp found = std::min_element(loop.begin(), loop.end(), is_earlier)->found;
  const PosePair *before = last_until(c, found - Stamp(1)),
                 *after = last_until(c, found + std::chrono::seconds(1));
  if (!before || !after) return Absent{"no estimate before the closure"};
  return Closure{static_cast<double>(found.count()) * 1e-9, position_errors({*before}).front(),
                 position_errors({*after}).front()};
}

auto of_closure(double Closure::*part) {
  return [part](C c) {
    return value_of(closure(c), [part](const Closure& found) -> Value { return found.*part; });
  };
}

}  // namespace

MetricDefinitions loop_metrics() {
  const std::string early =
                        "first seen before the plan has turned a quarter of its total turn, then out of the "
                        "field of view for at least 5 s in one stretch",
                    position_error = "Error of the camera's position, without alignment, ";
  return {{"loop_landmarks", "1",
           "Number of landmarks that close the loop: " + early +
               ", and matched again after three quarters of the turn, within 3 px of the true projection of "
               "their surface point. Defined for plans that turn by at least 350 degrees.",
           Needs::estimate, landmark_count, smallest, kHeadline},
          {"loop_closed", "1", "1 if loop_landmarks is at least 3, else 0.", Needs::estimate, is_closed,
           smallest, kHeadline},
          {"loop_time_s", "s",
           "Time of the first early landmark that was found again, anywhere on the path: " + early +
               ", and matched within 3 px of its true projection.",
           Needs::estimate, of_closure(&Closure::time_s), largest, kHeadline},
          {"loop_error_before_m", "m", position_error + "in the frame before loop_time_s.", Needs::scale,
           of_closure(&Closure::error_before), largest, kHeadline},
          {"loop_error_after_m", "m",
           position_error + "1 s after loop_time_s, or at the last frame if that is earlier.", Needs::scale,
           of_closure(&Closure::error_after), largest, kHeadline}};
}

}  // namespace sim::score
