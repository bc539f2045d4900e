#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <boost/asio/ip/address.hpp>
#include <cctype>
#include <stdexcept>

#include "sim/view/server.h"

namespace sim::view {

constexpr std::size_t kTokenBytes = 16, kLeastTokenLength = 22;  // 128 bits, also in base64

std::string new_token() {
  std::array<unsigned char, kTokenBytes> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw std::runtime_error("the system's random source failed");
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

Access checked(Access access) {
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(access.address, error);
  const char* const complaint = error                      ? "expected an IP address of this machine"
                                : address.is_unspecified() ? "expected one address of this machine"
                                : !address.is_loopback() && access.token.empty()
                                    ? "others can reach it, expected a --token of your own"
                                    : nullptr;
  if (complaint) throw std::invalid_argument(fmt::format("--address {}: {}", access.address, complaint));
  if (access.token.empty()) access.token = new_token();
  const bool plain = std::all_of(access.token.begin(), access.token.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '_';
  });
  if (access.token.size() < kLeastTokenLength || !plain)
    throw std::invalid_argument("--token: expected at least 22 letters, digits, - or _");
  return access;
}

bool equal_in_constant_time(std::string_view a, std::string_view b) {
  unsigned difference = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < b.size(); ++i)
    difference |=
        static_cast<unsigned char>(b[i]) ^ static_cast<unsigned char>(a.empty() ? 0 : a[i % a.size()]);
  return difference == 0;
}

std::string authority(const Access& access) {
  const bool v6 = access.address.find(':') != std::string::npos;
  return fmt::format(fmt::runtime(v6 ? "[{}]:{}" : "{}:{}"), access.address, access.port);
}

std::string url(const Access& access) {
  return fmt::format("http://{}/?token={}", authority(access), access.token);
}

std::optional<Rejection> rejection(const RequestHead& request, const Access& access) {
  const std::string host = authority(access);
  if (request.host != host) return Rejection{421, "the Host is not this server's"};
  const std::string_view origin = request.origin.value_or("");
  // Pages have a web scheme or an opaque origin ("null"); apps have other schemes.
  if ((origin.starts_with("http:") || origin.starts_with("https:") || origin == "null") &&
      origin != "http://" + host)
    return Rejection{403, "the Origin is not this server's"};
  constexpr std::string_view kName = "?token=";  // the first of the query
  const std::size_t query = request.target.find(kName);
  std::string_view token = query == host.npos ? "" : request.target.substr(query + kName.size());
  token = token.substr(0, token.find('&'));
  if (!equal_in_constant_time(token, access.token)) return Rejection{403, "missing or wrong token"};
  if (request.method != "GET") return Rejection{405, "expected GET"};
  return std::nullopt;
}

std::string_view path_of(std::string_view target) { return target.substr(0, target.find('?')); }

std::string content_security_policy(const Access& access) {
  return fmt::format(
      "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self' "
      "ws://{}; "
      "base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
      authority(access));
}

}  // namespace sim::view
