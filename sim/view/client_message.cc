#include "sim/view/client_message.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

namespace sim::view {
namespace {

using Json = nlohmann::json;

constexpr std::array kIgnored{"advertise",
                              "unadvertise",
                              "getParameters",
                              "setParameters",
                              "subscribeParameterUpdates",
                              "unsubscribeParameterUpdates",
                              "subscribeConnectionGraph",
                              "unsubscribeConnectionGraph",
                              "fetchAsset"};

std::optional<std::uint32_t> number_of(const Json& value) {
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > 0xffffffffu) return std::nullopt;
  return value.get<std::uint32_t>();
}

std::optional<std::uint32_t> number_at(const Json& object, const char* key) {
  if (!object.is_object() || !object.contains(key)) return std::nullopt;
  return number_of(object[key]);
}

bool is_list(const Json& message, const char* key) {
  return message.contains(key) && message[key].is_array() && message[key].size() <= kMostSubscriptions;
}

ClientMessage subscribe(const Json& message) {
  if (!is_list(message, "subscriptions"))
    return Malformed{"subscribe: expected a short list of subscriptions"};
  Subscribe all;
  for (const Json& one : message["subscriptions"]) {
    const auto id = number_at(one, "id"), channel = number_at(one, "channelId");
    if (!id || !channel) return Malformed{"subscribe: expected id and channelId"};
    all.subscriptions.push_back({*id, *channel});
  }
  return all;
}

ClientMessage unsubscribe(const Json& message) {
  if (!is_list(message, "subscriptionIds"))
    return Malformed{"unsubscribe: expected a short list of subscriptionIds"};
  Unsubscribe all;
  for (const Json& one : message["subscriptionIds"]) {
    const auto id = number_of(one);
    if (!id) return Malformed{"unsubscribe: expected numbers"};
    all.subscriptions.push_back(*id);
  }
  return all;
}

ClientMessage speed(const Json& message) {
  const double factor =
      message.contains("factor") && message["factor"].is_number() ? message["factor"].get<double>() : NAN;
  if (factor == 0 || (factor >= 0.01 && factor <= 100)) return Speed{factor};
  return Malformed{"speed: expected a factor of 0.01 to 100, or 0"};
}

}  // namespace

ClientMessage read_client_message(std::string_view text) {
  const Json message = Json::parse(text, nullptr, false);
  if (!message.is_object() || !message.contains("op") || !message["op"].is_string())
    return Malformed{"expected a JSON object with op"};
  const auto& op = message["op"].get_ref<const std::string&>();
  if (op == "pause") return Pause{};
  if (op == "resume") return Resume{};
  if (op == "step") return Step{};
  if (op == "speed") return speed(message);
  if (op == "loaded") return Loaded{};
  if (op == "subscribe") return subscribe(message);
  if (op == "unsubscribe") return unsubscribe(message);
  for (const char* const known : kIgnored)
    if (op == known) return Ignored{};
  return Malformed{"unknown op"};
}

}  // namespace sim::view
