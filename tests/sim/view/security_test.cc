// Security rules of the server: each test fails without its guard.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <set>
#include <thread>

#include "sim/view/live_view.h"
#include "sim/view/server.h"
#include "tests/sim/view/raw_client.h"

namespace sim::view {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

Service service() {
  Service service;
  service.resource = [](std::string_view path) -> std::optional<Resource> {
    if (path != "/" && path != "/about" && path != "/view.js") return std::nullopt;
    return Resource{"text/html; charset=utf-8", std::make_shared<const std::string>("the secret content")};
  };
  service.protocols = {"gaitslam.view.v1", "foxglove.websocket.v1"};
  service.received = [](Client& client, std::string_view text) {
    client.send({std::make_shared<const std::string>("heard " + std::string(text)), true, false});
  };
  return service;
}

class Security : public testing::Test {
 protected:
  std::string host() const { return fmt::format("127.0.0.1:{}", port_); }

  std::string request(const std::string& target, const std::string& headers,
                      const std::string& method = "GET") const {
    RawClient client(port_);
    client.send(fmt::format("{} {} HTTP/1.1\r\n{}\r\n", method, target, headers));
    return client.response();
  }
  std::string request_with_host(const std::string& target, const std::string& more = "",
                                const std::string& method = "GET") const {
    return request(target, fmt::format("Host: {}\r\n{}", host(), more), method);
  }
  std::string upgraded(const std::string& target, const std::string& headers,
                       const std::string& protocol = "gaitslam.view.v1") const {
    RawClient client(port_);
    client.send(upgrade(target, headers, protocol));
    return client.response();
  }
  /// A WebSocket that is open.
  std::unique_ptr<RawClient> opened() const {
    auto client = std::make_unique<RawClient>(port_);
    EXPECT_THAT(open_socket(*client, server_.access()), StartsWith("HTTP/1.1 101"));
    return client;
  }
  void expect_alive() const {
    EXPECT_THAT(request_with_host("/?token=" + kToken), StartsWith("HTTP/1.1 200"));
    const auto client = opened();
    client->send(text_frame("hello"));
    EXPECT_EQ(next_payload(*client), "heard hello");
  }

  static Limits limits() {
    Limits limits;
    limits.clients = 6;
    limits.header_bytes = 2000;
    limits.message_bytes = 1000;
    limits.request = std::chrono::milliseconds(300);
    return limits;
  }

  Server server_{{.token = kToken}, service(), limits()};
  std::uint16_t port_ = server_.access().port;
};

const std::string kRefused = "HTTP/1.1 403", kMisdirected = "HTTP/1.1 421";

TEST_F(Security, TheServerListensAtItsOwnAddressAlone) {
  EXPECT_EQ(server_.access().address, "127.0.0.1");
  EXPECT_FALSE(RawClient(port_, "127.0.0.2").connected());
}

TEST(Access, ReachableAddressesAllInterfacesAndWeakTokensAreRefused) {
  for (const Access& access :
       {Access{.address = "192.168.1.5"}, Access{.address = "2001:db8::1"},
        Access{.address = "0.0.0.0", .token = kToken}, Access{.address = "::", .token = kToken},
        Access{.address = "example.org", .token = kToken}, Access{.token = "secret"},
        Access{.token = "0123456789abcdef01234"}, Access{.token = "0123456789abcdef0123456789abcde\""}})
    EXPECT_THROW(checked(access), std::invalid_argument) << access.address << ' ' << access.token;
  EXPECT_NO_THROW(checked({.address = "192.168.1.5", .token = kToken}));
}

TEST(Access, TokensHave128BitsOfTheirOwn) {
  std::set<std::string> tokens;
  std::set<char> digits;
  for (int i = 0; i < 1000; ++i) {
    const std::string token = new_token();
    EXPECT_EQ(token.size(), 32u);
    EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos);
    tokens.insert(token);
    digits.insert(token.begin(), token.end());
  }
  EXPECT_EQ(tokens.size(), 1000u);
  EXPECT_EQ(digits.size(), 16u);
  EXPECT_EQ(checked({}).token.size(), 32u);
}

