// A client that sends exactly the given bytes over a socket.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "sim/view/server.h"

namespace sim::view {

inline const std::string kToken = "0123456789abcdef0123456789abcdef";

class RawClient {
 public:
  explicit RawClient(std::uint16_t port, const char* address = "127.0.0.1", int receive_buffer = 0)
      : fd_(::socket(AF_INET, SOCK_STREAM, 0)) {
    if (receive_buffer > 0) ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    ::inet_pton(AF_INET, address, &to.sin_addr);
    connected_ = ::connect(fd_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0;
  }
  ~RawClient() { ::close(fd_); }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  bool connected() const { return connected_; }
  void send(std::string_view bytes) { ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }

  /// True if the other side closes within that time; keeps the bytes received before.
  bool is_closed_within(int ms) {
    while (receive(ms)) continue;
    return closed_;
  }

  /// All up to and including `end`, or what came within that time.
  std::string until(std::string_view end, int ms = 5000) {
    std::size_t at = std::string::npos;
    while ((at = received_.find(end)) == std::string::npos && receive(ms)) continue;
    return take(at == std::string::npos ? received_.size() : at + end.size());
  }

  std::string exactly(std::size_t bytes, int ms = 5000) {
    while (received_.size() < bytes && receive(ms)) continue;
    return take(std::min(bytes, received_.size()));
  }

  /// Head and body of a response.
  std::string response() {
    std::string head = until("\r\n\r\n");
    const std::size_t at = head.find("Content-Length: ");
    return at == std::string::npos ? head : head + exactly(std::stoul(head.substr(at + 16)));
  }

 private:
  bool receive(int ms) {
    pollfd waiting{fd_, POLLIN, 0};
    if (closed_ || ::poll(&waiting, 1, ms) <= 0) return false;
    char bytes[65536];
    const ssize_t n = ::recv(fd_, bytes, sizeof bytes, 0);
    closed_ = n <= 0;
    if (n > 0) received_.append(bytes, std::size_t(n));
    return n > 0;
  }
  std::string take(std::size_t bytes) {
    std::string taken = received_.substr(0, bytes);
    received_.erase(0, bytes);
    return taken;
  }

  int fd_;
  bool connected_ = false, closed_ = false;
  std::string received_;
};

/// A frame as clients send it, masked with zeros; `first`: FIN and opcode.
inline std::string client_frame(unsigned char first, std::string_view payload) {
  const std::size_t size = payload.size();
  std::string frame{char(first), char(0x80 | std::min<std::size_t>(size, 126))};
  if (size >= 126) frame += {char(size >> 8), char(size & 0xff)};
  return frame.append(4, '\0').append(payload);
}
inline std::string text_frame(std::string_view payload) { return client_frame(0x81, payload); }

/// The payload of the next frame of the server; nothing where none comes.
inline std::optional<std::string> next_payload(RawClient& client, int ms = 5000) {
  const std::string head = client.exactly(2, ms);
  if (head.size() < 2) return std::nullopt;
  std::size_t size = static_cast<unsigned char>(head[1]) & 0x7f;
  const int more = size == 126 ? 2 : size == 127 ? 8 : 0;
  if (more > 0) {
    size = 0;
    for (const char byte : client.exactly(std::size_t(more), ms))
      size = size << 8 | static_cast<unsigned char>(byte);
  }
  return client.exactly(size, ms);
}

/// A request that becomes a WebSocket.
inline std::string upgrade(const std::string& target, const std::string& headers,
                           const std::string& protocol = "gaitslam.view.v1") {
  return "GET " + target + " HTTP/1.1\r\n" + headers +
         "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: " +
         protocol + "\r\n\r\n";
}

/// Opens a client's WebSocket; returns the head of the answer.
inline std::string open_socket(RawClient& client, const Access& access,
                               const std::string& protocol = "gaitslam.view.v1") {
  client.send(upgrade("/socket?token=" + access.token, "Host: " + authority(access) + "\r\n", protocol));
  return client.until("\r\n\r\n");
}

}  // namespace sim::view
