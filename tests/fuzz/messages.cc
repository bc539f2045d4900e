// Messages of other programs: answers of an estimator, and commands of clients of the view.
#include "sim/estimators/messages.h"

#include "sim/view/live_view.h"
#include "tests/fuzz/fuzz_input.h"

namespace fuzz {

/// The first byte selects the question, the next 16 are the header.
inline void answer(std::string_view text) {
  namespace estimators = sim::estimators;
  if (text.size() < 1 + estimators::kHeaderBytes) return;
  read_or_reject<estimators::EstimatorFailed>([&] {
    const bool start = text[0] % 2 == 0;
    const std::size_t bytes = estimators::payload_bytes(
        text.substr(1, estimators::kHeaderBytes), start ? GAITSLAM_MESSAGE_READY : GAITSLAM_MESSAGE_ANSWER);
    const std::string_view payload = text.substr(1 + estimators::kHeaderBytes);
    require(bytes < 20'000'000);
    if (start) {
      estimators::read_ready(payload);
      return;
    }
    const estimators::Answer answer = estimators::read_answer(payload);
    require((answer.map ? answer.map->size() : 0) * sizeof(gaitslam_landmark) <= payload.size());
    estimators::require_valid(answer, slam::Stamp(0), slam::Stamp(0), slam::Stamp(1'000'000'000));
    require(!answer.estimate || answer.estimate->X_WC.matrix().allFinite());
  });
}

inline void client_message(std::string_view text) {
  namespace view = sim::view;
  read_or_reject<std::invalid_argument>([&] {
    const view::ClientMessage message = view::read_client_message(text);
    require(message.factor == 0 || (message.factor >= 0.01 && message.factor <= 100));
    require(message.subscriptions.size() <= view::kMostSubscriptions);
    require(message.unsubscribed.size() <= view::kMostSubscriptions);
  });
}

}  // namespace fuzz
GAITSLAM_FUZZ_ENTRY
