#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <cctype>
#include <functional>
#include <numeric>
#include <random>
#include <stdexcept>

#include "sim/view/server.h"

namespace sim::view {

constexpr std::size_t kLeastTokenLength = 22;  // 128 bits, also in base64

std::string new_token() {
  std::random_device source("/dev/urandom");
  std::string token;
  for (int word = 0; word < 4; ++word) token += fmt::format("{:08x}", source());
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
  const bool plain = std::ranges::all_of(
      access.token, [](unsigned char c) { return std::isalnum(c) != 0 || c == '-' || c == '_'; });
  if (access.token.size() < kLeastTokenLength || !plain)
    throw std::invalid_argument("--token: expected at least 22 letters, digits, - or _");
  return access;
}

bool equal_in_constant_time(std::string_view a, std::string_view b) {
  return a.size() == b.size() &&
         std::inner_product(a.begin(), a.end(), b.begin(), 0, std::bit_or<>(), std::bit_xor<>()) == 0;
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
