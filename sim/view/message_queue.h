// What waits to be sent to one client: bounded, so that a client that does not read costs nothing.
#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace sim::view {

/// One WebSocket message, shared by all who are sent it.
struct Message {
  std::shared_ptr<const std::string> bytes;
  bool text = false;
  bool is_frame = true;  ///< may be dropped for a newer one
};

/// At most `most_frames` frames wait, of which the oldest is dropped, and `most_others` messages that must
/// not be lost.
class MessageQueue {
 public:
  MessageQueue(std::size_t most_frames, std::size_t most_others)
      : most_frames_(most_frames), most_others_(most_others) {}

  /// False where a message that must not be lost has no room: the client is to be given up.
  bool push(Message message) {
    if (!message.is_frame && waiting_.size() - frames_ >= most_others_) return false;
    if (message.is_frame && frames_ >= most_frames_) drop_oldest_frame();
    frames_ += message.is_frame ? 1 : 0;
    waiting_.push_back(std::move(message));
    return true;
  }

  std::optional<Message> pop() {
    if (waiting_.empty()) return std::nullopt;
    Message message = std::move(waiting_.front());
    waiting_.pop_front();
    frames_ -= message.is_frame ? 1 : 0;
    return message;
  }

  /// For the messages of another frame, without dropping any.
  bool has_room() const { return 2 * frames_ <= most_frames_; }
  std::size_t size() const { return waiting_.size(); }
  std::size_t dropped() const { return dropped_; }

 private:
  void drop_oldest_frame() {
    waiting_.erase(
        std::find_if(waiting_.begin(), waiting_.end(), [](const Message& m) { return m.is_frame; }));
    --frames_;
    ++dropped_;
  }

  std::deque<Message> waiting_;
  std::size_t most_frames_, most_others_, frames_ = 0, dropped_ = 0;
};

}  // namespace sim::view
