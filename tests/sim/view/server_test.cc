// The server of the view: a client that sends exactly the given bytes, the pace and messages of a live run,
// and the security rules. For each rule, a test fails if its guard is missing.
#include "sim/view/server.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <list>
#include <nlohmann/json.hpp>

#include "sim/recording/image_file.h"
#include "sim/view/live_view.h"
#include "sim/view/site.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::view {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using testing::StartsWith, tests::Has, tests::Lacks, testing::AllOf;

const std::string kToken = "0123456789abcdef0123456789abcdef", kOwn = "gaitslam.view.v1";

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

  /// Returns everything up to and including `end`, or the data that arrived within that time.
  std::string until(std::string_view end, int ms = 5000) {
    std::size_t at = std::string::npos;
    while ((at = received_.find(end)) == std::string::npos && receive(ms)) continue;
    return take(at == std::string::npos ? received_.size() : at + end.size());
  }

  std::string exactly(std::size_t bytes, int ms = 5000) {
    while (received_.size() < bytes && receive(ms)) continue;
    return take(std::min(bytes, received_.size()));
  }

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
std::string client_frame(unsigned char first, std::string_view payload) {
  const std::size_t size = payload.size();
  std::string frame{char(first), char(0x80 | std::min<std::size_t>(size, 126))};
  if (size >= 126) frame += {char(size >> 8), char(size & 0xff)};
  return frame.append(4, '\0').append(payload);
}
std::string text_frame(std::string_view payload) { return client_frame(0x81, payload); }

std::string upgrade(const std::string& target, const std::string& headers,
                    const std::string& protocol = kOwn) {
  return "GET " + target + " HTTP/1.1\r\n" + headers +
         "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: " +
         protocol + "\r\n\r\n";
}

class SocketClient : public RawClient {
 public:
  explicit SocketClient(const Access& access, const std::string& protocol = kOwn, int receive_buffer = 0)
      : RawClient(access.port, "127.0.0.1", receive_buffer) {
    send(upgrade("/socket?token=" + access.token, "Host: " + authority(access) + "\r\n", protocol));
    EXPECT_THAT(until("\r\n\r\n"), StartsWith("HTTP/1.1 101"));
  }

  void say(std::string_view text) { send(text_frame(text)); }
  void say_loaded() { say(R"({"op":"loaded"})"); }

  /// Returns the payload of the server's next frame, or nothing if none arrives.
  std::optional<std::string> next(int ms = 5000) {
    const std::string head = exactly(2, ms);
    if (head.size() < 2) return std::nullopt;
    std::size_t size = static_cast<unsigned char>(head[1]) & 0x7f;
    const std::size_t more = size == 126 ? 2 : size == 127 ? 8 : 0;
    if (more > 0) size = 0;
    for (const char byte : exactly(more, ms)) size = size << 8 | static_cast<unsigned char>(byte);
    return exactly(size, ms);
  }
  /// Returns the next message that is not about the past, or "" if none arrives.
  std::string next_message() {
    for (;;)
      if (auto payload = next(); !payload || (!payload->starts_with("{\"op\":\"series\"") &&
                                              !payload->starts_with("{\"op\":\"past\"")))
        return payload.value_or("");
  }
};

/// Returns whether a run at that time continues within 200 ms; if not, resumes it.
bool goes_on(Pace& pace, slam::Stamp t) {
  auto run = std::async(std::launch::async, [&] { pace.wait(t); });
  const bool went = run.wait_for(200ms) == std::future_status::ready;
  if (!went) pace.obey({"resume"});
  return went;
}

