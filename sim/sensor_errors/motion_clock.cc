#include "sim/sensor_errors/motion_clock.h"

#include <utility>

namespace sim::sensor_errors {
namespace {

using slam::InertialSample, slam::Observation, slam::PlannedMotion, slam::Stamp;

void append_shifted(std::deque<InertialSample>& queue, std::vector<InertialSample>& readings, Stamp offset) {
  for (const InertialSample& reading : std::exchange(readings, {}))
    queue.push_back({reading.begin + offset, reading.end + offset, reading.value});
}

std::vector<InertialSample> taken_until(Stamp t, std::deque<InertialSample>& queue) {
  std::vector<InertialSample> readings;
  for (; !queue.empty() && queue.front().end <= t; queue.pop_front()) readings.push_back(queue.front());
  if (!queue.empty() && queue.front().begin < t) {
    readings.push_back({queue.front().begin, t, queue.front().value});
    queue.front().begin = t;
  }
  return readings;
}

Eigen::Isometry3d interpolate(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double part) {
  Eigen::Isometry3d X = a;
  const Eigen::Quaterniond q(a.linear());
  X.linear() = q.slerp(part, Eigen::Quaterniond(b.linear())).normalized().toRotationMatrix();
  X.translation() = (1 - part) * a.translation() + part * b.translation();
  return X;
}

PlannedMotion interpolate(const PlannedMotion& a, const PlannedMotion& b, double part) {
  PlannedMotion plan = part < 0.5 ? a : b;
  plan.X_PC = interpolate(a.X_PC, b.X_PC, part);
  plan.v_PC_C = (1 - part) * a.v_PC_C + part * b.v_PC_C;
  plan.w_PC_C = (1 - part) * a.w_PC_C + part * b.w_PC_C;
  plan.legs.reset();
  if (a.legs && b.legs)
    plan.legs = slam::LegMotion{interpolate(a.legs->X_OC, b.legs->X_OC, part),
                                (1 - part) * a.legs->p_CS + part * b.legs->p_CS};
  return plan;
}

}  // namespace

std::vector<Observation> MotionClock::process(Observation observation) {
  append_shifted(gyro_, observation.gyro, offset_);
  append_shifted(accelerometer_, observation.accelerometer, offset_);
  const Stamp known = observation.t + offset_;
  plans_.push_back({known, std::exchange(observation.plan, {})});
  waiting_.push_back(std::move(observation));
  std::vector<Observation> complete;
  while (!waiting_.empty() && waiting_.front().t <= known) complete.push_back(assembled());
  return complete;
}

std::vector<Observation> MotionClock::flush() {
  std::vector<Observation> incomplete;
  while (!waiting_.empty()) incomplete.push_back(assembled());
  return incomplete;
}

Observation MotionClock::assembled() {
  Observation frame = std::move(waiting_.front());
  waiting_.pop_front();
  frame.gyro = taken_until(frame.t, gyro_);
  frame.accelerometer = taken_until(frame.t, accelerometer_);
  frame.plan = plan_at(frame.t);
  return frame;
}

// Frames come in order of time: earlier plans are not needed again.
std::optional<PlannedMotion> MotionClock::plan_at(Stamp t) {
  while (plans_.size() > 1 && plans_[1].t <= t) plans_.pop_front();
  if (plans_.empty() || plans_[0].t > t) return std::nullopt;
  if (plans_[0].t == t) return plans_[0].plan;
  if (plans_.size() < 2 || !plans_[0].plan || !plans_[1].plan) return std::nullopt;
  return interpolate(*plans_[0].plan, *plans_[1].plan,
                     slam::seconds(t - plans_[0].t) / slam::seconds(plans_[1].t - plans_[0].t));
}

}  // namespace sim::sensor_errors
