// The view's server: a fixed list of files over HTTP and messages over WebSocket, in its own thread; and its
// address, its token, and the rules for each request.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sim::view {

/// The listening address, and the secret that each request must contain.
struct Access {
  std::string address = "127.0.0.1";  ///< numeric, of this machine
  std::uint16_t port = 0;             ///< 0: any free port, known once the server listens
  std::string token = {};             ///< empty: 128 random bits
  /// Each [http[s]://]HOST[:PORT][/PATH] that also leads here, through ssh -L or a proxy; a scheme or a port
  /// is needed, and port 443 means https.
  std::vector<std::string> forwarded = {};
};

/// Returns the access with a token, which is generated if missing. Throws std::invalid_argument if the
/// address is invalid, means all interfaces, or can be reached by others although no token is given. Also
/// throws if a token is shorter than 22 characters or has characters other than letters, digits, - and _, or
/// if one of `forwarded` has a different form.
Access checked(Access access);

/// Returns 128 bits from the system's random source as 32 hex digits. Throws std::runtime_error if it fails.
std::string new_token();

/// Returns whether the texts are equal, in a time that depends only on their lengths.
bool equal_in_constant_time(std::string_view a, std::string_view b);

/// Returns address and port as in a URL, with IPv6 in brackets.
std::string authority(const Access& access);
/// Returns the URL for the browser, with the first forwarded address if there is one.
std::string url(const Access& access);
/// Returns the path of a request to the server, without the path of a forwarded address.
std::string_view served_path(std::string_view target, const Access& access);

/// The checked part of a request.
struct RequestHead {
  std::string_view method, target, host;
  std::optional<std::string_view> origin = std::nullopt;
};

struct Rejection {
  unsigned status;
  std::string why;
};

/// Returns a rejection for the first broken rule: Host must be exactly the server's authority or one of
/// Access::forwarded (against DNS rebinding); an Origin must have that host; the query must contain the
/// token; the method must be GET.
std::optional<Rejection> rejection(const RequestHead& request, const Access& access);

/// One WebSocket message, shared by its receivers.
struct Message {
  std::shared_ptr<const std::string> bytes;
  bool is_frame = true;  ///< binary, and may be dropped in favor of a newer one; otherwise text
};

/// Bounded queue, so that a client that does not read costs nothing: at most `most_frames` frames (the oldest
/// is dropped) and `most_others` messages that must not be lost.
class MessageQueue {
 public:
  MessageQueue(std::size_t most_frames, std::size_t most_others)
      : most_frames_(most_frames), most_others_(most_others) {}

  /// Returns false if there is no room for a message other than a frame; the client must then be dropped.
  bool push(Message message) {
    if (!message.is_frame && waiting_.size() - frames_ >= most_others_) return false;
    if (message.is_frame && ++frames_ > most_frames_) {
      waiting_.erase(std::ranges::find_if(waiting_, &Message::is_frame));
      --frames_;
    }
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

  /// Returns whether the messages of another frame fit without dropping any.
  bool has_room() const { return 2 * frames_ <= most_frames_; }
  std::size_t size() const { return waiting_.size(); }

 private:
  std::deque<Message> waiting_;
  std::size_t most_frames_, most_others_, frames_ = 0;
};

/// A file as it is served.
struct Resource {
  std::string type;  ///< value of Content-Type
  std::shared_ptr<const std::string> bytes;
};

/// Limits on the cost of clients.
struct Limits {
  std::size_t clients = 32;                   ///< simultaneous connections
  std::uint32_t header_bytes = 8192;          ///< maximum size of a request's header
  std::size_t message_bytes = 8192;           ///< maximum size of a client's WebSocket message
  std::chrono::milliseconds request{10000};   ///< until a request is complete
  std::chrono::milliseconds response{30000};  ///< until a response is received
  std::size_t queued_frames = 4;
  std::size_t queued_messages = 64;  ///< in addition to frames
};

/// A client's WebSocket, used by the server's thread.
class Client {
 public:
  virtual ~Client() = default;
  virtual void send(Message message) = 0;
  virtual bool has_room() const = 0;  ///< for a frame
  bool loading = true;                ///< until the page reports that it has its files
  std::size_t rows = 0;               ///< rows of the time series sent to the page so far
};

/// The served content. Called in the server's thread; an exception causes a 500 response or ends the
/// connection.
struct Service {
  /// Returns the resource at a path, or nullopt.
  std::function<std::optional<Resource>(std::string_view path)> resource;
  std::string protocol = {};  ///< WebSocket subprotocol
  std::function<void(Client&)> opened = [](Client&) {};
  std::function<void(Client&, std::string_view text)> received = [](Client&, std::string_view) {};
  /// Called when a client has left; viewers: number of remaining pages.
  std::function<void(std::size_t viewers)> closed = [](std::size_t) {};
};

/// The server, which listens while the object exists. Rejects requests and upgrades according to rejection().
class Server {
 public:
  /// Throws std::invalid_argument as checked() does, and std::runtime_error if it cannot listen.
  Server(const Access& access, Service service, const Limits& limits = {});
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  const Access& access() const;  ///< with port and token

  /// Calls a function in the server's thread for each client. Safe from any thread.
  void for_each(std::function<void(Client&)> action);

  /// Returns whether a client has room for a frame. Safe from any thread.
  bool has_room() const;

  /// Waits until no page is loading (at most `loading`), then until all queues are empty (at most `queues`).
  void flush(std::chrono::milliseconds queues, std::chrono::milliseconds loading);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace sim::view
