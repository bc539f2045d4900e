// The messages of gaitslam_estimator.h.
#pragma once

#include "sim/estimators/estimator.h"
#include "sim/estimators/gaitslam_estimator.h"
#include "sim/programs/conversation.h"

namespace sim::estimators {

/// The maximum length in bytes of a READY or ANSWER.
inline constexpr std::size_t kMostBytes = sizeof(gaitslam_answer) + GAITSLAM_MOST_TEXT_BYTES +
                                          std::uint64_t{GAITSLAM_MOST_LANDMARKS} * sizeof(gaitslam_landmark);

/// Return a whole message with its header. rig: the sensors of observation.rig.
std::string start_message(const programs::Choice& choice, const Start& start);
std::string observation_message(const slam::Observation& observation, const std::vector<rig::RigSensor>& rig);

/// Reads the payload of READY. Throws InvalidMessage if it is invalid, states a different version, or states
/// that the program cannot start.
void read_ready(std::string_view payload);

/// Reads the payload of ANSWER. Throws InvalidMessage if counts and length disagree or a field has an
/// undefined value; require_valid() checks the numbers.
Answer read_answer(std::string_view payload);

}  // namespace sim::estimators