TEST(Access, TokensAreEqualInEveryCharacterOrNotAtAll) {
  EXPECT_TRUE(equal_in_constant_time(kToken, kToken));
  for (std::size_t i = 0; i < kToken.size(); ++i) {
    std::string other = kToken;
    other[i] = static_cast<char>(other[i] ^ 1);
    EXPECT_FALSE(equal_in_constant_time(other, kToken));
    EXPECT_FALSE(equal_in_constant_time(kToken.substr(0, i), kToken));
  }
  EXPECT_FALSE(equal_in_constant_time(kToken + kToken, kToken));
  EXPECT_FALSE(equal_in_constant_time("", kToken));
}

// DNS rebinding: a name of the attacker's that resolves to this machine.
TEST_F(Security, AnotherHostIsRefused) {
  const std::string target = "/?token=" + kToken;
  for (const std::string& other :
       {std::string("evil.example"), fmt::format("evil.example:{}", port_), std::string("127.0.0.1"),
        fmt::format("127.0.0.1:{}", port_ + 1), fmt::format("127.0.0.1.evil.example:{}", port_),
        fmt::format("localhost:{}", port_)})
    EXPECT_THAT(request(target, "Host: " + other + "\r\n"), StartsWith(kMisdirected)) << other;
  EXPECT_THAT(request(target, ""), StartsWith(kMisdirected));
  EXPECT_THAT(request(target, fmt::format("Host: {}\r\nHost: {}\r\n", host(), host())),
              StartsWith(kMisdirected));
  EXPECT_THAT(upgraded("/socket?token=" + kToken, fmt::format("Host: evil.example:{}\r\n", port_)),
              StartsWith(kMisdirected));
}

TEST_F(Security, APageOfAnotherOriginIsRefused) {
  for (const std::string& other :
       {std::string("https://evil.example"), fmt::format("http://evil.example:{}", port_),
        std::string("http://127.0.0.1"), fmt::format("https://127.0.0.1:{}", port_),
        fmt::format("http://127.0.0.1:{}", port_ + 1), fmt::format("http://127.0.0.2:{}", port_),
        fmt::format("http://192.168.1.5:{}", port_), fmt::format("http://[::1]:{}", port_),
        std::string("null")}) {
    EXPECT_THAT(request_with_host("/about?token=" + kToken, "Origin: " + other + "\r\n"),
                StartsWith(kRefused))
        << other;
    EXPECT_THAT(upgraded("/socket?token=" + kToken, fmt::format("Host: {}\r\nOrigin: {}\r\n", host(), other)),
                StartsWith(kRefused))
        << other;
  }
  const std::string own = fmt::format("Host: {}\r\nOrigin: http://{}\r\n", host(), host());
  EXPECT_THAT(upgraded("/socket?token=" + kToken, own), StartsWith("HTTP/1.1 101"));
}

TEST_F(Security, ADesktopAppNeedsTheToken) {
  for (const char* const origin : {"", "Origin: file://\r\n", "Origin: app://lichtblick\r\n"}) {
    const std::string headers = "Host: " + host() + "\r\n" + origin;
    EXPECT_THAT(upgraded("/?token=" + kToken, headers, "foxglove.websocket.v1"), StartsWith("HTTP/1.1 101"))
        << origin;
    EXPECT_THAT(upgraded("/", headers, "foxglove.websocket.v1"), StartsWith(kRefused)) << origin;
  }
}

TEST_F(Security, EveryFileAndEveryUpgradeNeedTheToken) {
  const std::string own = fmt::format("Host: {0}\r\nOrigin: http://{0}\r\n", host());
  for (const std::string& query :
       {std::string(), std::string("?token="), std::string("?token=f") + kToken.substr(1),
        "?token=" + kToken + "0", "?token=" + kToken.substr(1), "?nottoken=" + kToken}) {
    for (const std::string path : {"/", "/about", "/view.js", "/nothing"})
      EXPECT_THAT(request_with_host(path + query),
                  AllOf(StartsWith(kRefused), Not(HasSubstr("secret content"))))
          << path << query;
    EXPECT_THAT(upgraded("/socket" + query, own), StartsWith(kRefused)) << query;
  }
}

