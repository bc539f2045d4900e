// Security rules of the server: each test fails without its guard.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <future>
#include <set>
#include <thread>

#include "sim/view/live_view.h"
#include "sim/view/server.h"
#include "tests/sim/files/has.h"
#include "tests/sim/view/raw_client.h"

namespace sim::view {
namespace {

using testing::AllOf, testing::StartsWith, tests::Has, tests::Lacks;

TEST(Access, ReachableAddressesAllInterfacesAndWeakTokensAreRefused) {
  for (const Access& access :
       {Access{.address = "192.168.1.5"}, Access{.address = "2001:db8::1"},
        Access{.address = "0.0.0.0", .token = kToken}, Access{.address = "::", .token = kToken},
        Access{.address = "example.org", .token = kToken}, Access{.token = "secret"},
        Access{.token = "0123456789abcdef01234"}, Access{.token = "0123456789abcdef0123456789abcde\""}})
    EXPECT_THROW(checked(access), std::invalid_argument) << access.address << ' ' << access.token;
  EXPECT_NO_THROW(checked({.address = "192.168.1.5", .token = kToken}));
}

TEST(Access, TokensHave128BitsOfTheirOwnAndAreEqualInEveryCharacterOrNotAtAll) {
  std::set<std::string> tokens;
  std::set<char> digits;
  for (int i = 0; i < 1000; ++i) {
    const std::string token = checked({}).token;
    EXPECT_EQ(token.size(), 32u);
    tokens.insert(token);
    digits.insert(token.begin(), token.end());
  }
  EXPECT_EQ(tokens.size(), 1000u);
  EXPECT_EQ(std::string(digits.begin(), digits.end()), "0123456789abcdef");
  EXPECT_TRUE(equal_in_constant_time(kToken, kToken));
  for (std::size_t i = 0; i < kToken.size(); ++i) {
    std::string other = kToken;
    other[i] = static_cast<char>(other[i] ^ 1);
    EXPECT_FALSE(equal_in_constant_time(other, kToken));
    EXPECT_FALSE(equal_in_constant_time(kToken.substr(0, i), kToken));
  }
  EXPECT_FALSE(equal_in_constant_time(kToken + kToken, kToken));
}

struct Asked {
  std::string target;
  std::vector<std::string> hosts;
  unsigned status;
  std::optional<std::string> origin = std::nullopt;
  std::string method = "GET";
};

// Another host: DNS rebinding by an attacker's name that resolves to this machine.
TEST(Rejection, OtherHostsOriginsTokensAndMethodsAreRefused) {
  const std::string own = "127.0.0.1:8000", page = "/about?token=" + kToken;
  std::vector<Asked> all{{page, {own}, 0},
                         {page,
                          {"evil.example", "evil.example:8000", "127.0.0.1", "127.0.0.1:8001",
                           "127.0.0.1.evil.example:8000", "localhost:8000", ""},
                          421},
                         {page, {own}, 0, "http://127.0.0.1:8000"}};
  for (const char* const other :
       {"https://evil.example", "http://evil.example:8000", "http://127.0.0.1", "https://127.0.0.1:8000",
        "http://127.0.0.1:8001", "http://127.0.0.2:8000", "http://[::1]:8000", "null"})
    all.push_back({page, {own}, 403, other});
  for (const std::string& query :
       {std::string(), std::string("?token="), "?token=f" + kToken.substr(1), "?token=" + kToken + "0",
        "?token=" + kToken.substr(1), "?nottoken=" + kToken})
    for (const std::string path : {"/", "/about", "/view.js", "/nothing", "/socket"})
      all.push_back({path + query, {own}, 403});
  for (const char* const app : {"file://", "app://lichtblick"})
    all.insert(all.end(), {{page, {own}, 0, app}, {"/about", {own}, 403, app}});
  for (const char* const method : {"POST", "PUT", "DELETE", "OPTIONS", "HEAD"})
    all.push_back({page, {own}, 405, std::nullopt, method});
  for (const auto& [target, hosts, status, origin, method] : all)
    for (const std::string& host : hosts) {
      const auto rejected = rejection({method, target, host, origin}, {.port = 8000, .token = kToken});
      EXPECT_EQ(rejected ? rejected->status : 0, status) << target << host << origin.value_or("") << method;
    }
}

Service service() {
  Service service;
  service.resource = [](std::string_view path) -> std::optional<Resource> {
    if (path != "/" && path != "/view.js") return std::nullopt;
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
  std::string request(const std::string& target, const std::string& headers,
                      const std::string& method = "GET") const {
    RawClient client(port_);
    client.send(fmt::format("{} {} HTTP/1.1\r\n{}\r\n", method, target, headers));
    return client.response();
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
    EXPECT_THAT(request("/" + query_, host_), StartsWith("HTTP/1.1 200"));
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
  std::string host_ = fmt::format("Host: 127.0.0.1:{}\r\n", port_), query_ = "?token=" + kToken;
};

TEST_F(Security, TheServerListensAtItsOwnAddressAlone) {
  EXPECT_EQ(server_.access().address, "127.0.0.1");
  EXPECT_FALSE(RawClient(port_, "127.0.0.2").connected());
}

TEST_F(Security, RejectedRequestsAndUpgradesGetNothing) {
  const std::string evil = fmt::format("Host: evil.example:{}\r\n", port_);
  for (const auto& [target, headers, status] :
       {std::tuple{"/" + query_, evil, "421"}, std::tuple{"/" + query_, std::string(), "421"},
        std::tuple{"/" + query_, host_ + host_, "421"}, std::tuple{std::string("/"), host_, "403"},
        std::tuple{"/" + query_, host_ + "Origin: https://evil.example\r\n", "403"}}) {
    const auto refused = AllOf(StartsWith(fmt::format("HTTP/1.1 {}", status)), Lacks("secret"));
    EXPECT_THAT(request(target, headers), refused) << headers;
    EXPECT_THAT(upgraded(target, headers), refused) << headers;
  }
  EXPECT_THAT(request("/" + query_, host_, "POST"), StartsWith("HTTP/1.1 405"));
  EXPECT_THAT(upgraded("/" + query_, host_ + "Origin: app://lichtblick\r\n", "foxglove.websocket.v1"),
              StartsWith("HTTP/1.1 101"));
}

TEST_F(Security, EveryAnswerTellsBrowsersToBeStrict) {
  for (const std::string& answer :
       {request("/" + query_, host_), request("/none" + query_, host_), request("/", host_)}) {
    EXPECT_THAT(
        answer,
        AllOf(Has("Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; ",
                  "frame-ancestors 'none'", "X-Content-Type-Options: nosniff\r\n",
                  "Referrer-Policy: no-referrer\r\n", "Cross-Origin-Resource-Policy: same-origin\r\n"),
              Lacks("unsafe-", "Access-Control")));
  }
}

TEST_F(Security, OtherPathsSizesAndProtocolsAreRefused) {
  for (const std::string path : {"/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd",
                                 "/etc/passwd", "/view.js/../about", "/view.js/", "/.git/config"})
    EXPECT_THAT(request(path + query_, host_), StartsWith("HTTP/1.1 404")) << path;
  EXPECT_THAT(request("/" + query_, host_ + "X-Long: " + std::string(3000, 'x') + "\r\n"),
              StartsWith("HTTP/1.1 431"));
  EXPECT_THAT(request("/" + query_, host_ + "Content-Length: 100000000\r\n"), StartsWith("HTTP/1.1 413"));
  EXPECT_THAT(upgraded("/socket" + query_, host_, "chat"), StartsWith("HTTP/1.1 400"));
  expect_alive();
}

TEST_F(Security, NoMoreClientsThanAllowedAreHeard) {
  std::vector<std::unique_ptr<RawClient>> clients;
  for (int i = 0; i < 6; ++i) clients.push_back(opened());
  RawClient more(port_);
  more.send(fmt::format("GET /{} HTTP/1.1\r\n{}\r\n", query_, host_));
  EXPECT_EQ(more.response(), "");
  EXPECT_TRUE(more.is_closed_within(3000));
  clients.clear();
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  expect_alive();
}

TEST_F(Security, GarbageAndASlowRequestEndTheirConnectionsAlone) {
  const std::string unmasked("\x81\x02hi", 4), huge("\x81\xff\x7f\xff\xff\xff\xff\xff\xff\xff\0\0\0\0", 14);
  for (const std::string& frame : {unmasked, huge, client_frame(0x83, "hi"), client_frame(0x81, "\xff\xfe"),
                                   text_frame(std::string(1100, 'x'))}) {  // the last one is too long
    const auto client = opened();
    client->send(text_frame(std::string(900, 'x')));
    EXPECT_TRUE(next_payload(*client).has_value());
    client->send(frame);
    EXPECT_TRUE(client->is_closed_within(3000));
    EXPECT_THAT(client->until("heard"), Lacks("heard"));
  }
  for (const std::string& bytes : {std::string("\x16\x03\x01\x02\0\x01", 6), std::string("GET\r\n\r\n"),
                                   std::string("GET / HTTP/1.1\r\nHost: ")}) {  // the last one is slow
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
    auto run = std::async(std::launch::async, [&] { view_.pace(slam::Stamp(1'000'000)); });
    const bool went = run.wait_for(std::chrono::milliseconds(500)) == std::future_status::ready;
    if (!went) answer(R"({"op":"resume"})");
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
    EXPECT_THAT(viewed.answer(message), Has("\"rejected\"", "read-only")) << message;
  EXPECT_TRUE(viewed.goes_on());
}

TEST(ReadOnly, CommandsAreObeyedWithControlAndMalformedOnesSurvived) {
  Viewed viewed(true);
  EXPECT_TRUE(viewed.goes_on());
  for (const char* const message : {"", R"({"op":7})", R"({"op":"launch"})"})
    EXPECT_THAT(viewed.answer(message), Has("\"rejected\"")) << message;
  EXPECT_THAT(viewed.answer(R"({"op":"speed","factor":1})"), Has("\"speed\":1.0"));
  EXPECT_THAT(viewed.answer(R"({"op":"pause"})"), Has("\"paused\":true"));
  EXPECT_FALSE(viewed.goes_on());
  EXPECT_TRUE(viewed.goes_on()) << "resumed above";
}

}  // namespace
}  // namespace sim::view
