#include <algorithm>

#include "sim/score/metrics.h"
#include "sim/score/score_context.h"

namespace sim::score {
namespace {

using enum Worst;
using C = const ScoreContext&;

// The time of the first early landmark that was found again, and the last poses before it and until 1 s
// after it.
struct Closure {
  Stamp found{0};
  PosePair before, after;
};

// of(the early landmarks that were found again)
template <typename F>
Value of_loop(C c, F of) {
  if (const auto* absent = std::get_if<Absent>(&c.loop)) return *absent;
  return of(std::get<std::vector<LoopLandmark>>(c.loop));
}

Value landmark_count(C c) {
  return of_loop(c, [](const auto& loop) {
    return static_cast<double>(
        std::count_if(loop.begin(), loop.end(), [](const auto& l) { return l.closes; }));
  });
}

Value is_closed(C c) {
  Value count = landmark_count(c);
  if (double* const number = std::get_if<double>(&count)) *number = *number >= 3 ? 1 : 0;
  return count;
}

const PosePair* last_until(C c, Stamp t) {
  const auto last =
      std::find_if(c.pairs.rbegin(), c.pairs.rend(), [t](const PosePair& pair) { return pair.t <= t; });
  return last == c.pairs.rend() ? nullptr : &*last;
}

template <typename F>
Value of_closure(C c, F of) {
  return of_loop(c, [&](const std::vector<LoopLandmark>& loop) -> Value {
    if (loop.empty()) return Absent{"no early landmark was found again"};
    const auto is_earlier = [](const LoopLandmark& a, const LoopLandmark& b) { return a.found < b.found; };
    const Stamp found = std::min_element(loop.begin(), loop.end(), is_earlier)->found;
    const PosePair *before = last_until(c, found - Stamp(1)),
                   *after = last_until(c, found + std::chrono::seconds(1));
    if (!before || !after) return Absent{"no estimate before the closure"};
    return of(Closure{found, *before, *after});
  });
}

double error(const PosePair& at) { return position_errors({at}).front(); }

}  // namespace

MetricDefinitions loop_metrics() {
  const std::string early =
                        "first seen before the plan has turned a quarter of its total turn, then out of the "
                        "field of view for at least 5 s in one stretch",
                    position_error = "Error of the camera's position, without alignment, ";
  return {{"loop_landmarks", "1",
           "Number of landmarks that close the loop: " + early +
               ", and matched again after three quarters of the turn, within 3 px of the true projection of "
               "their "
               "surface point. Defined for plans that turn by at least 350 degrees.",
           Needs::estimate, landmark_count, smallest, kHeadline},
          {"loop_closed", "1", "1 if loop_landmarks is at least 3, else 0.", Needs::estimate, is_closed,
           smallest, kHeadline},
          {"loop_time_s", "s",
           "Time of the first early landmark that was found again, anywhere on the path: " + early +
               ", and matched within 3 px of its true projection.",
           Needs::estimate,
           [](C c) {
             return of_closure(
                 c, [](const Closure& at) { return static_cast<double>(at.found.count()) * 1e-9; });
           },
           largest, kHeadline},
          {"loop_error_before_m", "m", position_error + "in the frame before loop_time_s.", Needs::scale,
           [](C c) { return of_closure(c, [](const Closure& at) { return error(at.before); }); }, largest,
           kHeadline},
          {"loop_error_after_m", "m",
           position_error + "1 s after loop_time_s, or at the last frame if that is earlier.", Needs::scale,
           [](C c) { return of_closure(c, [](const Closure& at) { return error(at.after); }); }, largest,
           kHeadline}};
}

}  // namespace sim::score