TEST_F(Security, EveryAnswerTellsBrowsersToBeStrict) {
  for (const std::string& answer : {request_with_host("/?token=" + kToken),
                                    request_with_host("/none?token=" + kToken), request_with_host("/")}) {
    EXPECT_THAT(
        answer,
        HasSubstr("Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; "));
    EXPECT_THAT(answer, AllOf(Not(HasSubstr("unsafe-")), HasSubstr("frame-ancestors 'none'")));
    EXPECT_THAT(answer, HasSubstr("X-Content-Type-Options: nosniff\r\n"));
    EXPECT_THAT(answer, HasSubstr("Referrer-Policy: no-referrer\r\n"));
    EXPECT_THAT(answer, HasSubstr("Cross-Origin-Resource-Policy: same-origin\r\n"));
    EXPECT_THAT(answer, Not(HasSubstr("Access-Control")));
  }
}

TEST_F(Security, OtherMethodsPathsAndSizesAreRefused) {
  const std::string query = "?token=" + kToken;
  for (const char* const method : {"POST", "PUT", "DELETE", "OPTIONS", "HEAD"})
    EXPECT_THAT(request_with_host("/" + query, "", method), StartsWith("HTTP/1.1 405")) << method;
  for (const std::string path : {"/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd",
                                 "/etc/passwd", "/view.js/../about", "/view.js/", "/.git/config"})
    EXPECT_THAT(request_with_host(path + query), StartsWith("HTTP/1.1 404")) << path;
  EXPECT_THAT(request_with_host("/" + query, "X-Long: " + std::string(3000, 'x') + "\r\n"),
              StartsWith("HTTP/1.1 431"));
  EXPECT_THAT(request_with_host("/" + query, "Content-Length: 100000000\r\n"), StartsWith("HTTP/1.1 413"));
  EXPECT_THAT(upgraded("/socket" + query, "Host: " + host() + "\r\n", "chat"), StartsWith("HTTP/1.1 400"));
  expect_alive();
}

TEST_F(Security, ASlowRequestIsGivenUp) {
  RawClient slow(port_);
  slow.send("GET / HTTP/1.1\r\nHost: ");
  EXPECT_TRUE(slow.is_closed_within(3000));
  expect_alive();
}

TEST_F(Security, NoMoreClientsThanAllowedAreHeard) {
  std::vector<std::unique_ptr<RawClient>> clients;
  for (int i = 0; i < 6; ++i) clients.push_back(opened());
  RawClient more(port_);
  more.send(fmt::format("GET /?token={} HTTP/1.1\r\nHost: {}\r\n\r\n", kToken, host()));
  EXPECT_EQ(more.response(), "");
  EXPECT_TRUE(more.is_closed_within(3000));
  clients.clear();
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  expect_alive();
}

TEST_F(Security, ConnectionsThatSayNothingKeepNobodyOut) {
  Limits limits = Security::limits();
  limits.request = std::chrono::minutes(1);
  const Server server{{.token = kToken}, service(), limits};
  const std::uint16_t port = server.access().port;
  std::vector<std::unique_ptr<RawClient>> silent;
  for (std::size_t i = 0; i < 2 * limits.clients; ++i) silent.push_back(std::make_unique<RawClient>(port));
  RawClient client(port);
  client.send(fmt::format("GET /?token={} HTTP/1.1\r\nHost: {}\r\n\r\n", kToken, authority(server.access())));
  EXPECT_THAT(client.until("\r\n\r\n"), StartsWith("HTTP/1.1 200"));
  EXPECT_TRUE(silent.front()->is_closed_within(3000));
}

