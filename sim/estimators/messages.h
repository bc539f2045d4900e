// The messages of gaitslam_estimator.h.
#pragma once

#include "sim/estimators/estimator.h"
#include "sim/estimators/gaitslam_estimator.h"

namespace sim::estimators {

/// Bytes of a header.
inline constexpr std::size_t kHeaderBytes = sizeof(gaitslam_header);

/// Returns lines "key=value".
std::string options_text(const EstimatorChoice& choice);

/// Version 2 of the interface: camera and IMU of the chest, no further sensors.
inline constexpr std::uint32_t kMonocularVersion = 2;

/// Return a whole message with its header. version: of the interface. rig: the sensors of observation.rig.
std::string start_message(const EstimatorChoice& choice, const Start& start,
                          std::uint32_t version = GAITSLAM_ESTIMATOR_VERSION);
std::string observation_message(const slam::Observation& observation, const std::vector<rig::RigSensor>& rig,
                                std::uint32_t version = GAITSLAM_ESTIMATOR_VERSION);
std::string end_message();

/// Returns the number of bytes after a header. Throws EstimatorFailed if it is not a header of that type, or
/// too many follow.
std::size_t payload_bytes(std::string_view header, std::uint32_t type);

/// Reads the payload of READY to a START of this version. Returns the version that the program uses: this one
/// or kMonocularVersion. Throws EstimatorFailed if it is invalid, another one or the program cannot start.
std::uint32_t read_ready(std::string_view payload, std::uint32_t version = GAITSLAM_ESTIMATOR_VERSION);

/// Reads the payload of ANSWER. Throws EstimatorFailed if counts and length disagree or a word is undefined;
/// require_valid() checks the numbers.
Answer read_answer(std::string_view payload);

}  // namespace sim::estimators
