#include "sim/view/client_message.h"
#include "sim/view/server.h"

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

Message frame(const std::string& text) { return {std::make_shared<const std::string>(text), false, true}; }
Message word(const std::string& text) { return {std::make_shared<const std::string>(text), true, false}; }

TEST(MessageQueue, TheOldestFrameIsDropped) {
  MessageQueue queue(3, 10);
  for (const char* const text : {"1", "2", "3", "4", "5"}) EXPECT_TRUE(queue.push(frame(text)));
  EXPECT_EQ(queue.dropped(), 2u);
  for (const char* const text : {"3", "4", "5"}) EXPECT_EQ(*queue.pop()->bytes, text);
  EXPECT_FALSE(queue.pop().has_value());
}

TEST(MessageQueue, WhatIsNoFrameIsNeverDropped) {
  MessageQueue queue(1, 2);
  EXPECT_TRUE(queue.push(word("a")));
  EXPECT_TRUE(queue.push(frame("1")));
  EXPECT_TRUE(queue.push(frame("2")));
  EXPECT_TRUE(queue.push(word("b")));
  EXPECT_FALSE(queue.push(word("c"))) << "no room: the client is to be given up";
  for (const char* const text : {"a", "2", "b"}) EXPECT_EQ(*queue.pop()->bytes, text);
}

TEST(MessageQueue, ThereIsRoomWhileHalfOfItIsFree) {
  MessageQueue queue(4, 1);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(queue.has_room()) << i;
    queue.push(frame("x"));
  }
  EXPECT_FALSE(queue.has_room());
  queue.pop();
  EXPECT_TRUE(queue.has_room());
}

}  // namespace
}  // namespace sim::view
