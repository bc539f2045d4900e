#include "sim/view/live_view.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "sim/files/json.h"

namespace sim::view {
namespace {

using nlohmann::ordered_json;
using std::chrono::steady_clock;

constexpr const char* kOwnProtocol = "gaitslam.view.v1";
// Between two frames, maps, or drawings of the strips, by the wall clock.
constexpr std::chrono::milliseconds kLeastInterval{25}, kLeastMapInterval{100}, kLeastStripsInterval{1000};
constexpr std::chrono::milliseconds kForMessages{3000}, kForPages{15000};  // at the end
constexpr std::size_t kMostReadings = 400;  // of the IMU, kept for the next frame

bool is_own(const Client& client) { return client.protocol() == kOwnProtocol; }

}  // namespace

LiveView::LiveView(const Access& access, ShownRun run, bool control)
    : control_(control),
      site_({std::move(run)}, {{"mode", "live"}, {"control", control}}),
      server_(access, {[this](std::string_view path) { return site_.at(path, server_.access().token); },
                       {kOwnProtocol, kFoxgloveProtocols[0], kFoxgloveProtocols[1]},
                       [this](Client& client) { opened(client); },
                       [this](Client& client, std::string_view said) { received(client, said); },
                       [this](std::size_t viewers) {
                         if (viewers == 0) pace_.release();
                       }}) {}

void LiveView::begin(const recording::RecordingSetup& setup) {
  auto foxglove = std::make_shared<Foxglove>(setup);
  period_ = slam::Stamp(static_cast<std::int64_t>(1e9 / setup.camera_rate_hz) + 1'000'000);
  std::atomic_store(&foxglove_, foxglove);
  server_.for_each([foxglove](Client& client) {
    if (!is_own(client)) foxglove->greet(client);
  });
}

bool LiveView::has_viewers() const {
  return server_.with_room("gaitslam") > 0 || server_.with_room("foxglove") > 0;
}

void LiveView::wait_for_viewer() const {
  while (!has_viewers()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

bool LiveView::wants(const slam::Observation& observation) {
  const bool others = server_.with_room("foxglove") > 0;
  if (others)
    for (exports::ImuReading& reading : foxglove_->merged(observation))
      if (imu_.size() < kMostReadings) imu_.push_back(reading);
  return others || (server_.with_room("gaitslam") > 0 && steady_clock::now() - shown_ >= kLeastInterval);
}

bool LiveView::wants_map() {
  const auto now = steady_clock::now();
  if (now - map_shown_ < kLeastMapInterval) return false;
  map_shown_ = now;
  return true;
}

void LiveView::show(Frame frame) {
  shown_ = steady_clock::now();
  strips_.add(frame);
  Message message;
  if (server_.with_room("gaitslam") > 0)
    message = {std::make_shared<const std::string>(to_message(frame)), false, true};
  const bool others = server_.with_room("foxglove") > 0;
  server_.for_each([this, message, frame = others ? std::make_shared<const Frame>(frame) : nullptr,
                    imu = std::exchange(imu_, {})](Client& client) {
    if (message.bytes) last_ = message;
    if (is_own(client) && message.bytes) client.send(message);
    if (!is_own(client) && frame) foxglove_->send(*frame, imu, client);
  });
  if (shown_ - strips_shown_ < kLeastStripsInterval || !message.bytes) return;
  strips_shown_ = shown_;
  send_strips(true);
}

void LiveView::send_strips(bool is_frame) {
  Message message = json_message({{"op", "strips"}, {"html", strips_html(strips_.figures())}});
  message.is_frame = is_frame;
  send_to_pages(message);
}

void LiveView::send_to_pages(const Message& message) {
  server_.for_each([message](Client& client) {
    if (is_own(client)) client.send(message);
  });
}

void LiveView::pace(slam::Stamp t) {
  if (control_) pace_.wait(t);
}

void LiveView::end(const std::string& how) {
  send_strips(false);
  send_to_pages(json_message({{"op", "ended"}, {"how", how}}));
  server_.flush(kForMessages, kForPages);
}

Message LiveView::pace_message() const {
  const Pace::State state = pace_.state();
  return json_message({{"op", "pace"}, {"paused", state.paused}, {"speed", state.speed}});
}

void LiveView::opened(Client& client) {
  if (is_own(client)) {
    client.send(pace_message());
    if (last_.bytes) client.send(last_);
  } else if (const auto foxglove = std::atomic_load(&foxglove_)) {
    foxglove->greet(client);
  }
}

void LiveView::received(Client& client, std::string_view said) {
  if (!is_own(client)) {
    if (const auto foxglove = std::atomic_load(&foxglove_)) foxglove->process(client, said);
    return;
  }
  const auto reject = [&](const std::string& why) {
    client.send(json_message({{"op", "rejected"}, {"why", why}}));
  };
  try {
    const ClientMessage message = read_client_message(said);
    if (message.op == "loaded")
      client.loading = false;
    else if (!control_)
      reject("this view is read-only: start it with --control");
    else
      command(message);
  } catch (const std::invalid_argument& error) {
    reject(error.what());
  }
}

void LiveView::command(const ClientMessage& message) {
  if (message.op == "pause")
    pace_.pause();
  else if (message.op == "resume")
    pace_.resume();
  else if (message.op == "step")
    pace_.step(period_);
  else if (message.op == "speed")
    pace_.set_speed(message.factor);
  else
    throw std::invalid_argument("unknown op");
  send_to_pages(pace_message());
}

}  // namespace sim::view