TEST(Pace, APausedRunContinuesForAStepWhenResumedOrWithoutViewers) {
  Pace pace;
  EXPECT_TRUE(goes_on(pace, 5ms));
  pace.obey({"pause"});
  EXPECT_FALSE(goes_on(pace, 10ms));
  EXPECT_TRUE(goes_on(pace, 15ms)) << "resumed above";
  pace.obey({"pause"});
  pace.obey({"step"}, 34ms);
  EXPECT_TRUE(pace.state().paused);
  EXPECT_TRUE(goes_on(pace, 45ms));
  EXPECT_FALSE(goes_on(pace, 50ms));
  pace.obey({"pause"});
  pace.obey({"speed", 0.25});
  pace.release();
  EXPECT_TRUE(goes_on(pace, 1000s)) << "neither paused nor slow";
  EXPECT_FALSE(pace.obey({"launch"}));
}

TEST(Pace, SpeedRefersToSimulatedTimeAndIsUnlimitedUnlessSet) {
  Pace pace;
  auto begin = Clock::now();
  for (slam::Stamp t{0}; t < 1000s; t += 1s) pace.wait(t);
  EXPECT_LT(Clock::now() - begin, 5s);
  pace.obey({"speed", 0.25});
  begin = Clock::now();
  for (slam::Stamp t = 999s; t <= 999s + 100ms; t += 5ms) pace.wait(t);
  EXPECT_GE(Clock::now() - begin, 390ms);  // it never runs ahead; how late it is depends on the machine
  EXPECT_LT(Clock::now() - begin, 3s);
}

Frame frame_at(int k) { return {.t = k * 33ms, .image = cv::Mat(240, 320, CV_8UC1, cv::Scalar(k % 256))}; }

/// Shows frames until its only viewer, which does not read, has no room left for them.
bool fills_its_viewer(LiveView& view) {
  const auto end = Clock::now() + 60s;
  for (int k = 0; Clock::now() < end; ++k) {
    view.show(frame_at(k));
    if (view.has_viewers()) continue;
    std::this_thread::sleep_for(100ms);  // the kernel may still accept the waiting data
    if (!view.has_viewers()) return true;
  }
  return false;
}

/// Waits until the server's thread has seen its client.
bool has_a_viewer(const LiveView& view) {
  for (int i = 0; i < 300 && !view.has_viewers(); ++i) std::this_thread::sleep_for(10ms);
  return view.has_viewers();
}

class Live : public testing::Test {
 protected:
  LiveView view_{{.token = kToken}, {.label = "a walk"}, false};
};

TEST_F(Live, AViewerIsSentAtMostFortyOfTheShownFramesPerSecond) {
  EXPECT_FALSE(view_.wants({})) << "without a viewer";
  SocketClient client(view_.access());
  ASSERT_TRUE(has_a_viewer(view_));
  EXPECT_EQ(client.next_message(), R"({"op":"pace","paused":false,"speed":0.0})");
  EXPECT_TRUE(view_.wants({}));
  view_.show(frame_at(3));
  EXPECT_FALSE(view_.wants({}));
  EXPECT_THAT(client.next_message(), Has("{\"t\":0.099,\"image\":[320,240]}"));
  std::this_thread::sleep_for(30ms);
  EXPECT_TRUE(view_.wants({}));
  client.say_loaded();
  view_.end("The run has ended.");
  EXPECT_EQ(client.next_message(), R"({"op":"ended","how":"The run has ended.","frames":4})");
}

TEST_F(Live, CommandsAreRefusedWithoutControlAndMalformedOnesDoNoHarm) {
  SocketClient client(view_.access());
  client.next();  // the pace
  const auto answer = [&](const char* message) {
    client.say(message);
    return client.next().value_or("");
  };
  for (const char* const op :
       {R"({"op":"pause"})", R"({"op":"step"})", R"({"op":"speed","factor":0.25})", R"({"op":"resume"})"})
    EXPECT_THAT(answer(op), Has("\"rejected\"", "read-only")) << op;
  for (const char* const none : {"", R"({"op":7})"}) EXPECT_THAT(answer(none), Has("\"rejected\"")) << none;
  view_.pace(1ms);  // does not wait
}

