#include "sim/export/imu_merger.h"

#include <cmath>

namespace sim::exports {

ImuMerger::ImuMerger(double rate_hz) : period_(std::llround(1e9 / rate_hz)) {}

std::vector<ImuReading> ImuMerger::merge(const slam::Observation& observation) {
  std::vector<ImuReading> merged;
  const bool both = observation.accelerometer.size() == observation.gyro.size();
  for (std::size_t i = 0; i < observation.gyro.size(); ++i)
    add(observation.gyro[i], both ? &observation.accelerometer[i] : nullptr, merged);
  return merged;
}

void ImuMerger::add(const slam::InertialSample& gyro, const slam::InertialSample* accelerometer,
                    std::vector<ImuReading>& merged) {
  if (gyro.begin != end_) {
    begin_ = gyro.begin;
    gyro_.setZero();
    accelerometer_.setZero();
  }
  const double dt = slam::seconds(gyro.end - gyro.begin);
  gyro_ += dt * gyro.value;
  if (accelerometer) accelerometer_ += dt * accelerometer->value;
  end_ = gyro.end;
  if (end_ - begin_ < period_) return;
  const double duration = slam::seconds(end_ - begin_);
  merged.push_back({begin_ + (end_ - begin_) / 2, gyro_ / duration, std::nullopt});
  if (accelerometer) merged.back().accelerometer = accelerometer_ / duration;
  begin_ = end_;
  gyro_.setZero();
  accelerometer_.setZero();
}

}  // namespace sim::exports
