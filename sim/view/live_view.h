// The view of a live run.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <string>

#include "sim/recording/recording.h"
#include "sim/tracking/tracking.h"
#include "sim/view/foxglove.h"
#include "sim/view/pace.h"
#include "sim/view/server.h"
#include "sim/view/site.h"
#include "sim/view/strips.h"

namespace sim::view {

/// Serves one run. The run's thread never waits for a client, except in pace() if a client with control
/// paused or slowed the run. Frames are made only for clients that have room for them, at most 40 a second.
class LiveView {
 public:
  /// control: clients may pause the run, step it and set its speed. Throws as Server does.
  LiveView(const Access& access, ShownRun run, bool control);
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  const Access& access() const { return server_.access(); }

  /// Returns when there is a viewer.
  void wait_for_viewer() const;
  /// Before the first frame: describes the sensors to Foxglove clients.
  void begin(const recording::RecordingSetup& setup);
  /// True if a viewer has room for a frame.
  bool has_viewers() const;
  /// True if a frame of this observation is needed. Must be called for each observation.
  bool wants(const slam::Observation& observation);
  /// True if that frame needs the map: ten times a second, as it costs more than the rest.
  bool wants_map();
  void show(Frame frame);
  /// Returns when the run may continue.
  void pace(slam::Stamp t);
  /// Reports how the run ended; waits at most 15 s for pages that still fetch room and robot, then at most 3
  /// s until everything is sent.
  void end(const std::string& how);

 private:
  void opened(Client& client);
  void received(Client& client, std::string_view text);
  void command(const ClientMessage& message);
  Message pace_message() const;
  void send_strips(bool is_frame);
  void send_to_pages(const Message& message);

  bool control_;
  Pace pace_;
  Site site_;
  std::shared_ptr<Foxglove> foxglove_;    // set before the first observation, in the server's thread
  std::vector<exports::ImuReading> imu_;  // not sent yet
  std::chrono::steady_clock::time_point shown_{}, map_shown_{}, strips_shown_{};
  Strips strips_;
  slam::Stamp period_ = std::chrono::milliseconds(34);  // a frame's
  Message last_;                                        // of the server's thread
  Server server_;                                       // last: its thread uses the members above
};

/// Adds the image, the estimator's results and, if wanted, the map.
void add_tracked(Frame& frame, const slam::Observation& observation, const tracking::Tracking* tracking,
                 bool with_map);

}  // namespace sim::view
