#include "sim/view/server.h"

namespace sim::view {
namespace {

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
