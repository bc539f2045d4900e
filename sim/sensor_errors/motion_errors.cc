#include "sim/sensor_errors/motion_errors.h"

#include <algorithm>

#include "sim/sensor_errors/random.h"

namespace sim::sensor_errors {
namespace {

Eigen::Vector3d normal3(Random random) {
  Eigen::Vector3d v;
  for (double& x : v) x = random.normal();
  return v;
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

void InertialErrors::apply(std::vector<slam::InertialSample>& readings) {
  for (slam::InertialSample& reading : readings) reading.value = disturbed(reading);
  std::erase_if(readings, [this](const slam::InertialSample& reading) {
    return std::any_of(silences_.begin(), silences_.end(), [&](const Span& s) { return s.touches(reading); });
  });
}

// A reading split by a frame is a mean over less than 5 ms. Its noise is scaled up, so that the integral over
// the whole 5 ms has the variance of an unsplit reading.
Eigen::Vector3d InertialErrors::disturbed(const slam::InertialSample& reading) {
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

void LegErrors::apply(slam::LegMotion& legs, slam::Stamp t) {
  auto p_OC = legs.X_OC.translation();
  if (!first_p_OC_) first_p_OC_ = p_OC;
  if (scale_fraction_ != 0) p_OC.head<2>() += scale_fraction_ * (p_OC - *first_p_OC_).head<2>();
  if (sigma_m_ == 0) return;
  Random random(seed_, "leg odometry", static_cast<std::uint64_t>(t.count()));
  for (int axis = 0; axis < 3; ++axis) p_OC(axis) += sigma_m_ * random.normal();
}

std::optional<slam::PlannedMotion> PlanErrors::apply(std::optional<slam::PlannedMotion> plan, slam::Stamp t) {
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

}  // namespace sim::sensor_errors
