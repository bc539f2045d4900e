// The messages of gaitslam_estimator.h.
#pragma once

#include "sim/estimators/estimator.h"
#include "sim/estimators/gaitslam_estimator.h"

namespace sim::estimators {

/// Bytes of a header.
inline constexpr std::size_t kHeaderBytes = sizeof(gaitslam_header);

/// Returns lines "key=value".
std::string options_text(const EstimatorChoice& choice);

/// A message is not one that the interface allows.
class InvalidMessage : public EstimatorFailed {
 public:
  using EstimatorFailed::EstimatorFailed;
};

/// Return a whole message with its header. rig: the sensors of observation.rig.
std::string start_message(const EstimatorChoice& choice, const Start& start);
std::string observation_message(const slam::Observation& observation, const std::vector<rig::RigSensor>& rig);
std::string end_message();

/// Returns whether the bytes start with a header.
bool starts_message(std::string_view bytes);

/// Returns the number of bytes after a header. Throws InvalidMessage if it is not a header of that type, or
/// too many follow.
std::size_t payload_bytes(std::string_view header, std::uint32_t type);

/// Reads the payload of READY. Throws InvalidMessage if it is invalid, states another version or that the
/// program cannot start.
void read_ready(std::string_view payload);

/// Reads the payload of ANSWER. Throws InvalidMessage if counts and length disagree or a word is undefined;
/// require_valid() checks the numbers.
Answer read_answer(std::string_view payload);

}  // namespace sim::estimators
