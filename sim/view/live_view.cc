#include "sim/view/live_view.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "sim/files/json.h"
#include "sim/recording/image_file.h"

namespace sim::view {
namespace {

using nlohmann::ordered_json, std::chrono::steady_clock;
namespace ros = exports::ros;
using Json = nlohmann::json;

constexpr const char* kOwnProtocol = "gaitslam.view.v1";
// Minimum wall-clock time between two frames, maps, or updates of the time series.
constexpr std::chrono::milliseconds kLeastInterval{25}, kLeastMapInterval{100}, kLeastSeriesInterval{1000};
constexpr std::chrono::milliseconds kPastInterval{100};  // simulated, between past frames for a new page
constexpr std::chrono::milliseconds kForMessages{3000}, kForPages{15000};  // at the end
constexpr std::size_t kMostReadings = 400;  // IMU readings kept for the next frame
constexpr std::size_t kMostShown = 32;      // newest frames whose rig readings pages can fetch

bool is_own(const Client& client) { return client.protocol() == kOwnProtocol; }

constexpr std::uint32_t kImu = 3;

/// A Foxglove channel; its id is its place in kChannels, starting from 1. payload: of a frame, or "".
struct Channel {
  std::string topic;
  const exports::MessageType& type;
  std::string (*payload)(const Frame& frame, const recording::RecordingSetup& setup);
};

using Setup = recording::RecordingSetup;
const std::array<Channel, 6> kChannels{
    {{ros::kHeadTopics + ros::kImageTopic, ros::kCompressedImage,
      [](const Frame& f, const Setup&) {
        return f.image.empty()
                   ? ""
                   : ros::compressed_image(f.t, ros::kCameraFrame, recording::encode_png(f.image));
      }},
     {ros::kHeadTopics + ros::kInfoTopic, ros::kCameraInfo,
      [](const Frame& f, const Setup& setup) {
        return f.image.empty() ? "" : ros::camera_info(f.t, ros::kCameraFrame, setup.calibration.camera);
      }},
     {ros::kImuTopic, ros::kImu, nullptr},  // from all observations, not only from those with a frame
     {ros::kTrueTopics + ros::kPoseTopic, ros::kPoseStamped,
      [](const Frame& f, const Setup&) { return f.truth ? ros::pose_stamped(f.t, "world", *f.truth) : ""; }},
     {ros::kPlanTopics + ros::kPoseTopic, ros::kPoseStamped,
      [](const Frame& f, const Setup&) { return f.plan ? ros::pose_stamped(f.t, "world", *f.plan) : ""; }},
     {ros::kSlamTopics + ros::kPoseTopic, ros::kPoseWithCovarianceStamped, [](const Frame& f, const Setup&) {
        return f.estimate ? ros::pose_with_covariance_stamped(f.t, "world", *f.estimate,
                                                              f.covariance.value_or(files::Matrix6d::Zero()))
                          : "";
      }}}};

ordered_json advertisement() {
  ordered_json list = ordered_json::array();
  for (const Channel& channel : kChannels)
    list.push_back({{"id", list.size() + 1},
                    {"topic", channel.topic},
                    {"encoding", "cdr"},
                    {"schemaName", channel.type.name},
                    {"schema", channel.type.definition},
                    {"schemaEncoding", "ros2msg"}});
  return {{"op", "advertise"}, {"channels", list}};
}

/// Sends a binary message: op 1, subscription, log time (both in this machine's little-endian format),
/// payload.
void send_one(Client& client, std::uint32_t subscription, slam::Stamp t, const std::string& payload) {
  if (payload.empty()) return;
  const std::int64_t stamp = recording::file_stamp(t);
  std::string bytes(1, '\1');
  bytes.append(reinterpret_cast<const char*>(&subscription), sizeof subscription);
  bytes.append(reinterpret_cast<const char*>(&stamp), sizeof stamp);
  client.send({std::make_shared<const std::string>(bytes + payload)});
}

std::uint32_t number_of(const Json& value) {
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > 0xffffffffu)
    throw std::invalid_argument("expected 32-bit numbers");
  return value.get<std::uint32_t>();
}

const Json& short_list(const Json& list) {
  if (!list.is_array() || list.size() > kMostSubscriptions)
    throw std::invalid_argument("expected a list of at most 64 elements");
  return list;
}

/// Starts the Foxglove WebSocket protocol, with the messages of an exported run.mcap.
void greet(Client& client) {
  client.send(json_message({{"op", "serverInfo"},
                            {"name", "gaitslam"},
                            {"capabilities", ordered_json::array()},
                            {"supportedEncodings", ordered_json::array()},
                            {"metadata", ordered_json::object()},
                            {"sessionId", new_token()}}));
  client.send(json_message(advertisement()));
}

/// Updates a client's subscriptions; answers malformed messages and unknown channels with a status.
void process(Client& client, std::string_view said) {
  const auto complain = [&](const std::string& why) {
    client.send(json_message({{"op", "status"}, {"level", 1}, {"message", why}}));
  };
  const auto drop = [&](std::uint32_t id) {
    std::erase_if(client.subscriptions, [id](const auto& one) { return one.first == id; });
  };
  try {
    const ClientMessage message = read_client_message(said);
    for (const std::uint32_t id : message.unsubscribed) drop(id);
    for (const auto& [id, channel] : message.subscriptions) {
      drop(id);
      if (channel < 1 || channel > kChannels.size() || client.subscriptions.size() >= kMostSubscriptions)
        complain(fmt::format("unknown channel {} or too many subscriptions", channel));
      else
        client.subscriptions.push_back({id, channel});
    }
  } catch (const std::invalid_argument& error) {
    complain(error.what());
  }
}

void send_subscribed(Client& client, const Frame& frame, const std::vector<exports::ExportedReading>& imu,
                     const Setup& setup) {
  for (const auto& [subscription, channel] : client.subscriptions) {
    if (channel == kImu)
      for (const exports::ExportedReading& reading : imu)
        send_one(client, subscription, reading.t, ros::imu(reading, ros::kImuFrame, 0, 0));
    else
      send_one(client, subscription, frame.t, kChannels[channel - 1].payload(frame, setup));
  }
}

}  // namespace

