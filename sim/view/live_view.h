// The view of a live run: the speed set by viewers, and the messages from clients.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>

#include "sim/tracking/tracking.h"
#include "sim/view/server.h"
#include "sim/view/site.h"
#include "slam/observation.h"

namespace sim::view {

/// op: "pause", "resume", "step" (run for one camera frame), "speed", "loaded" (the page has fetched room and
/// robot); others are ignored.
struct ClientMessage {
  std::string op;
  double factor = 0;  ///< for "speed": times real time; 0: full speed
};

/// Parses a message. Throws std::invalid_argument if the text is not a message.
ClientMessage read_client_message(std::string_view text);

/// The speed of a run. Commands come from one thread; the run waits in another.
class Pace {
 public:
  struct State {
    bool paused = false;
    double speed = 0;  ///< times real time; 0: full speed
  };

  /// Executes "pause", "resume", "step" (run for `period` of simulated time, then pause) or "speed"; returns
  /// false for other messages.
  bool obey(const ClientMessage& message, slam::Stamp period = {}) {
    const std::string& op = message.op;
    const bool pauses = op == "pause" || op == "step", resumes = op == "resume";
    if (!pauses && !resumes && op != "speed") return false;
    change([&] {
      if (op == "step") until_ = (state_.paused ? std::max(until_, now_) : now_) + period;
      if (op == "pause") until_ = now_;
      if (op == "speed") state_.speed = message.factor;
      if (op != "speed") state_.paused = pauses;
    });
    return true;
  }
  /// Resumes at full speed, as if there were no controlling viewer.
  void release() {
    change([&] { state_ = {}; });
  }
  State state() const {
    const std::lock_guard lock(mutex_);
    return state_;
  }

  /// Blocks the run at simulated time t until it may continue.
  void wait(slam::Stamp t) {
    std::unique_lock lock(mutex_);
    for (now_ = t; state_.paused ? t >= until_ : state_.speed > 0;) {
      if (state_.paused) {
        changed_.wait(lock);
        continue;
      }
      const auto due = from_clock_ + std::chrono::duration_cast<Clock::duration>((t - from_) / state_.speed);
      if (Clock::now() >= due) return;
      changed_.wait_until(lock, due);
    }
  }

 private:
  using Clock = std::chrono::steady_clock;

  void change(const auto& set) {
    const std::lock_guard lock(mutex_);
    set();
    from_ = now_, from_clock_ = Clock::now();
    changed_.notify_all();
  }

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  State state_;
  slam::Stamp now_{0}, until_{0};  // while paused, the run continues until until_
  slam::Stamp from_{0};            // simulated time at from_clock_
  Clock::time_point from_clock_ = Clock::now();
};

/// Serves one run. The run's thread waits only in pace(), if a client with control paused or slowed down the
/// run. Frames are made only for clients with room for them, at most 40 per second.
class LiveView {
 public:
  /// control: clients may pause the run, step it and set its speed. real_time: starts at that speed. Throws
  /// as Server does.
  LiveView(const Access& access, ShownRun run, bool control, bool real_time = false);
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  const Access& access() const { return server_.access(); }

  void wait_for_viewer() const;
  /// Describes the sensors, before the first frame.
  void begin(const recording::RecordingSetup& setup);
  /// Returns whether a viewer has room for a frame.
  bool has_viewers() const { return server_.has_room(); }
  /// Returns whether a frame of this observation should be sent. Must be called for each observation.
  bool wants(const slam::Observation& observation);
  /// Returns whether that frame needs the map: ten times per second, because it costs more than the rest.
  bool wants_map();
  /// Stores a frame's values for the figures and for pages opened later, and sends it if wants() was true.
  void show(Frame frame);
  /// Waits until the run may continue.
  void pace(slam::Stamp t);
  /// Reports how the run ended. Waits up to 15 s for pages that are loading, then up to 3 s to send
  /// everything. finished: instead turns the pages, and those opened later, into its playback.
  void end(const std::string& how, std::optional<Playback> finished = {});

 private:
  void opened(Client& client);
  void received(Client& client, std::string_view text);
  Message pace_message() const;
  void keep(Frame frame);
  void send_series(bool to_all);  ///< to_all: even to pages without room
  void send_to_pages(const Message& message);
  std::string rig_reading(std::size_t sensor, std::size_t number) const;

  /// The newest reading of each rig sensor when a frame was shown; null: none yet.
  using Readings = std::vector<std::shared_ptr<const slam::RigReading>>;

  bool control_, real_time_;
  std::atomic<bool> finished_ = false;
  Pace pace_;
  ServedSite site_;
  recording::RecordingSetup setup_;  // set before begun_, then constant
  std::atomic<bool> begun_ = false;
  struct {
    Readings newest;
    std::size_t numbers = 0;                             // number of frames with readings
    std::deque<std::pair<std::size_t, Readings>> shown;  // by number; used by the server's thread
  } rig_;
  struct {
    std::chrono::steady_clock::time_point frame{}, map{}, series{};
  } last_shown_;
  std::size_t frames_ = 0;
  bool due_ = true;  // a frame of this observation will be sent
  Footing footing_;
  Series series_;
  std::mutex past_mutex_;
  std::vector<std::string> past_;  // frames without images, for pages opened later
  slam::Stamp kept_until_{0};
  slam::Stamp period_ = std::chrono::milliseconds(34);  // of one frame
  Message last_;                                        // used by the server's thread
  Server server_;                                       // last member: its thread uses the members above
};

}  // namespace sim::view
