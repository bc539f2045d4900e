// Messages of clients, in the view's protocol or in Foxglove's.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace sim::view {

struct Pause {};
struct Resume {};
/// Runs for one frame of the camera.
struct Step {};
/// Times real time; 0: full speed.
struct Speed {
  double factor = 0;
};
/// (the client's number, the channel's number)
struct Subscribe {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> subscriptions;
};
struct Unsubscribe {
  std::vector<std::uint32_t> subscriptions;
};
/// The page has fetched room and robot.
struct Loaded {};
/// A valid message without use here.
struct Ignored {};
struct Malformed {
  std::string why;
};

using ClientMessage =
    std::variant<Pause, Resume, Step, Speed, Subscribe, Unsubscribe, Loaded, Ignored, Malformed>;

/// Limit of subscriptions in one message.
inline constexpr std::size_t kMostSubscriptions = 64;

/// Reads any text; returns Malformed for anything but a message.
ClientMessage read_client_message(std::string_view text);

}  // namespace sim::view
