#include "sim/stream/sensor_errors.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/stream/random.h"

namespace sim::stream {
namespace {

slam::Stamp stamp(double s) { return slam::Stamp(std::llround(s * 1e9)); }

void require(double value, double least, double most, const std::string& name) {
  if (!(value >= least && value <= most))
    throw std::invalid_argument("errors." + name + " must be from " + std::to_string(least) + " to " +
                                std::to_string(most) + ", is " + std::to_string(value));
}

void validate(const ErrorOptions& o) {
  constexpr double kAny = 1e6;
  require(o.gyro.sigma_rad_s, 0, kAny, "gyro.sigma_rad_s");
  require(o.gyro.bias_sigma_rad_s, 0, kAny, "gyro.bias_sigma_rad_s");
  require(o.gyro.bias_walk_sigma_rad_s2, 0, kAny, "gyro.bias_walk_sigma_rad_s2");
  require(o.gyro.range_rad_s, 0, kAny, "gyro.range_rad_s");
  require(o.gyro.resolution_rad_s, 0, kAny, "gyro.resolution_rad_s");
  require(o.accelerometer.sigma_m_s2, 0, kAny, "accelerometer.sigma_m_s2");
  require(o.accelerometer.bias_sigma_m_s2, 0, kAny, "accelerometer.bias_sigma_m_s2");
  require(o.accelerometer.bias_walk_sigma_m_s3, 0, kAny, "accelerometer.bias_walk_sigma_m_s3");
  require(o.accelerometer.range_m_s2, 0, kAny, "accelerometer.range_m_s2");
  require(o.accelerometer.resolution_m_s2, 0, kAny, "accelerometer.resolution_m_s2");
  require(o.image.read_sigma_grey, 0, 100, "image.read_sigma_grey");
  require(o.image.shot_sigma_grey, 0, 50, "image.shot_sigma_grey");
  require(o.image.gain, 0, 16, "image.gain");
  require(o.image.vignetting_fraction, 0, 1, "image.vignetting_fraction");
  require(o.image.exposure_sigma_fraction, 0, 10, "image.exposure_sigma_fraction");
  require(o.image.exposure_time_s, 1e-3, kAny, "image.exposure_time_s");
  require(o.image.loss_fraction, 0, 1, "image.loss_fraction");
  require(o.image.latency_s, 0, 10, "image.latency_s");
  require(o.plan.loss_fraction, 0, 1, "plan.loss_fraction");
  require(o.plan.velocity_sigma_m_s, 0, kAny, "plan.velocity_sigma_m_s");
  require(o.motion.time_offset_s, -1, 1, "motion.time_offset_s");
}

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
    : options_((validate(options), options)),
      seed_(seed),
      gyro_(gyro_errors(options, seed)),
      accelerometer_(accelerometer_errors(options, seed)),
      image_(options.image, seed, options.faults),
      plan_(options.plan.velocity_sigma_m_s, seed, options.faults),
      motion_clock_(stamp(options.motion.time_offset_s)),
      arrival_(seed, options.faults),
      frames_lost_(faults_of<FramesLost>(options.faults)),
      frames_frozen_(faults_of<FramesFrozen>(options.faults)) {}

std::vector<slam::Observation> SensorErrors::take(slam::Observation ideal) {
  disturb(ideal);
  std::vector<slam::Observation> arrived;
  for (slam::Observation& assembled : motion_clock_.take(std::move(ideal)))
    append(arrived, arrival_.take(std::move(assembled)));
  return arrived;
}

std::vector<slam::Observation> SensorErrors::rest() {
  std::vector<slam::Observation> arrived;
  for (slam::Observation& assembled : motion_clock_.rest())
    append(arrived, arrival_.take(std::move(assembled)));
  append(arrived, arrival_.rest());
  return arrived;
}

void SensorErrors::disturb(slam::Observation& o) {
  gyro_.apply(o.gyro);
  accelerometer_.apply(o.accelerometer);
  o.image = late_picture(arrived_picture(o.image, o.t), o.t);
  o.plan = plan_.apply(std::move(o.plan), o.t);
  if (lost("plan loss", o.t, options_.plan.loss_fraction)) o.plan.reset();
}

cv::Mat SensorErrors::arrived_picture(const cv::Mat& ideal, slam::Stamp t) {
  double lost_fraction = options_.image.loss_fraction;
  for (const FramesLost& fault : frames_lost_)
    if (fault.holds(t)) lost_fraction = std::max(lost_fraction, fault.fraction);
  if (ideal.empty() || lost("image loss", t, lost_fraction)) return {};
  const bool frozen = std::any_of(frames_frozen_.begin(), frames_frozen_.end(),
                                  [t](const Span& span) { return span.holds(t); });
  if (!frozen || before_freezing_.empty()) before_freezing_ = image_.apply(ideal, t);
  return before_freezing_;
}

cv::Mat SensorErrors::late_picture(cv::Mat picture, slam::Stamp t) {
  if (!picture.empty()) under_way_.push_back({t, std::move(picture)});
  cv::Mat newest;
  for (; !under_way_.empty() && under_way_.front().t + stamp(options_.image.latency_s) <= t;
       under_way_.pop_front())
    newest = under_way_.front().picture;
  return newest;
}

bool SensorErrors::lost(const char* stream, slam::Stamp t, double fraction) const {
  return fraction > 0 && Random(seed_, stream, static_cast<std::uint64_t>(t.count())).uniform() < fraction;
}

}  // namespace sim::stream
