#include "sim/view/client_message.h"

#include <nlohmann/json.hpp>
#include <stdexcept>

namespace sim::view {
namespace {

using Json = nlohmann::json;

std::uint32_t number_of(const Json& value) {
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > 0xffffffffu)
    throw std::invalid_argument("expected numbers of 32 bits");
  return value.get<std::uint32_t>();
}

const Json& short_list(const Json& list) {
  if (!list.is_array() || list.size() > kMostSubscriptions)
    throw std::invalid_argument("expected a short list");
  return list;
}

}  // namespace

ClientMessage read_client_message(std::string_view text) try {
  const Json json = Json::parse(text);
  ClientMessage message{json.at("op").get<std::string>()};
  if (message.op == "speed") {
    message.factor = json.at("factor").get<double>();
    if (message.factor != 0 && !(message.factor >= 0.01 && message.factor <= 100))
      throw std::invalid_argument("speed: expected a factor of 0.01 to 100, or 0");
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
