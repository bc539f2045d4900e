// The innovations in a frame's report by sensor, in the order of score::kSensors.
#pragma once

#include <array>
#include <optional>

#include "sim/score/run.h"
#include "slam/filter.h"

namespace sim::result {

inline constexpr std::array kSensorInnovations{&slam::FrameReport::vision, &slam::FrameReport::gyro,
                                               &slam::FrameReport::plan_velocity, &slam::FrameReport::height};
static_assert(kSensorInnovations.size() == score::kSensors.size());

}  // namespace sim::result
