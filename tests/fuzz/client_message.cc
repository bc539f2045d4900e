// Messages from clients of the view.
#include "sim/view/client_message.h"

#include <stdexcept>

#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace view = sim::view;
  try {
    const view::ClientMessage message = view::read_client_message(fuzz::text_of(data, size));
    fuzz::require(message.factor == 0 || (message.factor >= 0.01 && message.factor <= 100));
    fuzz::require(message.subscriptions.size() <= view::kMostSubscriptions);
    fuzz::require(message.unsubscribed.size() <= view::kMostSubscriptions);
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
