// Access to the server: address, token, and the rules for each request.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sim::view {

/// Listening address and the secret that each request must carry.
struct Access {
  std::string address = "127.0.0.1";  ///< of this machine, numeric
  std::uint16_t port = 0;             ///< 0: any free one, known once the server listens
  std::string token = {};             ///< empty: 128 random bits
};

/// Generates a missing token. Throws std::invalid_argument if the address is invalid, means all interfaces,
/// or can be reached by others while no token is given, and if a token is shorter than 22 characters or
/// contains other characters than letters, digits, - and _.
Access checked(Access access);

/// 128 bits of the system's random source in 32 hexadecimal digits. Throws std::runtime_error if it fails.
std::string new_token();

/// Takes the same time for all texts of one length.
bool equal_in_constant_time(std::string_view a, std::string_view b);

/// Address and port as in a URL; IPv6 in brackets.
std::string authority(const Access& access);
/// The address for the browser.
std::string url(const Access& access);

/// The checked part of a request.
struct RequestHead {
  std::string_view method, target, host;
  std::optional<std::string_view> origin = std::nullopt;
};

/// An HTTP status with its reason.
struct Rejection {
  unsigned status;
  std::string_view why;
};

/// The rules, in this order: Host is exactly the server's authority (prevents DNS rebinding); a page's Origin
/// is exactly the server's (apps send their own or none); the token of the query is correct; GET only.
std::optional<Rejection> rejection(const RequestHead& request, const Access& access);

/// The target without its query.
std::string_view path_of(std::string_view target);

/// The Content-Security-Policy of every response: only the server's own scripts and styles, and no framing.
std::string content_security_policy(const Access& access);

}  // namespace sim::view
