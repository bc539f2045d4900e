// The messages of gaitslam_estimator.h: what an estimator outside is told, and what it answers.
#pragma once

#include <string>
#include <string_view>

#include "sim/estimators/estimator.h"
#include "sim/estimators/estimator_choice.h"
#include "sim/estimators/gaitslam_estimator.h"

namespace sim::estimators {

/// A header's size, and of what follows it.
inline constexpr std::size_t kHeaderBytes = sizeof(gaitslam_header);

/// "key=value" lines.
std::string options_text(const EstimatorChoice& choice);

/// A whole message with its header.
std::string start_message(const EstimatorChoice& choice, const Start& start);
std::string observation_message(const slam::Observation& observation);
std::string end_message();

/// The number of bytes after a header. Throws EstimatorFailed where it is none of that type, or too many
/// follow.
std::size_t payload_bytes(std::string_view header, std::uint32_t type);

/// Reads the bytes after the header of READY. Throws EstimatorFailed where they are none, or the program
/// cannot start.
void read_ready(std::string_view payload);

/// Reads the bytes after the header of ANSWER. Throws EstimatorFailed where the counts do not fit the length,
/// or a word is none of those defined. Whether the numbers make sense is for require_sound() to say.
Answer read_answer(std::string_view payload);

}  // namespace sim::estimators
