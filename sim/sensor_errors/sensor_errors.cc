#include "sim/sensor_errors/sensor_errors.h"

#include <algorithm>

#include "sim/sensor_errors/random.h"

namespace sim::sensor_errors {
namespace {

template <class Spike, class Silence>
InertialErrors inertial_errors(const char* sensor, const InertialErrorSizes& sizes, double Spike::*spike_size,
                               const std::vector<Fault>& faults, std::uint64_t seed) {
  std::vector<InertialErrors::Spike> spikes;
  for (const Spike& spike : faults_of<Spike>(faults)) spikes.push_back({spike, spike.*spike_size});
  const auto silent = faults_of<Silence>(faults);
  return {sensor, sizes, seed, std::move(spikes), {silent.begin(), silent.end()}};
}

}  // namespace

SensorErrors::SensorErrors(const ErrorOptions& options, std::uint64_t seed,
                           const std::vector<rig::RigSensor>& rig)
    : options_(options),
      seed_(seed),
      rig_(rig, seed),
      gyro_(inertial_errors<GyroSpike, GyroSilent>(
          "gyro",
          {options.gyro.sigma_rad_s, options.gyro.bias_sigma_rad_s, options.gyro.bias_walk_sigma_rad_s2,
           options.gyro.range_rad_s, options.gyro.resolution_rad_s},
          &GyroSpike::size_rad_s, options.faults, seed)),
      accelerometer_(inertial_errors<AccelerometerSpike, AccelerometerSilent>(
          "accelerometer",
          {options.accelerometer.sigma_m_s2, options.accelerometer.bias_sigma_m_s2,
           options.accelerometer.bias_walk_sigma_m_s3, options.accelerometer.range_m_s2,
           options.accelerometer.resolution_m_s2},
          &AccelerometerSpike::size_m_s2, options.faults, seed)),
      image_(options.image, seed, options.faults),
      plan_(options.faults),
      legs_(options.leg_odometry.sigma_m, options.leg_odometry.scale_fraction, seed),
      motion_clock_(stamp(options.motion_time_offset_s)) {}

/// Returns whether one of these faults hits the frame.
template <class Kind>
bool SensorErrors::strikes(const char* stream, slam::Stamp t) const {
  const auto faults = faults_of<Kind>(options_.faults);
  return std::any_of(faults.begin(), faults.end(),
                     [&](const Kind& fault) { return fault.holds(t) && lost(stream, t, fault.fraction); });
}

void SensorErrors::arrive(slam::Observation observation, std::vector<slam::Observation>& arrived) {
  if (!late_ && strikes<FramesReordered>("frame reordered", observation.t)) {
    late_ = std::move(observation);
    return;
  }
  arrived.insert(arrived.end(), strikes<FramesDoubled>("frame doubled", observation.t) ? 2 : 1, observation);
  if (late_) arrived.push_back(*std::exchange(late_, {}));
}

std::vector<slam::Observation> SensorErrors::process(slam::Observation o) {
  gyro_.apply(o.gyro);
  accelerometer_.apply(o.accelerometer);
  rig_.apply(o.rig);
  o.image = delayed_image(received_image(o.image, o.t), o.t);
  if (o.plan && o.plan->legs) legs_.apply(*o.plan->legs, o.t);
  o.plan = plan_.apply(std::move(o.plan), o.t);
  if (lost("plan loss", o.t, options_.plan_loss_fraction)) o.plan.reset();
  std::vector<slam::Observation> arrived;
  for (slam::Observation& assembled : motion_clock_.process(std::move(o)))
    arrive(std::move(assembled), arrived);
  return arrived;
}

std::vector<slam::Observation> SensorErrors::flush() {
  std::vector<slam::Observation> arrived;
  for (slam::Observation& assembled : motion_clock_.flush()) arrive(std::move(assembled), arrived);
  if (late_) arrived.push_back(*std::exchange(late_, {}));
  return arrived;
}

cv::Mat SensorErrors::received_image(const cv::Mat& ideal, slam::Stamp t) {
  double lost_fraction = options_.image.loss_fraction;
  for (const FramesLost& fault : faults_of<FramesLost>(options_.faults))
    if (fault.holds(t)) lost_fraction = std::max(lost_fraction, fault.fraction);
  if (ideal.empty() || lost("image loss", t, lost_fraction)) return {};
  const auto freezes = faults_of<FramesFrozen>(options_.faults);
  const bool frozen = std::any_of(freezes.begin(), freezes.end(), [t](const Span& s) { return s.holds(t); });
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