// Its queue and the kernel's buffers fill up. Then no more frames are made for it, the run does not wait, and
// another viewer gets its messages. On a busy machine, a browser may fetch for longer than the time limit for
// messages and may draw for a second.
TEST_F(Live, AViewerThatIsSlowForASecondStillLearnsHowTheRunEndedAndStopsNoOther) {
  auto view = std::make_unique<LiveView>(Access{.token = kToken}, ShownRun{.label = "a walk"}, false);
  SocketClient slow(view->access(), kOwn, 4096);
  ASSERT_TRUE(has_a_viewer(*view));
  ASSERT_TRUE(fills_its_viewer(*view)) << "whoever waited for it would wait for ever";
  EXPECT_FALSE(view->wants({}));
  SocketClient reading(view->access());
  reading.say_loaded();
  ASSERT_TRUE(has_a_viewer(*view));
  reading.next_message();  // the pace
  reading.next_message();  // the last frame
  ASSERT_TRUE(view->wants({}));
  view->show(frame_at(2000));
  EXPECT_THAT(reading.next_message(), Has("\"t\":66.0"));
  std::thread program([&] {
    view->end("done");
    view.reset();
  });
  std::this_thread::sleep_for(3100ms);
  slow.say_loaded();
  std::this_thread::sleep_for(1s);
  std::string last;
  do last = slow.next_message();
  while (!last.empty() && last.find("ended") == last.npos);
  EXPECT_THAT(last, StartsWith(R"({"op":"ended","how":"done",)"));
  program.join();
}

// An image comes with the first frame, a sweep with a frame that is not shown.
TEST(LiveRig, APageFetchesTheNewestReadingsOfTheFramesItWasSent) {
  recording::RecordingSetup setup;
  setup.rig = {{.name = "rgb0", .kind = rig::Kind::color}, {.name = "lidar0", .kind = rig::Kind::lidar}};
  LiveView view({.token = kToken}, {.label = "a walk", .rig = setup.rig}, false);
  view.begin(setup);
  SocketClient client(view.access());
  RawClient fetching(view.access().port);
  ASSERT_TRUE(has_a_viewer(view));
  client.next_message();  // the pace
  slam::Observation with_image, with_sweep;
  with_image.rig.emplace_back().image = cv::Mat(2, 3, CV_8UC3, cv::Scalar(255, 0, 0));
  with_sweep.rig.emplace_back().sensor = 1;
  with_sweep.rig[0].points = {{1, 2, 3}};
  view.wants(with_image);
  view.show(frame_at(3));
  EXPECT_THAT(client.next_message(), Has("\"rig\":0}"));
  std::this_thread::sleep_for(30ms);
  view.wants(with_sweep);
  view.show(frame_at(4));
  EXPECT_THAT(client.next_message(), Has("\"rig\":1}"));
  const auto body = [&](const std::string& path) {
    fetching.send("GET " + path + "?token=" + kToken + " HTTP/1.1\r\nHost: " + authority(view.access()) +
                  "\r\n\r\n");
    const std::string response = fetching.response();
    return response.substr(response.find("\r\n\r\n") + 4);
  };
  const std::string image = recording::encode_png(with_image.rig[0].image);
  for (const auto& [path, size] :
       {std::pair("/rig/0/0/0", image.size()), {"/rig/0/0/1", image.size()}, {"/rig/0/1/1", 16}})
    EXPECT_EQ(body(path).size(), size) << path;
  for (const char* missing : {"/rig/0/1/0", "/rig/0/0/2"}) EXPECT_EQ(body(missing), "") << missing;
  for (int k = 5; k < 40; ++k) view.show(frame_at(k));
  EXPECT_EQ(body("/rig/0/0/36"), image);
  EXPECT_EQ(body("/rig/0/0/0"), "") << "kept for some frames only";
}

