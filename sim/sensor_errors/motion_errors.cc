#include "sim/sensor_errors/motion_errors.h"

#include <algorithm>
#include <utility>

#include "sim/sensor_errors/random.h"

namespace sim::sensor_errors {
namespace {

using slam::InertialSample, slam::Observation, slam::PlannedMotion, slam::Stamp;

Eigen::Vector3d normal3(Random random) {
  Eigen::Vector3d v;
  for (double& x : v) x = random.normal();
  return v;
}

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

InertialErrors::InertialErrors(std::string sensor, const InertialErrorSizes& sizes, std::uint64_t seed,
                               std::vector<Spike> spikes, std::vector<Span> silences)
    : sensor_(std::move(sensor)),
      sizes_(sizes),
      seed_(seed),
      spikes_(std::move(spikes)),
      silences_(std::move(silences)),
      bias_(sizes.bias_sigma * normal3(Random(seed, sensor_ + " bias"))) {}

void InertialErrors::apply(std::vector<InertialSample>& readings) {
  for (InertialSample& reading : readings) reading.value = disturbed(reading);
  std::erase_if(readings, [this](const InertialSample& reading) {
    return std::any_of(silences_.begin(), silences_.end(), [&](const Span& s) { return s.touches(reading); });
  });
}

// A reading split by a frame is a mean over less than 5 ms. Its noise is scaled up, so that the integral over
// the whole 5 ms has the variance of an unsplit reading.
Eigen::Vector3d InertialErrors::disturbed(const InertialSample& reading) {
  const auto item = static_cast<std::uint64_t>(reading.end.count());
  const double duration_s = slam::seconds(reading.end - reading.begin);
  if (sizes_.bias_walk_sigma > 0)
    bias_ +=
        sizes_.bias_walk_sigma * std::sqrt(duration_s) * normal3(Random(seed_, sensor_ + " bias walk", item));
  const double sigma = sizes_.sigma * std::sqrt(slam::kReadingPeriod_s / duration_s);
  Eigen::Vector3d value = reading.value + sigma * normal3(Random(seed_, sensor_ + " noise", item)) + bias_;
  for (const Spike& spike : spikes_)
    if (spike.span.touches(reading)) value.array() += spike.size;
  if (sizes_.range > 0) value = value.cwiseMin(sizes_.range).cwiseMax(-sizes_.range);
  if (sizes_.resolution > 0) value = (value / sizes_.resolution).array().round().matrix() * sizes_.resolution;
  return value;
}

void LegErrors::apply(slam::LegMotion& legs, Stamp t) {
  auto p_OC = legs.X_OC.translation();
  if (!first_p_OC_) first_p_OC_ = p_OC;
  if (scale_fraction_ != 0) p_OC.head<2>() += scale_fraction_ * (p_OC - *first_p_OC_).head<2>();
  if (sigma_m_ == 0) return;
  Random random(seed_, "leg odometry", static_cast<std::uint64_t>(t.count()));
  for (int axis = 0; axis < 3; ++axis) p_OC(axis) += sigma_m_ * random.normal();
}

std::optional<PlannedMotion> PlanErrors::apply(std::optional<PlannedMotion> plan, Stamp t) {
  if (!plan) return plan;
  double factor = 1;
  for (const PlanScaled& scaled : scaled_)
    if (scaled.holds(t)) factor *= scaled.factor;
  const Eigen::Vector3d p_PC = plan->X_PC.translation();
  position_error_P_ += (factor - 1) * (p_PC - last_p_PC_.value_or(p_PC));
  last_p_PC_ = p_PC;
  plan->X_PC.translation() += position_error_P_;
  plan->v_PC_C *= factor;
  if (std::any_of(missing_.begin(), missing_.end(), [t](const PlanMissing& m) { return m.holds(t); }))
    plan.reset();
  return plan;
}

std::vector<Observation> MotionClock::process(Observation observation) {
  append_shifted(gyro_, observation.gyro, offset_);
  append_shifted(accelerometer_, observation.accelerometer, offset_);
  for (slam::BodyReading& reading : std::exchange(observation.body, {})) {
    reading.t += offset_;
    body_.push_back(std::move(reading));
  }
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
  for (; !body_.empty() && body_.front().t < frame.t; body_.pop_front())
    frame.body.push_back(std::move(body_.front()));
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
