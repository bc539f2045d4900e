#include "sim/view/access.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <stdexcept>

namespace sim::view {
namespace {

constexpr std::size_t kTokenBytes = 16, kLeastTokenLength = 22;  // 128 bits, also in base64

enum class Reach { none, loopback, network, everything };

Reach reach_of(const std::string& address) {
  in_addr v4{};
  if (::inet_pton(AF_INET, address.c_str(), &v4) == 1) {
    const std::uint32_t number = ntohl(v4.s_addr);
    return number == 0 ? Reach::everything : number >> 24 == 127 ? Reach::loopback : Reach::network;
  }
  in6_addr v6{};
  if (::inet_pton(AF_INET6, address.c_str(), &v6) != 1) return Reach::none;
  return IN6_IS_ADDR_UNSPECIFIED(&v6) ? Reach::everything
         : IN6_IS_ADDR_LOOPBACK(&v6)  ? Reach::loopback
                                      : Reach::network;
}

void require_listenable(const Access& access) {
  const Reach reach = reach_of(access.address);
  if (reach == Reach::none)
    throw std::invalid_argument(
        fmt::format("--address {}: expected an IP address of this machine", access.address));
  if (reach == Reach::everything)
    throw std::invalid_argument(
        fmt::format("--address {}: expected one address of this machine", access.address));
  if (reach == Reach::network && access.token.empty())
    throw std::invalid_argument(
        fmt::format("--address {}: others can reach it, expected a --token of your own", access.address));
}

void require_strong(std::string_view token) {
  const bool plain = std::all_of(token.begin(), token.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '_';
  });
  if (token.size() < kLeastTokenLength || !plain)
    throw std::invalid_argument("--token: expected at least 22 letters, digits, - or _");
}

// The value of `token` in the query, or empty.
std::string_view token_in(std::string_view target) {
  constexpr std::string_view kName = "token=";
  const std::size_t query = target.find('?');
  std::string_view rest = query == target.npos ? std::string_view() : target.substr(query + 1);
  while (!rest.empty()) {
    const std::string_view pair = rest.substr(0, rest.find('&'));
    if (pair.starts_with(kName)) return pair.substr(kName.size());
    rest.remove_prefix(std::min(rest.size(), pair.size() + 1));
  }
  return {};
}

// Pages have a web scheme or an opaque origin ("null"); apps have other schemes.
bool is_page(std::string_view origin) {
  return origin.starts_with("http:") || origin.starts_with("https:") || origin == "null";
}

}  // namespace

std::string new_token() {
  std::array<unsigned char, kTokenBytes> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw std::runtime_error("the system's random source failed");
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

Access checked(Access access) {
  require_listenable(access);
  if (access.token.empty()) access.token = new_token();
  require_strong(access.token);
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
  if (request.origin && is_page(*request.origin) && *request.origin != "http://" + host)
    return Rejection{403, "the Origin is not this server's"};
  if (!equal_in_constant_time(token_in(request.target), access.token))
    return Rejection{403, "missing or wrong token"};
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