TEST(Site, PicturesOfTheRoomAreEmptyUntilTheyArePainted) {
  std::promise<void> go;
  Site site({{.label = "walk",
              .model = Model{"",
                             [done = go.get_future().share()] {
                               done.wait();
                               return std::vector<std::string>{"first", "painted"};
                             }}}},
            {});
  const auto picture = [&] { return *site.at("/picture/0/1", "")->bytes; };
  EXPECT_EQ(picture(), "");
  go.set_value();
  for (int i = 0; i < 300 && picture().empty(); ++i) std::this_thread::sleep_for(10ms);
  EXPECT_EQ(picture(), "painted");
  EXPECT_FALSE(site.at("/picture/0/2", ""));
}

TEST(Site, ServesItsOwnFilesAndNoOthers) {
  Site site({{.label = "walk </script>"}}, {{"mode", "live"}});
  site.add_list("/image/0",
                [](std::size_t k) { return k < 2 ? std::optional(bytes_resource("image")) : std::nullopt; });
  EXPECT_THAT(*site.at("/", "the-token")->bytes, Has("src=\"view.js?token=the-token\""));
  EXPECT_EQ(site.at("/", "t")->bytes->find("TOKEN"), std::string::npos);
  EXPECT_GT(site.at("/view.js", "")->bytes->size(), 100'000u);
  EXPECT_THAT(*site.at("/view.js", "")->bytes, Lacks("innerHTML="));
  EXPECT_TRUE(site.at("/image/0/1", "").has_value());
  for (const char* const path : {"/image/0/2", "/image/0/-1", "/image/0/1 ", "/image/0/", "/image/0/../1",
                                 "/image/1/0", "/model/0", "view.js", "", "/index.html"})
    EXPECT_FALSE(site.at(path, "").has_value()) << path;
}

TEST(ClientMessage, CommandsAreRead) {
  EXPECT_EQ(read_client_message(R"({"op":"pause"})").op, "pause");
  EXPECT_EQ(read_client_message(R"({"op":"getParameters","parameterNames":[]})").op, "getParameters");
  EXPECT_EQ(read_client_message(R"({"op":"speed","factor":0.25})").factor, 0.25);
  EXPECT_EQ(read_client_message(R"({"op":"speed","factor":0})").factor, 0);
}

TEST(ClientMessage, AnythingElseIsMalformed) {
  const std::string deep(8000, '[');
  for (const std::string_view text :
       {"", "x", "{", "[1]", "{}", R"({"op":1})", R"({"op":"speed","factor":1e9})",
        R"({"op":"speed","factor":"1"})", deep.c_str()})
    EXPECT_THROW(read_client_message(text), std::invalid_argument) << text;
}

TEST(MessageQueue, DropsOnlyTheOldestFrameAndHasRoomWhileHalfOfItIsFree) {
  MessageQueue queue(3, 2);
  const auto push = [&](const char* text, bool is_frame) {
    return queue.push({std::make_shared<const std::string>(text), is_frame});
  };
  EXPECT_TRUE(push("a", false));
  for (const char* const text : {"1", "2", "3", "4"}) {
    EXPECT_EQ(queue.has_room(), text[0] < '3');
    EXPECT_TRUE(push(text, true));
  }
  EXPECT_TRUE(push("b", false));
  EXPECT_FALSE(push("c", false)) << "no room: the client must be dropped";
  for (const char* const text : {"a", "2", "3", "4", "b"}) EXPECT_EQ(*queue.pop()->bytes, text);
  EXPECT_FALSE(queue.pop().has_value());
  EXPECT_TRUE(queue.has_room());
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

TEST(Access, TokensHave128RandomBitsAndMatchOnlyInFull) {
  std::set<std::string> tokens;
  for (int i = 0; i < 1000; ++i) tokens.insert(checked({}).token);
  EXPECT_EQ(tokens.size(), 1000u);
  EXPECT_THAT(tokens, testing::Each(testing::MatchesRegex("[0-9a-f]{32}")));
  EXPECT_TRUE(equal_in_constant_time(kToken, kToken));
  for (std::size_t i = 0; i < kToken.size(); ++i) {
    std::string other = kToken;
    other[i] = static_cast<char>(other[i] ^ 1);
    EXPECT_FALSE(equal_in_constant_time(other, kToken));
    EXPECT_FALSE(equal_in_constant_time(kToken.substr(0, i), kToken));
  }
  EXPECT_FALSE(equal_in_constant_time(kToken + kToken, kToken));
}

TEST(Rejection, OtherHostsOriginsTokensAndMethodsAreRefused) {
  for (const auto& row : tests::rows_of("sim/view/rejections.txt")) {
    Access access{.port = 8000, .token = kToken};
    if (row[1] != "-") access.forwarded = {row[1]};
    const auto origin = row.at(3) == "-" ? std::nullopt : std::optional(row[3]);
    const auto rejected =
        rejection({row[2], tests::replaced(row.at(5), "TOKEN", kToken), row[4], origin}, access);
    EXPECT_EQ(rejected ? rejected->status : 0, std::stoul(row[0])) << testing::PrintToString(row);
  }
}

TEST(Rejection, ExplainsHowAForwardedHostIsAllowed) {
  const Access access{.port = 8000, .token = kToken, .forwarded = {"localhost:9000"}};
  EXPECT_THAT(rejection({"GET", "/", "localhost:9001"}, access)->why,
              Has("127.0.0.1:8000", "--public localhost:9001"));
  EXPECT_THAT(rejection({"GET", "/", "a b:9001"}, access)->why, Has("--public HOST:PORT"));
  EXPECT_THAT(url(access), StartsWith("http://localhost:9000/?token="));
  EXPECT_THAT(rejection({"GET", "/", "bench.example.org"}, access)->why,
              Has("--public https://bench.example.org or http://bench.example.org"));
  for (const char* const wrong :
       {"localhost", ":9000", "localhost:0", "localhost:99999", "a b:9000", "a/b:9000", "ftp://a", "https://",
        "https://a?b", "https://a/../b c", "https://a:1:2", "//a:80"})
    EXPECT_THROW(checked({.token = kToken, .forwarded = {"localhost:9000", wrong}}), std::invalid_argument)
        << wrong;
}

// A proxy passes the path on or removes it.
TEST(Rejection, APathOfAProxyIsRemoved) {
  const Access access{.port = 8000, .token = kToken, .forwarded = {"https://viz.example.org:443/gaitslam/"}};
  EXPECT_EQ(url(access), "https://viz.example.org/gaitslam/?token=" + kToken);
  for (const auto& [target, path] : {std::pair("/gaitslam/about?token=x", "/about"),
                                     {"/about?token=x", "/about"},
                                     {"/gaitslam/", "/"},
                                     {"/gaitslams/about", "/gaitslams/about"},
                                     {"/gaitslam", "/gaitslam"}})
    EXPECT_EQ(served_path(target, access), path);
}

Service service() {
  Service service;
  service.resource = [](std::string_view path) -> std::optional<Resource> {
    if (path != "/" && path != "/view.js") return std::nullopt;
    return Resource{"text/html; charset=utf-8", std::make_shared<const std::string>("the secret content")};
  };
  service.protocol = kOwn;
  service.received = [](Client& client, std::string_view text) {
    client.send({std::make_shared<const std::string>("heard " + std::string(text)), false});
  };
  return service;
}

class Security : public testing::Test {
 protected:
  std::string answer(const std::string& request) const {
    RawClient client(port_);
    client.send(request);
    return client.response();
  }
  std::string request(const std::string& target, const std::string& headers,
                      const std::string& method = "GET") const {
    return answer(fmt::format("{} {} HTTP/1.1\r\n{}\r\n", method, target, headers));
  }
  void expect_alive() const {
    EXPECT_THAT(request("/" + query_, host_), StartsWith("HTTP/1.1 200"));
    SocketClient client(server_.access());
    client.say("hello");
    EXPECT_EQ(client.next(), "heard hello");
  }

  Server server_{{.token = kToken},
                 service(),
                 {.clients = 6, .header_bytes = 2000, .message_bytes = 1000, .request = 300ms}};
  std::uint16_t port_ = server_.access().port;
  std::string host_ = fmt::format("Host: 127.0.0.1:{}\r\n", port_), query_ = "?token=" + kToken;
};

TEST_F(Security, TheServerListensOnlyAtItsOwnAddress) {
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
    EXPECT_THAT(answer(upgrade(target, headers)), refused) << headers;
  }
  EXPECT_THAT(request("/" + query_, host_, "POST"), StartsWith("HTTP/1.1 405"));
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

TEST_F(Security, FilesThatABrowserHasAreNotSentAgain) {
  const std::string first = request("/" + query_, host_), mark = "ETag: ";
  const std::string etag = first.substr(first.find(mark) + mark.size(), 34);
  EXPECT_THAT(first, Has("Cache-Control: private, no-cache\r\n"));
  const auto again = [&](const std::string& known) {
    return request("/" + query_, host_ + "If-None-Match: " + known + "\r\n");
  };
  EXPECT_THAT(again(etag), AllOf(StartsWith("HTTP/1.1 304"), Lacks("secret")));
  EXPECT_THAT(again("\"" + std::string(32, '0') + "\""), AllOf(StartsWith("HTTP/1.1 200"), Has("secret")));
  EXPECT_THAT(request("/none" + query_, host_), Has("no-store"));
}

TEST_F(Security, OtherPathsSizesAndProtocolsAreRefused) {
  EXPECT_THAT(request("/../../etc/passwd" + query_, host_), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(request("/" + query_, host_ + "X-Long: " + std::string(3000, 'x') + "\r\n"),
              StartsWith("HTTP/1.1 431"));
  EXPECT_THAT(request("/" + query_, host_ + "Content-Length: 100000000\r\n"), StartsWith("HTTP/1.1 413"));
  EXPECT_THAT(answer(upgrade("/socket" + query_, host_, "chat")), StartsWith("HTTP/1.1 400"));
  expect_alive();
}

TEST_F(Security, NoMoreClientsThanAllowedAreServed) {
  std::list<SocketClient> clients;
  for (int i = 0; i < 6; ++i) clients.emplace_back(server_.access());
  RawClient more(port_);
  more.send(fmt::format("GET /{} HTTP/1.1\r\n{}\r\n", query_, host_));
  EXPECT_EQ(more.response(), "");
  EXPECT_TRUE(more.is_closed_within(3000));
  clients.clear();
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  expect_alive();
}

TEST_F(Security, GarbageAndASlowRequestEndOnlyTheirOwnConnections) {
  const std::string unmasked("\x81\x02hi", 4), huge("\x81\xff\x7f\xff\xff\xff\xff\xff\xff\xff\0\0\0\0", 14);
  for (const std::string& frame : {unmasked, huge, client_frame(0x83, "hi"), client_frame(0x81, "\xff\xfe"),
                                   text_frame(std::string(1100, 'x'))}) {  // the last one is too long
    SocketClient client(server_.access());
    client.say(std::string(900, 'x'));
    EXPECT_TRUE(client.next().has_value());
    client.send(frame);
    EXPECT_TRUE(client.is_closed_within(3000));
    EXPECT_THAT(client.until("heard"), Lacks("heard"));
  }
  for (const std::string& bytes : {std::string("\x16\x03\x01\x02\0\x01", 6), std::string("GET\r\n\r\n"),
                                   std::string("GET / HTTP/1.1\r\nHost: ")}) {  // the last one is slow
    RawClient client(port_);
    client.send(bytes);
    EXPECT_TRUE(client.is_closed_within(3000));
  }
  expect_alive();
}

}  // namespace
}  // namespace sim::view
