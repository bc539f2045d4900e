#include "sim/view/foxglove.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "sim/export/ros_messages.h"
#include "sim/files/json.h"
#include "sim/recording/image_file.h"
#include "sim/view/site.h"

namespace sim::view {
namespace {

using nlohmann::ordered_json;
namespace ros = exports::ros;

constexpr std::size_t kMostSubscribed = 64;
constexpr std::uint32_t kImu = 3;

/// Its number to clients is its place, from 1. payload: of a frame; empty if it has none.
struct Channel {
  const char* topic;
  const exports::MessageType& type;
  std::string (*payload)(const Frame& frame, const recording::RecordingSetup& setup);
};

const std::array<Channel, 6>& channels() {
  using Setup = recording::RecordingSetup;
  static const std::array<Channel, 6> all{
      {{"/camera/image/compressed", ros::kCompressedImage,
        [](const Frame& f, const Setup&) {
          return f.image.empty() ? ""
                                 : ros::compressed_image(f.t, "camera", recording::encode_grey_png(f.image));
        }},
       {"/camera/camera_info", ros::kCameraInfo,
        [](const Frame& f, const Setup& setup) {
          return f.image.empty() ? "" : ros::camera_info(f.t, "camera", setup.calibration.camera);
        }},
       {"/imu", ros::kImu, nullptr},  // of all observations, not only of frames
       {"/ground_truth/pose", ros::kPoseStamped,
        [](const Frame& f, const Setup&) {
          return f.truth ? ros::pose_stamped(f.t, "world", *f.truth) : "";
        }},
       {"/plan/pose", ros::kPoseStamped,
        [](const Frame& f, const Setup&) { return f.plan ? ros::pose_stamped(f.t, "world", *f.plan) : ""; }},
       {"/slam/pose", ros::kPoseWithCovarianceStamped, [](const Frame& f, const Setup&) {
          return f.estimate ? ros::pose_with_covariance_stamped(
                                  f.t, "world", *f.estimate, f.covariance.value_or(files::Matrix6d::Zero()))
                            : "";
        }}}};
  return all;
}

template <typename Number>
void put(std::string& to, Number x) {
  for (std::size_t byte = 0; byte < sizeof(Number); ++byte) to += static_cast<char>(x >> 8 * byte & 0xff);
}

ordered_json advertisement() {
  ordered_json list = ordered_json::array();
  for (const Channel& channel : channels())
    list.push_back({{"id", list.size() + 1},
                    {"topic", channel.topic},
                    {"encoding", "cdr"},
                    {"schemaName", channel.type.name},
                    {"schema", channel.type.definition},
                    {"schemaEncoding", "ros2msg"}});
  return {{"op", "advertise"}, {"channels", list}};
}

/// A binary message: op 1, subscription, log time, payload.
void send_one(Client& client, std::uint32_t subscription, slam::Stamp t, const std::string& payload) {
  if (payload.empty()) return;
  std::string bytes(1, '\1');
  put(bytes, subscription);
  put(bytes, static_cast<std::uint64_t>(recording::file_stamp(t)));
  client.send({std::make_shared<const std::string>(bytes + payload), false, true});
}

}  // namespace

Foxglove::Foxglove(const recording::RecordingSetup& setup) : setup_(setup), imu_(setup.imu_rate_hz) {}

void Foxglove::greet(Client& client) const {
  client.send(json_message({{"op", "serverInfo"},
                            {"name", "gaitslam"},
                            {"capabilities", ordered_json::array()},
                            {"supportedEncodings", ordered_json::array()},
                            {"metadata", ordered_json::object()},
                            {"sessionId", new_token()}}));
  client.send(json_message(advertisement()));
}

void Foxglove::process(Client& client, std::string_view said) const {
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
      if (channel < 1 || channel > channels().size() || client.subscriptions.size() >= kMostSubscribed)
        complain(fmt::format("unknown channel {} or too many subscriptions", channel));
      else
        client.subscriptions.push_back({id, channel});
    }
  } catch (const std::invalid_argument& error) {
    complain(error.what());
  }
}

void Foxglove::send(const Frame& frame, const std::vector<exports::ImuReading>& imu, Client& client) const {
  for (const auto& [subscription, channel] : client.subscriptions) {
    if (channel == kImu)
      for (const exports::ImuReading& reading : imu)
        send_one(client, subscription, reading.t, ros::imu(reading, "imu", 0, 0));
    else
      send_one(client, subscription, frame.t, channels()[channel - 1].payload(frame, setup_));
  }
}

}  // namespace sim::view
