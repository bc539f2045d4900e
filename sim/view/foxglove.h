// The Foxglove WebSocket protocol: the messages of an exported run.mcap during a run.
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
  /// Keeps a client's subscriptions; answers malformed messages and unknown channels with a status.
  void process(Client& client, std::string_view said) const;

  /// IMU readings of an observation, also if it is not shown itself.
  std::vector<exports::ImuReading> merged(const slam::Observation& observation) {
    return imu_.merge(observation);
  }
  /// Sends the messages of a frame that the client subscribed to.
  void send(const Frame& frame, const std::vector<exports::ImuReading>& imu, Client& client) const;

 private:
  recording::RecordingSetup setup_;
  exports::ImuMerger imu_;
};

}  // namespace sim::view
