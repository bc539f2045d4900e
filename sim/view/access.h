// Who may use the server: address, token, and the rules that each request is held to.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sim::view {

/// Where the server listens and the secret that each request must carry.
struct Access {
  std::string address = "127.0.0.1";  ///< of this machine, numeric
  std::uint16_t port = 0;             ///< 0: any free one, known once the server listens
  std::string token = {};             ///< empty: 128 bits are drawn
};

/// Draws the token that is missing. Throws std::invalid_argument where the address is none, is that of all
/// interfaces, or is not a loopback address while no token of one's own is given, and where a token is
/// shorter than 22 characters or has others than letters, digits, - and _.
Access checked(Access access);

/// 128 bits of the system's random source in 32 hexadecimal digits. Throws std::runtime_error where there is
/// none.
std::string new_token();

/// Takes the same time wherever the texts differ.
bool equal_in_constant_time(std::string_view a, std::string_view b);

/// Address and port as a URL has them; of IPv6 in brackets.
std::string authority(const Access& access);
/// What the browser is to open.
std::string url(const Access& access);

/// The part of a request that is judged.
struct RequestHead {
  std::string_view method, target, host;
  std::optional<std::string_view> origin = std::nullopt;
};

/// Why a request is refused, as an HTTP status.
struct Refusal {
  unsigned status;
  std::string_view why;
};

/// The rules, in this order: Host is exactly the server's authority (no name that was made to resolve here);
/// a page's Origin is exactly the server's (apps that are no pages send their own or none); the token of the
/// query is right; nothing but GET.
std::optional<Refusal> refusal(const RequestHead& request, const Access& access);

/// The target without its query.
std::string_view path_of(std::string_view target);

/// The Content-Security-Policy of every response: no script and style but the server's own files, no frame
/// around them.
std::string content_security_policy(const Access& access);

}  // namespace sim::view
