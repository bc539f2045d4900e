#include "sim/view/server.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <future>
#include <nlohmann/json.hpp>
#include <thread>

#include "sim/recording/image_file.h"
#include "sim/view/live_view.h"
#include "sim/view/site.h"
#include "tests/sim/files/has.h"
#include "tests/sim/view/raw_client.h"

namespace sim::view {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using testing::StartsWith, tests::Has, tests::Lacks;

/// Returns whether a run at that time continues within 200 ms; else resumes it.
bool goes_on(Pace& pace, slam::Stamp t) {
  auto run = std::async(std::launch::async, [&] { pace.wait(t); });
  const bool went = run.wait_for(200ms) == std::future_status::ready;
  if (!went) pace.resume();
  return went;
}

TEST(Pace, APausedRunGoesOnForAStepOrResumedOrWithoutViewers) {
  Pace pace;
  EXPECT_TRUE(goes_on(pace, 5ms));
  pace.pause();
  EXPECT_FALSE(goes_on(pace, 10ms));
  EXPECT_TRUE(goes_on(pace, 15ms)) << "resumed above";
  pace.pause();
  pace.step(34ms);
  EXPECT_TRUE(pace.state().paused);
  EXPECT_TRUE(goes_on(pace, 45ms));
  EXPECT_FALSE(goes_on(pace, 50ms));
  pace.pause();
  pace.set_speed(0.25);
  pace.release();
  EXPECT_TRUE(goes_on(pace, 1000s)) << "neither paused nor slow";
}

TEST(Pace, SpeedIsThatOfSimulatedTimeAndFullUnlessItIsSet) {
  Pace pace;
  auto begin = Clock::now();
  for (slam::Stamp t{0}; t < 1000s; t += 1s) pace.wait(t);
  EXPECT_LT(Clock::now() - begin, 5s);
  pace.set_speed(0.25);
  begin = Clock::now();
  for (slam::Stamp t = 999s; t <= 999s + 100ms; t += 5ms) pace.wait(t);
  EXPECT_GE(Clock::now() - begin, 390ms);  // it never runs ahead; how late it is depends on the machine
  EXPECT_LT(Clock::now() - begin, 3s);
}

/// The next message that is not a drawing of the strips.
std::optional<std::string> next_message(RawClient& client) {
  for (;;)
    if (auto payload = next_payload(client); !payload || payload->find("\"op\":\"strips\"") == payload->npos)
      return payload;
}

void say_loaded(RawClient& client) { client.send(text_frame(R"({"op":"loaded"})")); }

Frame frame_at(int k) { return {.t = k * 33ms, .image = cv::Mat(240, 320, CV_8UC1, cv::Scalar(k % 256))}; }

/// Shows frames until their only viewer, which does not read, has room for no more of them.
bool fills_its_viewer(LiveView& view) {
  const auto end = Clock::now() + 60s;
  for (int k = 0; Clock::now() < end; ++k) {
    view.show(frame_at(k));
    if (view.has_viewers()) continue;
    std::this_thread::sleep_for(100ms);  // the kernel may still take what waits
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

TEST_F(Live, AViewerIsSentTheFramesThatAreShownAtMostFortyASecond) {
  EXPECT_FALSE(view_.wants({})) << "without a viewer";
  RawClient client(view_.access().port);
  open_socket(client, view_.access());
  ASSERT_TRUE(has_a_viewer(view_));
  EXPECT_EQ(next_message(client), R"({"op":"pace","paused":false,"speed":0.0})");
  EXPECT_TRUE(view_.wants({}));
  view_.show(frame_at(3));
  EXPECT_FALSE(view_.wants({}));
  EXPECT_THAT(next_message(client).value_or(""), Has("{\"t\":0.099,\"image\":[320,240]}"));
  std::this_thread::sleep_for(30ms);
  EXPECT_TRUE(view_.wants({}));
  say_loaded(client);
  view_.end("The run has ended.");
  EXPECT_EQ(next_message(client), R"({"op":"ended","how":"The run has ended."})");
}

// Its queue and the kernel's buffers fill; then no more frames are made for it, and the run does not wait.
TEST_F(Live, AStalledViewerCostsNothingAndOneThatReadsIsServedBesideIt) {
  RawClient stalled(view_.access().port, "127.0.0.1", 4096);
  open_socket(stalled, view_.access());
  say_loaded(stalled);
  ASSERT_TRUE(has_a_viewer(view_));
  const auto begin = Clock::now();
  ASSERT_TRUE(fills_its_viewer(view_)) << "whoever waited for it would wait for ever";
  EXPECT_FALSE(view_.wants({}));
  RawClient reading(view_.access().port);
  open_socket(reading, view_.access());
  say_loaded(reading);
  ASSERT_TRUE(has_a_viewer(view_));
  next_message(reading);  // the pace
  next_message(reading);  // the last frame
  view_.show(frame_at(2000));
  EXPECT_THAT(next_message(reading).value_or(""), Has("\"t\":66.0"));
  view_.end("done");  // gives up waiting for the stalled one
  EXPECT_LT(Clock::now() - begin, 90s);
}

// On a busy machine a browser may fetch for longer than the limit for messages and draw for a second.
TEST_F(Live, AViewerThatIsSlowForASecondIsToldHowTheRunEnded) {
  auto view = std::make_unique<LiveView>(Access{.token = kToken}, ShownRun{.label = "a walk"}, false);
  RawClient slow(view->access().port, "127.0.0.1", 4096);
  open_socket(slow, view->access());
  ASSERT_TRUE(has_a_viewer(*view));
  ASSERT_TRUE(fills_its_viewer(*view));
  std::thread program([&] {
    view->end("done");
    view.reset();
  });
  std::this_thread::sleep_for(3100ms);
  say_loaded(slow);
  std::this_thread::sleep_for(1s);
  std::string last;
  for (auto payload = next_message(slow); payload && !payload->empty(); payload = next_message(slow)) {
    last = *payload;
    if (last.find("ended") != last.npos) break;
  }
  EXPECT_EQ(last, R"({"op":"ended","how":"done"})");
  program.join();
}

// An image comes with the first frame, a sweep with one that is not shown.
TEST(LiveRig, APageFetchesTheNewestReadingsOfTheFramesItWasSent) {
  recording::RecordingSetup setup;
  setup.rig = {{.name = "rgb0", .kind = rig::Kind::color}, {.name = "lidar0", .kind = rig::Kind::lidar}};
  LiveView view({.token = kToken}, {.label = "a walk", .rig = setup.rig}, false);
  view.begin(setup);
  RawClient client(view.access().port), fetching(view.access().port);
  open_socket(client, view.access());
  ASSERT_TRUE(has_a_viewer(view));
  next_message(client);  // the pace
  const cv::Mat red(2, 3, CV_8UC3, cv::Scalar(255, 0, 0));
  slam::Observation with_image, with_sweep;
  with_image.rig.emplace_back().image = red;
  with_sweep.rig.emplace_back().sensor = 1;
  with_sweep.rig[0].points = {{1, 2, 3}};
  view.wants(with_image);
  view.show(frame_at(3));
  EXPECT_THAT(next_message(client).value_or(""), Has("\"rig\":0}"));
  view.wants(with_sweep);
  view.show(frame_at(4));
  EXPECT_THAT(next_message(client).value_or(""), Has("\"rig\":1}"));
  const auto body = [&](const std::string& path) {
    fetching.send("GET " + path + "?token=" + kToken + " HTTP/1.1\r\nHost: " + authority(view.access()) +
                  "\r\n\r\n");
    const std::string response = fetching.response();
    EXPECT_THAT(response, StartsWith("HTTP/1.1 200"));
    return response.substr(response.find("\r\n\r\n") + 4);
  };
  EXPECT_EQ(body("/rig/0/0/0"), recording::encode_png(red));
  EXPECT_EQ(body("/rig/0/0/1"), recording::encode_png(red));
  EXPECT_EQ(body("/rig/0/1/0"), "") << "before the first sweep";
  EXPECT_EQ(body("/rig/0/1/1").size(), 12u);
  EXPECT_EQ(body("/rig/0/0/2"), "");
  for (int k = 5; k < 40; ++k) view.show(frame_at(k));
  EXPECT_NE(body("/rig/0/0/36"), "");
  EXPECT_EQ(body("/rig/0/0/0"), "") << "kept for some frames only";
}

TEST_F(Live, FoxgloveIsSpokenOnTheSamePort) {
  view_.begin({});
  for (const std::string protocol : {"foxglove.websocket.v1", "foxglove.sdk.v1"}) {
    RawClient client(view_.access().port);
    open_socket(client, view_.access(), protocol);
    EXPECT_THAT(next_payload(client).value_or(""), StartsWith(R"({"op":"serverInfo","name":"gaitslam")"));
    const std::string advertised = next_payload(client).value_or("");
    for (const char* const topic : {"/camera/image/compressed", "/camera/camera_info", "/imu",
                                    "/ground_truth/pose", "/plan/pose", "/slam/pose"})
      EXPECT_THAT(advertised, Has(fmt::format("\"topic\":\"{}\"", topic)));
    client.send(text_frame(R"({"op":"subscribe","subscriptions":[{"id":77,"channelId":4}]})"));
    client.send(text_frame(R"({"op":"subscribe","subscriptions":[{"id":78,"channelId":99}]})"));
    EXPECT_THAT(next_payload(client).value_or(""), Has("unknown channel 99"));
    Frame frame = frame_at(1);
    frame.truth = Eigen::Isometry3d::Identity();
    view_.show(frame);
    const std::string message = next_payload(client).value_or("");
    EXPECT_EQ(message.substr(0, 5), std::string("\1\x4d\0\0\0", 5));
    client.send(text_frame(R"({"op":"unsubscribe","subscriptionIds":[77]})"));
    client.send(text_frame("{"));
    EXPECT_THAT(next_payload(client).value_or(""), Has("\"status\""));
    view_.show(frame);
    EXPECT_EQ(next_payload(client, 200), std::nullopt);
  }
}

TEST(Site, WhatTakesLongIsEmptyUntilItIsMade) {
  Site site({}, {});
  std::promise<void> go;
  site.add("/pictures/0", [done = go.get_future().share()] {
    done.wait();
    return bytes_resource("painted");
  });
  EXPECT_EQ(*site.at("/pictures/0", "")->bytes, "");
  go.set_value();
  for (int i = 0; i < 300 && site.at("/pictures/0", "")->bytes->empty(); ++i)
    std::this_thread::sleep_for(10ms);
  EXPECT_EQ(*site.at("/pictures/0", "")->bytes, "painted");
}

TEST(Site, HasItsFilesAndNoOthers) {
  Site site({{.label = "walk </script>"}}, {{"mode", "live"}});
  site.add_list("/image/0",
                [](std::size_t k) { return k < 2 ? std::optional(bytes_resource("image")) : std::nullopt; });
  EXPECT_THAT(*site.at("/", "the-token")->bytes, Has("src=\"/view.js?token=the-token\""));
  EXPECT_EQ(site.at("/", "t")->bytes->find("TOKEN"), std::string::npos);
  EXPECT_GT(site.at("/view.js", "")->bytes->size(), 100'000u);
  EXPECT_THAT(*site.at("/view.js", "")->bytes, Lacks("innerHTML="));
  EXPECT_TRUE(site.at("/image/0/1", "").has_value());
  for (const char* const path : {"/image/0/2", "/image/0/-1", "/image/0/1 ", "/image/0/", "/image/0/../1",
                                 "/image/1/0", "/model/0", "view.js", "", "/index.html"})
    EXPECT_FALSE(site.at(path, "").has_value()) << path;
}

TEST(ClientMessage, CommandsAndSubscriptionsOfFoxgloveAreRead) {
  EXPECT_EQ(read_client_message(R"({"op":"pause"})").op, "pause");
  EXPECT_EQ(read_client_message(R"({"op":"getParameters","parameterNames":[]})").op, "getParameters");
  EXPECT_EQ(read_client_message(R"({"op":"speed","factor":0.25})").factor, 0.25);
  EXPECT_EQ(read_client_message(R"({"op":"speed","factor":0})").factor, 0);
  const auto message = read_client_message(
      R"({"op":"subscribe","subscriptions":[{"id":7,"channelId":2},{"id":8,"channelId":4294967295}]})");
  using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
  EXPECT_EQ(message.subscriptions, (Pairs{{7, 2}, {8, 4294967295u}}));
  EXPECT_EQ(read_client_message(R"({"op":"unsubscribe","subscriptionIds":[7]})").unsubscribed,
            std::vector<std::uint32_t>{7});
}

TEST(ClientMessage, WhatIsNoMessageIsMalformed) {
  std::string many = R"({"op":"unsubscribe","subscriptionIds":[0)";
  for (int i = 0; i < 64; ++i) many += ",1";
  many += "]}";
  const std::string deep(8000, '[');
  for (const std::string_view text :
       {"", "x", "{", "[1]", "{}", R"({"op":1})", R"({"op":"speed","factor":1e9})",
        R"({"op":"speed","factor":"1"})", R"({"op":"subscribe"})",
        R"({"op":"subscribe","subscriptions":[1]})",
        R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]})",
        R"({"op":"subscribe","subscriptions":[{"id":4294967296,"channelId":1}]})",
        R"({"op":"unsubscribe","subscriptionIds":["a"]})", many.c_str(), deep.c_str()})
    EXPECT_THROW(read_client_message(text), std::invalid_argument) << text;
}

TEST(MessageQueue, DropsTheOldestFrameButNothingElseAndHasRoomWhileHalfOfItIsFree) {
  MessageQueue queue(3, 2);
  const auto push = [&](const char* text, bool is_frame) {
    return queue.push({std::make_shared<const std::string>(text), !is_frame, is_frame});
  };
  EXPECT_TRUE(push("a", false));
  for (const char* const text : {"1", "2", "3", "4"}) {
    EXPECT_EQ(queue.has_room(), text[0] < '3');
    EXPECT_TRUE(push(text, true));
  }
  EXPECT_TRUE(push("b", false));
  EXPECT_FALSE(push("c", false)) << "no room: the client is to be given up";
  for (const char* const text : {"a", "2", "3", "4", "b"}) EXPECT_EQ(*queue.pop()->bytes, text);
  EXPECT_FALSE(queue.pop().has_value());
  EXPECT_TRUE(queue.has_room());
}

}  // namespace
}  // namespace sim::view
