#include "sim/sensor_errors/sensor_errors.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/sensor_errors/random.h"
#include "walking/keys.h"

namespace sim::sensor_errors {
namespace {

slam::Stamp stamp(double s) { return slam::Stamp(std::llround(s * 1e9)); }

InertialErrors gyro_errors(const ErrorOptions& o, std::uint64_t seed) {
  std::vector<InertialErrors::Spike> spikes;
  for (const GyroSpike& spike : faults_of<GyroSpike>(o.faults)) spikes.push_back({spike, spike.size_rad_s});
  const auto silent = faults_of<GyroSilent>(o.faults);
  return {"gyro",
          {o.gyro.sigma_rad_s, o.gyro.bias_sigma_rad_s, o.gyro.bias_walk_sigma_rad_s2, o.gyro.range_rad_s,
           o.gyro.resolution_rad_s},
          seed,
          std::move(spikes),
          {silent.begin(), silent.end()}};
}

InertialErrors accelerometer_errors(const ErrorOptions& o, std::uint64_t seed) {
  std::vector<InertialErrors::Spike> spikes;
  for (const AccelerometerSpike& spike : faults_of<AccelerometerSpike>(o.faults))
    spikes.push_back({spike, spike.size_m_s2});
  const auto silent = faults_of<AccelerometerSilent>(o.faults);
  const ErrorOptions::Accelerometer& a = o.accelerometer;
  return {"accelerometer",
          {a.sigma_m_s2, a.bias_sigma_m_s2, a.bias_walk_sigma_m_s3, a.range_m_s2, a.resolution_m_s2},
          seed,
          std::move(spikes),
          {silent.begin(), silent.end()}};
}

void append(std::vector<slam::Observation>& all, std::vector<slam::Observation> more) {
  std::move(more.begin(), more.end(), std::back_inserter(all));
}

}  // namespace

SensorErrors::SensorErrors(const ErrorOptions& options, std::uint64_t seed)
    : options_((walking::check_ranges(options, "errors"), options)),
      seed_(seed),
      gyro_(gyro_errors(options, seed)),
      accelerometer_(accelerometer_errors(options, seed)),
      image_(options.image, seed, options.faults),
      plan_(options.plan.velocity_sigma_m_s, seed, options.faults),
      legs_(options.leg_odometry.sigma_m, options.leg_odometry.scale_fraction, seed),
      motion_clock_(stamp(options.motion.time_offset_s)),
      arrival_order_(seed, options.faults),
      frames_lost_(faults_of<FramesLost>(options.faults)),
      frames_frozen_(faults_of<FramesFrozen>(options.faults)) {}

std::vector<slam::Observation> SensorErrors::take(slam::Observation ideal) {
  disturb(ideal);
  std::vector<slam::Observation> arrived;
  for (slam::Observation& assembled : motion_clock_.take(std::move(ideal)))
    append(arrived, arrival_order_.take(std::move(assembled)));
  return arrived;
}

std::vector<slam::Observation> SensorErrors::flush() {
  std::vector<slam::Observation> arrived;
  for (slam::Observation& assembled : motion_clock_.flush())
    append(arrived, arrival_order_.take(std::move(assembled)));
  append(arrived, arrival_order_.flush());
  return arrived;
}

void SensorErrors::disturb(slam::Observation& o) {
  gyro_.apply(o.gyro);
  accelerometer_.apply(o.accelerometer);
  o.image = delayed_image(received_image(o.image, o.t), o.t);
  if (o.plan && o.plan->legs) legs_.apply(*o.plan->legs, o.t);
  o.plan = plan_.apply(std::move(o.plan), o.t);
  if (lost("plan loss", o.t, options_.plan.loss_fraction)) o.plan.reset();
}

cv::Mat SensorErrors::received_image(const cv::Mat& ideal, slam::Stamp t) {
  double lost_fraction = options_.image.loss_fraction;
  for (const FramesLost& fault : frames_lost_)
    if (fault.holds(t)) lost_fraction = std::max(lost_fraction, fault.fraction);
  if (ideal.empty() || lost("image loss", t, lost_fraction)) return {};
  const bool frozen = std::any_of(frames_frozen_.begin(), frames_frozen_.end(),
                                  [t](const Span& span) { return span.holds(t); });
  if (!frozen || last_unfrozen_.empty()) last_unfrozen_ = image_.apply(ideal, t);
  return last_unfrozen_;
}

cv::Mat SensorErrors::delayed_image(cv::Mat image, slam::Stamp t) {
  if (!image.empty()) delayed_.push_back({t, std::move(image)});
  cv::Mat newest;
  for (; !delayed_.empty() && delayed_.front().t + stamp(options_.image.latency_s) <= t; delayed_.pop_front())
    newest = delayed_.front().image;
  return newest;
}

bool SensorErrors::lost(const char* stream, slam::Stamp t, double fraction) const {
  return fraction > 0 && Random(seed_, stream, static_cast<std::uint64_t>(t.count())).uniform() < fraction;
}

}  // namespace sim::sensor_errors
