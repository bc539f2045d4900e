#include "sim/view/foxglove.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "sim/export/ros_messages.h"
#include "sim/files/json.h"
#include "sim/recording/grey_png.h"
#include "sim/view/site.h"

namespace sim::view {
namespace {

using nlohmann::ordered_json;
namespace ros = exports::ros;

constexpr std::uint32_t kImage = 1, kInfo = 2, kImu = 3, kTruth = 4, kPlan = 5, kEstimate = 6;
constexpr std::size_t kMostSubscribed = 64;

struct Channel {
  std::uint32_t id;
  const char* topic;
  const exports::MessageType& type;
};

const std::array<Channel, 6>& channels() {
  static const std::array<Channel, 6> all{{{kImage, "/camera/image/compressed", ros::kCompressedImage},
                                           {kInfo, "/camera/camera_info", ros::kCameraInfo},
                                           {kImu, "/imu", ros::kImu},
                                           {kTruth, "/ground_truth/pose", ros::kPoseStamped},
                                           {kPlan, "/plan/pose", ros::kPoseStamped},
                                           {kEstimate, "/slam/pose", ros::kPoseWithCovarianceStamped}}};
  return all;
}

template <typename Number>
void put(std::string& to, Number x) {
  for (std::size_t byte = 0; byte < sizeof(Number); ++byte) to += static_cast<char>(x >> 8 * byte & 0xff);
}

ordered_json advertisement() {
  ordered_json list = ordered_json::array();
  for (const Channel& channel : channels())
    list.push_back({{"id", channel.id},
                    {"topic", channel.topic},
                    {"encoding", "cdr"},
                    {"schemaName", channel.type.name},
                    {"schema", channel.type.definition},
                    {"schemaEncoding", "ros2msg"}});
  return {{"op", "advertise"}, {"channels", list}};
}

bool is_channel(std::uint32_t id) {
  return std::any_of(channels().begin(), channels().end(), [id](const Channel& c) { return c.id == id; });
}

void complain(Client& client, const std::string& why) {
  client.send(json_message({{"op", "status"}, {"level", 1}, {"message", why}}));
}

void subscribe(Client& client, const Subscribe& message) {
  for (const auto& [id, channel] : message.subscriptions) {
    std::erase_if(client.subscriptions, [id = id](const auto& one) { return one.first == id; });
    if (!is_channel(channel) || client.subscriptions.size() >= kMostSubscribed)
      complain(client, fmt::format("unknown channel {} or too many subscriptions", channel));
    else
      client.subscriptions.push_back({id, channel});
  }
}

std::string payload(std::uint32_t channel, const Frame& frame, const recording::RecordingSetup& setup) {
  const std::string camera = "camera", world = "world";
  switch (channel) {
    case kImage:
      return frame.image.empty()
                 ? ""
                 : ros::compressed_image(frame.t, camera, recording::encode_grey_png(frame.image));
    case kInfo:
      return frame.image.empty() ? "" : ros::camera_info(frame.t, camera, setup.calibration.camera);
    case kTruth:
      return frame.truth ? ros::pose_stamped(frame.t, world, *frame.truth) : "";
    case kPlan:
      return frame.plan ? ros::pose_stamped(frame.t, world, *frame.plan) : "";
    case kEstimate:
      return frame.estimate
                 ? ros::pose_with_covariance_stamped(frame.t, world, *frame.estimate,
                                                     frame.covariance.value_or(files::Matrix6d::Zero()))
                 : "";
    default:
      return "";
  }
}

void send_one(Client& client, std::uint32_t subscription, slam::Stamp t, const std::string& bytes) {
  if (bytes.empty()) return;
  const auto ns = static_cast<std::uint64_t>(recording::file_stamp(t));
  client.send({std::make_shared<const std::string>(foxglove_message(subscription, ns, bytes)), false, true});
}

}  // namespace

std::string foxglove_message(std::uint32_t subscription, std::uint64_t t_ns, std::string_view payload) {
  std::string bytes(1, '\1');
  put(bytes, subscription);
  put(bytes, t_ns);
  return bytes.append(payload);
}

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

void Foxglove::process(Client& client, const ClientMessage& message) const {
  if (const auto* const wanted = std::get_if<Subscribe>(&message)) return subscribe(client, *wanted);
  if (const auto* const unwanted = std::get_if<Unsubscribe>(&message)) {
    for (const std::uint32_t id : unwanted->subscriptions)
      std::erase_if(client.subscriptions, [id](const auto& one) { return one.first == id; });
  } else if (const auto* const malformed = std::get_if<Malformed>(&message)) {
    complain(client, malformed->why);
  }
}

void Foxglove::send(const Frame& frame, const std::vector<exports::ImuReading>& imu, Client& client) const {
  for (const auto& [subscription, channel] : client.subscriptions) {
    if (channel == kImu)
      for (const exports::ImuReading& reading : imu)
        send_one(client, subscription, reading.t, ros::imu(reading, "imu", 0, 0));
    else
      send_one(client, subscription, frame.t, payload(channel, frame, setup_));
  }
}

}  // namespace sim::view
