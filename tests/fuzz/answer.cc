// Answers of an estimator program: the first byte selects the question, the next 16 are the header.
#include "sim/estimators/messages.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace estimators = sim::estimators;
  const std::string_view text = fuzz::text_of(data, size);
  if (text.size() < 1 + estimators::kHeaderBytes) return 0;
  try {
    const bool start = text[0] % 2 == 0;
    const std::size_t bytes = estimators::payload_bytes(
        text.substr(1, estimators::kHeaderBytes), start ? GAITSLAM_MESSAGE_READY : GAITSLAM_MESSAGE_ANSWER);
    const std::string_view payload = text.substr(1 + estimators::kHeaderBytes);
    fuzz::require(bytes < 20'000'000);
    if (start) {
      estimators::read_ready(payload);
      return 0;
    }
    const estimators::Answer answer = estimators::read_answer(payload);
    fuzz::require((answer.map ? answer.map->size() : 0) * sizeof(gaitslam_landmark) <= payload.size());
    estimators::require_valid(answer, slam::Stamp(0), slam::Stamp(1'000'000'000));
    fuzz::require(answer.estimate.X_WC.matrix().allFinite());
  } catch (const estimators::EstimatorFailed&) {
  }
  return 0;
}
