// What a client may say, in the viewer's own words or in those of the Foxglove protocol.
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
/// Goes on for one frame of the camera.
struct Step {};
/// Times the real time; 0: as fast as it goes.
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
/// A message of a kind that is allowed and of no use here.
struct Ignored {};
struct Malformed {
  std::string why;
};

using ClientMessage =
    std::variant<Pause, Resume, Step, Speed, Subscribe, Unsubscribe, Loaded, Ignored, Malformed>;

/// No more subscriptions than that in one message.
inline constexpr std::size_t kMostSubscriptions = 64;

/// Reads any text: what is no message is Malformed.
ClientMessage read_client_message(std::string_view text);

}  // namespace sim::view
