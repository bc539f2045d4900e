// The view of a run as it goes on.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <string>

#include "sim/recording/recording.h"
#include "sim/view/foxglove.h"
#include "sim/view/pace.h"
#include "sim/view/server.h"
#include "sim/view/site.h"
#include "sim/view/strips.h"

namespace sim::view {

/// Serves one run. The run's thread never waits for a client: it waits in pace() alone, where a client of a
/// view with control asked for that. Frames are made for clients that have room for them, 40 a second at the
/// most.
class LiveView {
 public:
  /// control: clients may pause the run, step it and set its speed. Throws as Server does.
  LiveView(const Access& access, ShownRun run, bool control);
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  const Access& access() const { return server_.access(); }

  /// Returns when somebody looks on.
  void wait_for_viewer() const;
  /// Before the first frame: what Foxglove's clients are told of the sensors.
  void begin(const recording::RecordingSetup& setup);
  /// Whether anybody is there to whom a frame could be shown.
  bool has_viewers() const;
  /// Whether a frame of this observation is to be made. To be asked for each observation.
  bool wants(const slam::Observation& observation);
  /// Whether that frame is to have the map: ten times a second. It costs more than the rest of a frame.
  bool wants_map();
  void show(Frame frame);
  /// Returns when the run may go on.
  void pace(slam::Stamp t);
  /// Tells how the run ended, waits at most 15 s for pages that still fetch room and robot, and then at most
  /// 3 s until all is sent.
  void end(const std::string& how);

 private:
  void opened(Client& client);
  void received(Client& client, std::string_view text);
  bool command(const ClientMessage& message);
  Message pace_message() const;
  void send_strips(bool is_frame);
  Message strips_message(bool is_frame);

  bool control_;
  Pace pace_;
  Site site_;
  std::shared_ptr<Foxglove> foxglove_;    // set before the first observation, in the server's thread
  std::vector<exports::ImuReading> imu_;  // not sent yet
  std::chrono::steady_clock::time_point shown_{}, map_shown_{}, strips_shown_{};
  std::mutex strips_mutex_;
  Strips strips_;
  slam::Stamp period_ = std::chrono::milliseconds(34);  // a frame's
  Message last_;                                        // of the server's thread
  Server server_;                                       // last: its thread uses the members above
};

}  // namespace sim::view
