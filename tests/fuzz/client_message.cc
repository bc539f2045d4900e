// Messages from clients of the view.
#include "sim/view/client_message.h"

#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace view = sim::view;
  const view::ClientMessage message = view::read_client_message(fuzz::text_of(data, size));
  if (const auto* const speed = std::get_if<view::Speed>(&message))
    fuzz::require(speed->factor == 0 || (speed->factor >= 0.01 && speed->factor <= 100));
  if (const auto* const wanted = std::get_if<view::Subscribe>(&message))
    fuzz::require(wanted->subscriptions.size() <= view::kMostSubscriptions);
  if (const auto* const unwanted = std::get_if<view::Unsubscribe>(&message))
    fuzz::require(unwanted->subscriptions.size() <= view::kMostSubscriptions);
  return 0;
}