LiveView::LiveView(const Access& access, ShownRun run, bool control)
    : control_(control),
      site_([&] {
        Site site({run}, {{"mode", "live"}, {"control", control}});
        add_rig(site, run.rig.size(), 0,
                [this](std::size_t sensor, std::size_t k) { return rig_reading(sensor, k); });
        return site;
      }()),
      rig_{Readings(run.rig.size()), 0, {}},
      series_(run.sole),
      server_(access, {[this](std::string_view path) { return site_.at(path, server_.access().token); },
                       {kOwnProtocol, "foxglove.websocket.v1", "foxglove.sdk.v1"},
                       [this](Client& client) { opened(client); },
                       [this](Client& client, std::string_view said) { received(client, said); },
                       [this](std::size_t viewers) {
                         if (viewers == 0) pace_.release();
                       }}) {}

void LiveView::begin(const recording::RecordingSetup& setup) {
  setup_ = setup;
  merger_.emplace(setup.imu_rate_hz);
  begun_ = true;
  period_ = slam::Stamp(static_cast<std::int64_t>(1e9 / setup.camera_rate_hz) + 1'000'000);
  server_.for_each([](Client& client) {
    if (!is_own(client)) greet(client);
  });
}

bool LiveView::has_viewers() const {
  return server_.with_room("gaitslam") > 0 || server_.with_room("foxglove") > 0;
}

