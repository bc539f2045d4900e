#include "sim/view/client_message.h"

namespace sim::view {
namespace {

template <class Kind>
bool is(const std::string& text) {
  return std::holds_alternative<Kind>(read_client_message(text));
}

TEST(ClientMessage, CommandsAreRead) {
  EXPECT_TRUE(is<Pause>(R"({"op":"pause"})"));
  EXPECT_TRUE(is<Resume>(R"({"op":"resume"})"));
  EXPECT_TRUE(is<Step>(R"({"op":"step"})"));
  EXPECT_EQ(std::get<Speed>(read_client_message(R"({"op":"speed","factor":0.25})")).factor, 0.25);
  EXPECT_EQ(std::get<Speed>(read_client_message(R"({"op":"speed","factor":0})")).factor, 0);
}

TEST(ClientMessage, SubscriptionsOfFoxgloveAreRead) {
  const auto message = read_client_message(
      R"({"op":"subscribe","subscriptions":[{"id":7,"channelId":2},{"id":8,"channelId":4294967295}]})");
  using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
  EXPECT_EQ(std::get<Subscribe>(message).subscriptions, (Pairs{{7, 2}, {8, 4294967295u}}));
  EXPECT_EQ(std::get<Unsubscribe>(read_client_message(R"({"op":"unsubscribe","subscriptionIds":[7]})"))
                .subscriptions,
            std::vector<std::uint32_t>{7});
}

TEST(ClientMessage, OthersOfFoxgloveAreIgnored) {
  EXPECT_TRUE(is<Ignored>(R"({"op":"getParameters","parameterNames":[]})"));
}

TEST(ClientMessage, WhatIsNoMessageIsMalformed) {
  std::string many = R"({"op":"unsubscribe","subscriptionIds":[0)";
  for (int i = 0; i < 64; ++i) many += ",1";
  for (const std::string text : {"", "x", "{", "[1]", "{}", R"({"op":1})", R"({"op":"fly"})",
                                 R"({"op":"speed","factor":1e9})", R"({"op":"speed","factor":"1"})",
                                 R"({"op":"subscribe"})", R"({"op":"subscribe","subscriptions":[1]})",
                                 R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]})",
                                 R"({"op":"subscribe","subscriptions":[{"id":4294967296,"channelId":1}]})",
                                 R"({"op":"unsubscribe","subscriptionIds":["a"]})"})
    EXPECT_TRUE(is<Malformed>(text)) << text;
  EXPECT_TRUE(is<Malformed>(many + "]}"));
  EXPECT_TRUE(is<Malformed>(std::string(8000, '[')));
}

}  // namespace
}  // namespace sim::view
