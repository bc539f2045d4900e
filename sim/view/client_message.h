// Messages of clients, in the view's protocol or in Foxglove's.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sim::view {

/// op: "pause", "resume", "step" (runs for one frame of the camera), "speed", "loaded" (the page has fetched
/// room and robot), "subscribe", "unsubscribe"; others are without use here.
struct ClientMessage {
  std::string op;
  double factor = 0;  ///< of "speed": times real time; 0: full speed
  std::vector<std::pair<std::uint32_t, std::uint32_t>> subscriptions{};  ///< (the client's number, channel)
  std::vector<std::uint32_t> unsubscribed{};                             ///< the client's numbers
};

/// Limit of subscriptions in one message.
inline constexpr std::size_t kMostSubscriptions = 64;

/// Reads any text. Throws std::invalid_argument unless it is a message.
ClientMessage read_client_message(std::string_view text);

}  // namespace sim::view
