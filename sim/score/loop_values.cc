#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/score/errors.h"
#include "sim/score/metric_values.h"

namespace sim::score {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// The frame before the first in which a landmark closed the loop, and the last not later than 1 s after that.
struct Event {
  Stamp found{0};
  const PosePair *before = nullptr, *after = nullptr;
};

const PosePair* last_until(const Scored& s, Stamp t) {
  const auto last =
      std::find_if(s.pairs.rbegin(), s.pairs.rend(), [t](const PosePair& pair) { return pair.t <= t; });
  return last == s.pairs.rend() ? nullptr : &*last;
}

// value(event), if there is one.
template <typename F>
Value of_closure(const Scored& s, F value) {
  if (!s.no_loop.empty()) return Value::none(s.no_loop);
  if (s.loop.empty()) return Value::none("no landmark closed the loop");
  const auto earlier = [](const LoopLandmark& a, const LoopLandmark& b) { return a.found < b.found; };
  const Stamp found = std::min_element(s.loop.begin(), s.loop.end(), earlier)->found;
  const Event event{found, last_until(s, found - Stamp(1)), last_until(s, found + std::chrono::seconds(1))};
  if (!event.before || !event.after) return Value::none("no estimate before the closure");
  return value(event);
}

const Matrix6d& covariance(const Scored& s, Stamp t) {
  return std::find_if(s.run.estimate->begin(), s.run.estimate->end(),
                      [t](const EstimatedPose& pose) { return pose.t == t; })
      ->covariance;
}

double sigma(const Scored& s, const PosePair& at) {
  return std::sqrt(covariance(s, at.t).bottomRightCorner<3, 3>().trace());
}

RelativeError correction(const Event& event) {
  return relative_errors({*event.before, *event.after}, {{0, 1}}).front();
}

}  // namespace

Value loop_landmark_count(const Scored& s) {
  if (!s.no_loop.empty()) return Value::none(s.no_loop);
  return static_cast<double>(s.loop.size());
}

Value loop_closed(const Scored& s) {
  if (!s.no_loop.empty()) return Value::none(s.no_loop);
  return s.loop.size() >= 3 ? 1 : 0;
}

Value loop_time(const Scored& s) {
  return of_closure(s, [](const Event& e) -> Value { return static_cast<double>(e.found.count()) * 1e-9; });
}

Value loop_error_before(const Scored& s) {
  return of_closure(s, [](const Event& e) -> Value { return position_errors({*e.before}).front(); });
}
Value loop_error_after(const Scored& s) {
  return of_closure(s, [](const Event& e) -> Value { return position_errors({*e.after}).front(); });
}

Value loop_sigma_before(const Scored& s) {
  return of_closure(s, [&](const Event& e) -> Value { return sigma(s, *e.before); });
}
Value loop_sigma_after(const Scored& s) {
  return of_closure(s, [&](const Event& e) -> Value { return sigma(s, *e.after); });
}

Value loop_logdet_drop(const Scored& s) {
  return of_closure(s, [&](const Event& e) -> Value {
    return std::log(covariance(s, e.before->t).determinant() / covariance(s, e.after->t).determinant());
  });
}

Value loop_correction(const Scored& s) {
  return of_closure(s, [](const Event& e) -> Value { return correction(e).translation; });
}
Value loop_correction_turn(const Scored& s) {
  return of_closure(s, [](const Event& e) -> Value { return correction(e).rotation / kDegree; });
}

}  // namespace sim::score
