#include "sim/view/live_view.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "sim/files/json.h"

namespace sim::view {
namespace {

using nlohmann::ordered_json, std::chrono::steady_clock;
using Json = nlohmann::json;

// Minimum wall-clock time between two frames, maps, or updates of the time series.
constexpr std::chrono::milliseconds kLeastInterval{25}, kLeastMapInterval{100}, kLeastSeriesInterval{1000};
// Simulated time between past frames sent to a new page.
constexpr std::chrono::milliseconds kPastInterval{100};
constexpr std::chrono::milliseconds kForMessages{3000}, kForPages{15000};  // at the end
constexpr std::size_t kMostShown = 32;  // newest frames whose rig readings pages can fetch

}  // namespace

LiveView::LiveView(const Access& access, ShownRun run, bool control, bool real_time)
    : control_(control),
      real_time_(real_time),
      site_([&] {
        Site site({run}, {{"mode", "live"}, {"control", control}});
        add_rig(site, run.rig.size(), 0,
                [this](std::size_t sensor, std::size_t k) { return rig_reading(sensor, k); });
        return site;
      }()),
      rig_{Readings(run.rig.size()), 0, {}},
      footing_(run.sole),
      server_(access, {[this](std::string_view path) { return site_.at(path, server_.access().token); },
                       "gaitslam.view.v1", [this](Client& client) { opened(client); },
                       [this](Client& client, std::string_view said) { received(client, said); },
                       [this](std::size_t viewers) {
                         if (viewers == 0) pace_.release();
                       }}) {
  if (real_time) pace_.obey({"speed", 1});
}

void LiveView::begin(const recording::RecordingSetup& setup) {
  setup_ = setup;
  begun_ = true;
  period_ = slam::Stamp(static_cast<std::int64_t>(1e9 / setup.camera_rate_hz) + 1'000'000);
}

void LiveView::wait_for_viewer() const {
  while (!has_viewers()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

bool LiveView::wants(const slam::Observation& observation) {
  ++frames_;
  const bool has_viewers = server_.has_room();
  if (has_viewers)
    for (const slam::RigReading& reading : observation.rig)
      rig_.newest.at(static_cast<std::size_t>(reading.sensor)) =
          std::make_shared<const slam::RigReading>(reading);
  due_ = has_viewers && steady_clock::now() - last_shown_.frame >= kLeastInterval;
  return due_;
}

bool LiveView::wants_map() {
  const auto now = steady_clock::now();
  if (!due_ || now - last_shown_.map < kLeastMapInterval) return false;
  last_shown_.map = now;
  return true;
}

void LiveView::show(Frame frame) {
  footing_.add(frame);
  series_.add(frame);
  keep(frame);
  if (!std::exchange(due_, true)) return;
  last_shown_.frame = steady_clock::now();
  if (!rig_.newest.empty()) frame.rig = rig_.numbers++;
  Message message;
  if (server_.has_room()) message.bytes = std::make_shared<const std::string>(to_message(frame));
  server_.for_each([this, message, number = frame.rig, readings = rig_.newest](Client& client) {
    if (message.bytes) last_ = message;
    if (number && (rig_.shown.empty() || rig_.shown.back().first < *number)) {
      rig_.shown.emplace_back(*number, readings);
      if (rig_.shown.size() > kMostShown) rig_.shown.pop_front();
    }
    if (message.bytes) client.send(message);
  });
  if (last_shown_.frame - last_shown_.series >= kLeastSeriesInterval) send_series(false);
}

void LiveView::keep(Frame frame) {
  if (!past_.empty() && frame.t < kept_until_) return;
  kept_until_ = frame.t + kPastInterval;
  frame.image.release(), frame.map.reset(), frame.rig.reset();
  if (frame.report) frame.report->searched.clear(), frame.report->initialized.clear();
  const std::lock_guard lock(past_mutex_);
  past_.push_back(files::json_text(to_json(frame)));
}

void LiveView::send_series(bool to_all) {
  last_shown_.series = last_shown_.frame;
  server_.for_each([to_all, rows = series_.rows()](Client& client) {
    if (client.rows >= rows.size() || !(to_all || client.has_room())) return;
    ordered_json list = ordered_json::array();
    for (std::size_t i = client.rows; i < rows.size(); ++i) list.push_back(rows[i]);
    client.send(json_message(
        {{"op", "series"}, {"names", Series::kNames}, {"from", client.rows}, {"rows", std::move(list)}}));
    client.rows = rows.size();
  });
}

void LiveView::send_to_pages(const Message& message) {
  server_.for_each([message](Client& client) { client.send(message); });
}

void LiveView::pace(slam::Stamp t) {
  if (control_ || real_time_) pace_.wait(t);
}

void LiveView::end(const std::string& how, std::optional<Playback> finished) {
  if (finished) {
    site_.replace(playback_site({std::move(*finished)}, {{"how", how}}));
    finished_ = true;
    return send_to_pages(json_message({{"op", "finished"}}));
  }
  send_series(true);
  send_to_pages(json_message({{"op", "ended"}, {"how", how}, {"frames", frames_}}));
  server_.flush(kForMessages, kForPages);
}

std::string LiveView::rig_reading(std::size_t sensor, std::size_t number) const {
  for (const auto& [shown, readings] : rig_.shown)
    if (shown == number && readings[sensor] && begun_) return sent(*readings[sensor], setup_.rig.at(sensor));
  return "";
}

Message LiveView::pace_message() const {
  const Pace::State state = pace_.state();
  return json_message({{"op", "pace"}, {"paused", state.paused}, {"speed", state.speed}});
}

void LiveView::opened(Client& client) {
  if (finished_) return client.send(json_message({{"op", "finished"}}));
  client.send(pace_message());
  {
    const std::lock_guard lock(past_mutex_);
    if (!past_.empty())
      client.send({std::make_shared<const std::string>(
                       fmt::format("{{\"op\":\"past\",\"frames\":[{}]}}", fmt::join(past_, ","))),
                   false});
  }
  if (last_.bytes) client.send(last_);
}

void LiveView::received(Client& client, std::string_view said) {
  const auto reject = [&](const std::string& why) {
    client.send(json_message({{"op", "rejected"}, {"why", why}}));
  };
  try {
    const ClientMessage message = read_client_message(said);
    if (message.op == "loaded")
      client.loading = false;
    else if (!control_)
      reject("this view is read-only; start the run with --control");
    else if (pace_.obey(message, period_))
      send_to_pages(pace_message());
    else
      reject("unknown op");
  } catch (const std::invalid_argument& error) {
    reject(error.what());
  }
}

ClientMessage read_client_message(std::string_view text) try {
  const Json json = Json::parse(text);
  ClientMessage message{json.at("op").get<std::string>()};
  if (message.op == "speed") {
    message.factor = json.at("factor").get<double>();
    if (message.factor != 0 && !(message.factor >= 0.01 && message.factor <= 100))
      throw std::invalid_argument("speed: expected a factor from 0.01 to 100, or 0");
  }
  return message;
} catch (const Json::exception&) {
  throw std::invalid_argument("malformed message");
}

}  // namespace sim::view