TEST_F(Security, ALongMessageEndsItsConnection) {
  const auto client = opened();
  client->send(text_frame(std::string(900, 'x')));
  EXPECT_TRUE(next_payload(*client).has_value());
  client->send(text_frame(std::string(1100, 'x')));
  EXPECT_TRUE(client->is_closed_within(3000));
  EXPECT_THAT(client->until("heard"), Not(HasSubstr("heard")));
  expect_alive();
}

TEST_F(Security, MalformedFramesEndTheirConnectionAlone) {
  const std::string unmasked("\x81\x02hi", 4), reserved = client_frame(0x83, "hi"),
                                               extension = client_frame(0xf1, "hi"),
                                               huge("\x81\xff\x7f\xff\xff\xff\xff\xff\xff\xff\0\0\0\0", 14),
                                               long_ping = client_frame(0x89, std::string(200, 'x'));
  for (const std::string& frame : {unmasked, reserved, extension, huge, long_ping,
                                   client_frame(0x81, "\xff\xfe"), client_frame(0x80, "x")}) {
    const auto client = opened();
    client->send(frame);
    EXPECT_TRUE(client->is_closed_within(3000));
  }
  expect_alive();
}

TEST_F(Security, WhatIsNoHttpEndsItsConnectionAlone) {
  for (const std::string& bytes : {std::string("\x16\x03\x01\x02\0\x01", 6), std::string("GET\r\n\r\n"),
                                   std::string(1000, '\0'), std::string("GET / HTTP/9.9\r\n\r\n")}) {
    RawClient client(port_);
    client.send(bytes);
    EXPECT_TRUE(client.is_closed_within(3000));
  }
  expect_alive();
}

/// A view of a run, with a page that is connected to it.
class Viewed {
 public:
  explicit Viewed(bool control)
      : view_({.token = kToken}, {.label = "walk"}, control), client_(view_.access().port) {
    open_socket(client_, view_.access());
    next_payload(client_);  // the pace
  }
  std::string answer(const std::string& message) {
    client_.send(text_frame(message));
    return next_payload(client_).value_or("");
  }
  /// True if the run continues within half a second.
  bool goes_on() {
    std::atomic<bool> done = false;
    std::thread run([&] {
      view_.pace(slam::Stamp(1'000'000));
      done = true;
    });
    for (int i = 0; i < 50 && !done; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    const bool went = done;
    if (!went) answer(R"({"op":"resume"})");
    run.join();
    return went;
  }

 private:
  LiveView view_;
  RawClient client_;
};

TEST(ReadOnly, CommandsAreRefusedWithoutControl) {
  Viewed viewed(false);
  for (const char* const message :
       {R"({"op":"pause"})", R"({"op":"step"})", R"({"op":"speed","factor":0.25})", R"({"op":"resume"})"})
    EXPECT_THAT(viewed.answer(message), AllOf(HasSubstr("\"rejected\""), HasSubstr("read-only"))) << message;
  EXPECT_TRUE(viewed.goes_on());
}

TEST(ReadOnly, CommandsAreObeyedWithControl) {
  Viewed viewed(true);
  EXPECT_TRUE(viewed.goes_on());
  EXPECT_THAT(viewed.answer(R"({"op":"pause"})"), HasSubstr("\"paused\":true"));
  EXPECT_FALSE(viewed.goes_on());
  EXPECT_TRUE(viewed.goes_on()) << "resumed above";
}

TEST(ReadOnly, MalformedMessagesAreAnsweredAndSurvived) {
  Viewed viewed(true);
  for (const char* const message : {"", "{", "[]", "null", "{\"op\":7}", "{\"op\":\"speed\"}",
                                    "{\"op\":\"speed\",\"factor\":-1}", "{\"op\":\"launch\"}"})
    EXPECT_THAT(viewed.answer(message), HasSubstr("\"rejected\"")) << message;
  EXPECT_THAT(viewed.answer(R"({"op":"speed","factor":1})"), HasSubstr("\"speed\":1.0"));
}

}  // namespace
}  // namespace sim::view
