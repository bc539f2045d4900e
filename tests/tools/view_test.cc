// The view through the program: in a browser, live and of results, and through Foxglove's client.
#include "sim/files/text.h"
#include "tests/tools/command_line.h"

namespace tests {
namespace {

class ViewTest : public CommandLine {
 protected:
  /// Runs a command that prints a URL and, with that URL in $url, `user`.
  Ran viewed(const std::string& command, const std::string& user, const std::string& end = "wait $!") const {
    return shell("rm -f url; '" GAITSLAM_PROGRAM "' " + command +
                 " >url 2>complaint & for i in $(seq 600); do grep -q token url && break; sleep 0.1; done; "
                 "url=$(sed -n 's/^view at //p' url); " +
                 user + " || exit 9; " + end);
  }
  /// The findings in a browser.
  json browsed(const std::string& command, const std::string& how, const std::string& more = "",
               const std::string& end = "wait $!") const {
    const std::string use =
        "timeout 540 node '" + kSources + "/tests/tools/use_page.cjs' " + how + " \"$url\" profile " + more;
    return json::parse(viewed(command, use, end).ends(0).out);
  }
  json played(const std::string& results, const std::string& t) const {
    return browsed("view " + results, "playback", t, "kill -INT $!; wait $!");
  }
};
using LongViewTest = ViewTest;

TEST_F(ViewTest, TheLivePageShowsTheWalkAndObeys) {
  // Long enough for a browser on a busy machine to slow it down.
  write("long.yaml", scenario_of("{straight: {forward_m: 0.6}}, {stand: {duration_s: 150}}", "rate_hz: 10"));
  const json found = browsed("run long.yaml --view --control --wait --out live", "live");
  EXPECT_GT(found["later"]["bodies"], 20);
  EXPECT_GT(found["later"]["ellipsoids"], 5);
  EXPECT_NE(found["first"]["robot"], found["later"]["robot"]);
  EXPECT_TRUE(found["space_changed"]);
  EXPECT_TRUE(found["head_changed"]);
  EXPECT_THAT(found["later"]["state"].get<std::string>(), Has("Filter: tracking"));
  EXPECT_EQ(found["paused_frames"], 0);
  EXPECT_GE(found["stepped_frames"], 1);
  EXPECT_LE(found["stepped_frames"], 2);
  EXPECT_THAT(found["how"].get<std::string>(),
              Has("The run has ended: completed. tools/gaitslam view live/seed-1"));
  EXPECT_THAT(found["said"], IsEmpty()) << "the browser's console is not empty";
}

TEST_F(ViewTest, IsInterruptedWhileItReadsItsResults) {
  short_walks("walks");
  shell(
      "yes '#' | head -c 100000000 >>walks/seed-1/waist_plan.tum; env --default-signal=INT '" GAITSLAM_PROGRAM
      "' view walks/seed-1 >url & until ls -l /proc/$!/fd | grep -q waist_plan.tum; do kill -0 $! || exit "
      "77; done; kill -INT $!; wait $!")
      .ends(130);
  EXPECT_EQ(text_of("url"), "");
}

TEST_F(ViewTest, ResultsAreTheSameBytesWithAndWithoutAViewAndAReplayShowsTheRobotOfItsRecording) {
  short_walks("plain");
  EXPECT_GT(browsed("run walk.yaml --view --wait --out viewed", "watch")["frames"], 3);
  const json found = browsed("replay plain/seed-1 --view --wait --out again", "watch");
  EXPECT_GT(found["bodies"], 20);
  EXPECT_GT(found["ellipsoids"], 5);
  EXPECT_THAT(found["how"].get<std::string>(), Has("The replay has ended: completed."));
  EXPECT_THAT(found["said"], IsEmpty());
  EXPECT_EQ(json::parse(ok("replay plain/seed-1 --view --json --out third"))["exit_code"], 0)
      << "nothing else is on standard output";
  EXPECT_THAT(differences(folder_ / "viewed/seed-1", folder_ / "plain/seed-1"), IsEmpty());
  EXPECT_THAT(differences(folder_ / "again", folder_ / "plain/seed-1", "recording/"), IsEmpty());
}

TEST_F(LongViewTest, APlaybackIsScrubbedToTheLoopClosure) {
  write(
      "turn.yaml",
      scenario_of("{stand: {duration_s: 0.3}}, {turn: {angle_deg: 375, step_deg: 15}}"));  // the loop closes
  ASSERT_LE(gaitslam("run turn.yaml --out turn").exit_code, 1);
  const json score = json_in("turn/seed-1/score.json");
  const json& closed = score["metrics"]["loop_time_s"]["value"];
  ASSERT_TRUE(closed.is_number()) << score["metrics"]["loop_time_s"];
  const json found = played("turn/seed-1", std::to_string(closed.get<double>()));
  for (const char* const how : {"scrubbed", "linked"}) {
    const json& there = found[how];
    EXPECT_NEAR(there["t"], closed.get<double>(), 0.001) << how;
    EXPECT_EQ(there["head"], there["index"]) << how;
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(there["frustum"][axis], there["truth"][axis], 1e-6);
  }
  EXPECT_EQ(found["next"]["index"], found["linked"]["index"].get<int>() + 1);
  EXPECT_GT(found["agree"]["own"], 0.5) << "the room as drawn and the head image of one instant";
  EXPECT_GT(found["agree"]["own"], found["agree"]["earlier"].get<double>() + 0.1);
  EXPECT_THAT(found["moments"].dump(), Has("loop closed"));
  EXPECT_GT(found["there"]["ellipsoids"], 20);
  EXPECT_EQ(found["through"], "head");
  EXPECT_LE(found["width_at_400"], 400);
  EXPECT_TRUE(found["space_changed"]);
  EXPECT_THAT(found["said"], IsEmpty());
}

TEST_F(ViewTest, TwoResultsOfAScenarioAreShownSideBySide) {
  short_walks("one");
  short_walks("two", "2");
  const json found = played("one/seed-1 two/seed-2", "1");
  EXPECT_EQ(found["panes"], 2);
  EXPECT_THAT(found["said"], IsEmpty());
}

TEST_F(ViewTest, InterruptedTheViewEndsCleanly) {
  ok("run walk.yaml --without camera,slam --out one");
  for (const char* const signal : {"INT", "TERM", "HUP"}) {
    viewed("view one/seed-1", "true", std::string("kill -") + signal + " $!; wait $!").ends(0);
    EXPECT_EQ(text_of("complaint"), "");
  }
}

TEST_F(ViewTest, WhatCannotBeShownIsRefused) {
  ok("run walk.yaml --without camera,slam --out one");
  const std::string token = " --token 0123456789012345678901";
  expect_refused(
      {{"view nothing", "nothing: no such result folder"},
       {"view one", "one: expected a result folder (score.json), such as one/seed-1"},
       {"view one/seed-1/recording", "is a recording, expected a result folder"},
       {"view one/seed-1 one/seed-1 one/seed-1", "3 results, expected one or two"},
       {"view one/seed-1 --address 0.0.0.0" + token, "--address 0.0.0.0: expected one address"},
       {"view one/seed-1 --address 10.1.2.3", "others can reach it, expected a --token"},
       {"view one/seed-1 --token short", "--token: expected at least 22"},
       {"view one/seed-1 --port 65536", "--port"},
       {"view one/seed-1 --address 192.0.2.1" + token, "; --port 0 takes any free port of --address"},
       {"run walk.yaml --view --seeds 1,2", "--view shows one live walk"}});
  write("one/seed-1/truth.tum", "0 1\n");
  expect_refused("view one/seed-1", "truth.tum");
}

TEST_F(ViewTest, FoxglovesClientHearsTheRun) {
  if (!std::getenv("CI") &&
      !fs::exists(GAITSLAM_SOURCE_DIR "/build/interop/node_modules/@foxglove/ws-protocol"))
    GTEST_SKIP() << "tools/test.sh could not install the client from npm";
  write("stand.yaml", scenario_of("{stand: {duration_s: 2}}, {straight: {forward_m: 0.15}}"));
  for (const std::string protocol : {"foxglove.websocket.v1", "foxglove.sdk.v1"}) {
    const Ran ran =
        viewed("run stand.yaml --view --control --wait --force --out heard",
               "timeout 540 node '" GAITSLAM_SOURCE_DIR
               "/tests/interop/listen_foxglove.cjs' '" GAITSLAM_SOURCE_DIR "/build/interop' \"$url\" " +
                   protocol + " heard/seed-1");
    EXPECT_EQ(ran.exit_code, 0) << protocol << ": " << ran.err << text_of("complaint");
    fs::remove_all(folder_ / "heard");
  }
}

}  // namespace
}  // namespace tests
