// The Foxglove WebSocket protocol: the messages of an exported run.mcap, as the run goes on.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sim/export/imu_merger.h"
#include "sim/recording/recording.h"
#include "sim/view/client_message.h"
#include "sim/view/server.h"
#include "sim/view/strips.h"

namespace sim::view {

/// Its subprotocols, which have the same wire format.
inline constexpr std::array kFoxgloveProtocols{"foxglove.websocket.v1", "foxglove.sdk.v1"};

/// Serves the channels to those of its clients that subscribe to them. In the server's thread, but for the
/// constructor.
class Foxglove {
 public:
  explicit Foxglove(const recording::RecordingSetup& setup);

  /// serverInfo and advertise.
  void greet(Client& client) const;
  /// Keeps a client's subscriptions. What it subscribes to that is not there is answered by a status.
  void take(Client& client, const ClientMessage& message) const;

  /// The readings of an observation that may not be shown itself: none is lost on the way to /imu.
  std::vector<exports::ImuReading> merged(const slam::Observation& observation) {
    return imu_.merge(observation);
  }
  /// Sends a frame's messages to those who subscribed to them; a message is made only for a subscriber.
  void send(const Frame& frame, const std::vector<exports::ImuReading>& imu, Client& client) const;

 private:
  recording::RecordingSetup setup_;
  exports::ImuMerger imu_;
};

/// A binary message: op 1, subscription, log time, payload.
std::string foxglove_message(std::uint32_t subscription, std::uint64_t t_ns, std::string_view payload);

}  // namespace sim::view