void LiveView::wait_for_viewer() const {
  while (!has_viewers()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

bool LiveView::wants(const slam::Observation& observation) {
  ++frames_;
  const bool others = server_.with_room("foxglove") > 0;
  // Readings are merged even without a listener: a frame may split a reading, whose parts belong together.
  if (merger_)  // set by begin()
    for (exports::ExportedReading& reading : merger_->merge(observation))
      if (others && imu_.size() < kMostReadings) imu_.push_back(reading);
  const bool pages = server_.with_room("gaitslam") > 0;
  if (pages)
    for (const slam::RigReading& reading : observation.rig)
      rig_.newest.at(static_cast<std::size_t>(reading.sensor)) =
          std::make_shared<const slam::RigReading>(reading);
  due_ = others || (pages && steady_clock::now() - last_shown_.frame >= kLeastInterval);
  return due_;
}

bool LiveView::wants_map() {
  const auto now = steady_clock::now();
  if (!due_ || now - last_shown_.map < kLeastMapInterval) return false;
  last_shown_.map = now;
  return true;
}

void LiveView::show(Frame frame) {
  series_.add(frame);
  keep(frame);
  if (!std::exchange(due_, true)) return;
  last_shown_.frame = steady_clock::now();
  if (!rig_.newest.empty()) frame.rig = rig_.numbers++;
  Message message;
  if (server_.with_room("gaitslam") > 0)
    message.bytes = std::make_shared<const std::string>(to_message(frame));
  const bool others = server_.with_room("foxglove") > 0;
  server_.for_each([this, message, frame = others ? std::make_shared<const Frame>(frame) : nullptr,
                    imu = std::exchange(imu_, {}), number = frame.rig,
                    readings = rig_.newest](Client& client) {
    if (message.bytes) last_ = message;
    if (number && (rig_.shown.empty() || rig_.shown.back().first < *number)) {
      rig_.shown.emplace_back(*number, readings);
      if (rig_.shown.size() > kMostShown) rig_.shown.pop_front();
    }
    if (is_own(client) && message.bytes) client.send(message);
    if (!is_own(client) && frame) send_subscribed(client, *frame, imu, setup_);
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
    if (!is_own(client) || client.rows >= rows.size() || !(to_all || client.has_room())) return;
    ordered_json list = ordered_json::array();
    for (std::size_t i = client.rows; i < rows.size(); ++i) list.push_back(rows[i]);
    client.send(json_message(
        {{"op", "series"}, {"names", Series::kNames}, {"from", client.rows}, {"rows", std::move(list)}}));
    client.rows = rows.size();
  });
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
  send_series(true);
  send_to_pages(json_message({{"op", "ended"}, {"how", how}, {"frames", frames_}}));
  server_.flush(kForMessages, kForPages);
}

std::string LiveView::rig_reading(std::size_t sensor, std::size_t number) const {
  for (const auto& [shown, readings] : rig_.shown)
    if (shown == number && readings[sensor] && begun_)
      return pages::sent(*readings[sensor], setup_.rig.at(sensor));
  return "";
}

Message LiveView::pace_message() const {
  const Pace::State state = pace_.state();
  return json_message({{"op", "pace"}, {"paused", state.paused}, {"speed", state.speed}});
}

void LiveView::opened(Client& client) {
  if (is_own(client)) {
    client.send(pace_message());
    {
      const std::lock_guard lock(past_mutex_);
      if (!past_.empty())
        client.send({std::make_shared<const std::string>(
                         fmt::format("{{\"op\":\"past\",\"frames\":[{}]}}", fmt::join(past_, ","))),
                     false});
    }
    if (last_.bytes) client.send(last_);
  } else if (begun_) {
    greet(client);
  }
}

void LiveView::received(Client& client, std::string_view said) {
  if (!is_own(client)) {
    if (begun_) process(client, said);
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
  } else if (message.op == "subscribe") {
    for (const Json& one : short_list(json.at("subscriptions")))
      message.subscriptions.push_back({number_of(one.at("id")), number_of(one.at("channelId"))});
  } else if (message.op == "unsubscribe") {
    for (const Json& one : short_list(json.at("subscriptionIds")))
      message.unsubscribed.push_back(number_of(one));
  }
  return message;
} catch (const Json::exception&) {
  throw std::invalid_argument("malformed message");
}

}  // namespace sim::view
