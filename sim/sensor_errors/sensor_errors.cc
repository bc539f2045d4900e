#include "sim/sensor_errors/sensor_errors.h"

#include <algorithm>

#include "sim/sensor_errors/random.h"
#include "walking/keys.h"

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

void append(std::vector<slam::Observation>& all, std::vector<slam::Observation> more) {
  std::move(more.begin(), more.end(), std::back_inserter(all));
}

template <class Faults>
bool applies(const Faults& faults, std::uint64_t seed, const char* stream, slam::Stamp t) {
  const double drawn = Random(seed, stream, static_cast<std::uint64_t>(t.count())).uniform();
  return std::any_of(faults.begin(), faults.end(),
                     [&](const auto& fault) { return fault.holds(t) && drawn < fault.fraction; });
}

}  // namespace

ArrivalOrder::ArrivalOrder(std::uint64_t seed, const std::vector<Fault>& faults)
    : seed_(seed),
      doubled_(faults_of<FramesDoubled>(faults)),
      reordered_(faults_of<FramesReordered>(faults)) {}

std::vector<slam::Observation> ArrivalOrder::process(slam::Observation observation) {
  if (!late_ && applies(reordered_, seed_, "frame reordered", observation.t)) {
    late_ = std::move(observation);
    return {};
  }
  const bool doubled = applies(doubled_, seed_, "frame doubled", observation.t);
  std::vector<slam::Observation> arrived(doubled ? 2 : 1, observation);
  append(arrived, flush());
  return arrived;
}

std::vector<slam::Observation> ArrivalOrder::flush() {
  if (!late_) return {};
  return {*std::exchange(late_, {})};
}

SensorErrors::SensorErrors(const ErrorOptions& options, std::uint64_t seed)
    : options_((walking::check_ranges(options, "errors"), options)),
      seed_(seed),
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
      motion_clock_(stamp(options.motion.time_offset_s)),
      arrival_order_(seed, options.faults),
      frames_lost_(faults_of<FramesLost>(options.faults)),
      frames_frozen_(faults_of<FramesFrozen>(options.faults)) {}

std::vector<slam::Observation> SensorErrors::process(slam::Observation ideal) {
  disturb(ideal);
  std::vector<slam::Observation> arrived;
  for (slam::Observation& assembled : motion_clock_.process(std::move(ideal)))
    append(arrived, arrival_order_.process(std::move(assembled)));
  return arrived;
}

std::vector<slam::Observation> SensorErrors::flush() {
  std::vector<slam::Observation> arrived;
  for (slam::Observation& assembled : motion_clock_.flush())
    append(arrived, arrival_order_.process(std::move(assembled)));
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
