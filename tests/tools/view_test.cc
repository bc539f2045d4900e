// The view, through the program, in a browser: live and for results.
#include "sim/files/csv.h"
#include "sim/files/trajectory_file.h"
#include "sim/recording/image_file.h"
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
  json browsed(const std::string& command, const std::string& how, const std::string& more = "",
               const std::string& end = "wait $!") const {
    const std::string use =
        "timeout 540 node '" + kSources + "/tests/tools/use_page.cjs' " + how + " \"$url\" profile " + more;
    return json::parse(viewed(command, use, end).ends(0).out);
  }
  json shown(const std::string& results, const std::string& how, const std::string& more = "") const {
    return browsed("view " + results, how, more, "kill -INT $!; wait $!");
  }
};
using LongViewTest = ViewTest;

TEST_F(ViewTest, TheLivePageShowsTheWalkAndObeysItsControls) {
  // Long enough for a browser on a busy machine to slow it down.
  write("long.yaml", scenario_of("{straight: {forward_m: 0.6}}, {stand: {duration_s: 60}}", "rate_hz: 10"));
  const json found =
      browsed("run long.yaml --view --control --wait --out live", "live", "", "kill -INT $!; wait $!");
  EXPECT_GT(found["later"]["bodies"], 20);
  EXPECT_GT(found["later"]["ellipsoids"], 5);
  EXPECT_NE(found["first"]["robot"], found["later"]["robot"]);
  EXPECT_TRUE(found["space_changed"]);
  EXPECT_TRUE(found["head_changed"]);
  EXPECT_THAT(found["later"]["state"].get<std::string>(), Has("Filter: tracking"));
  EXPECT_EQ(found["back"], 0) << "while the run continues";
  for (const char* const part : {"frame", "value"})
    EXPECT_LT(found["past"][part], 0.2) << "a new page shows the past";
  EXPECT_GT(found["past"]["steps"], 0);
  EXPECT_EQ(found["speed"], "1") << "the run starts in real time";
  EXPECT_EQ(found["ended"], "playback") << "the end turns the page into a playback";
  EXPECT_EQ(found["after"], 1) << "also after a reload";
  EXPECT_GT(found["received"], 600) << "with all frames";
  EXPECT_EQ(found["paused_frames"], 0);
  EXPECT_GE(found["stepped_frames"], 1);
  EXPECT_LE(found["stepped_frames"], 2);
  EXPECT_THAT(found["how"].get<std::string>(),
              Has("The run has ended: completed. tools/gaitslam view live/seed-1"));
  EXPECT_THAT(found["said"], IsEmpty()) << "the browser's console is not empty";
}

TEST_F(ViewTest, CanBeInterruptedWhileItReadsItsResults) {
  short_walks("walks");
  shell("yes '#' | head -c 100000000 >>walks/seed-1/truth.tum; env --default-signal=INT '" GAITSLAM_PROGRAM
        "' view walks/seed-1 >url & until ls -l /proc/$!/fd | grep -q truth.tum; do kill -0 $! || exit "
        "77; done; kill -INT $!; wait $!")
      .ends(0);
  EXPECT_THAT(text_of("url"), StartsWith("view at ")) << "the server is there before the result is read";
}

TEST_F(ViewTest, ResultsAreTheSameBytesWithAndWithoutAView) {
  short_walks("plain");
  const json found =
      browsed("run walk.yaml --view --wait --out viewed", "watch", "", "kill -INT $!; wait $!");
  EXPECT_GT(found["frames"], 3);
  EXPECT_GT(found["bodies"], 20);
  EXPECT_GT(found["ellipsoids"], 5);
  EXPECT_THAT(found["how"].get<std::string>(), Has("The run has ended: completed."));
  EXPECT_THAT(found["said"], IsEmpty());
  EXPECT_EQ(json::parse(ok("run walk.yaml --view --json --out third"))["exit_code"], 0)
      << "nothing else is on standard output";
  EXPECT_THAT(differences(folder_ / "viewed/seed-1", folder_ / "plain/seed-1"), IsEmpty());
}

TEST_F(LongViewTest, APlaybackCanBeScrubbedToTheLoopClosure) {
  write(
      "turn.yaml",
      scenario_of("{stand: {duration_s: 0.3}}, {turn: {angle_deg: 375, step_deg: 15}}"));  // the loop closes
  ASSERT_LE(gaitslam("run turn.yaml --out turn").exit_code, 1);
  const json score = json_in("turn/seed-1/score.json");
  const json& closed = score["metrics"]["loop_time_s"]["value"];
  ASSERT_TRUE(closed.is_number()) << score["metrics"]["loop_time_s"];
  const json found = shown("turn/seed-1", "playback", std::to_string(closed.get<double>()));
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
  EXPECT_EQ(found["through"]["mode"], "head");
  EXPECT_THAT(found["through"]["note"].get<std::string>(), Has("without the lens distortion"));
  EXPECT_EQ(found["space"]["ellipsoids"], 3000);
  EXPECT_GE(found["space"]["room"], 3000) << "no landmark is dropped";
  EXPECT_GT(found["space"]["height"], 0.0) << "the view stays above the floor";
  EXPECT_LE(found["width_at_400"], 400);
  EXPECT_TRUE(found["space_changed"]);
  EXPECT_THAT(found["said"], IsEmpty());
}

TEST_F(ViewTest, TheKeyboardWorksAfterClicksAndAnArrowMovesOneFrame) {
  short_walks("one");
  ok("replay one/seed-1 'errors.faults=[{frames_lost: {from_s: 0.5, duration_s: 0.2}}]' --out lost");
  const json found = shown("lost", "keys");
  for (const auto& [control, frames] : found["moved"].items())
    EXPECT_EQ(frames, 1) << "after a click on " << control;
  EXPECT_EQ(found["moved"].size(), 7u);
  EXPECT_EQ(found["playing"], false) << "space after a click on play pauses";
  EXPECT_THAT(found["said"], IsEmpty());
}

// The estimator logs the mean gray value of each image that it gets.
TEST_F(ViewTest, TheHeadImageIsTheOneThatTheEstimatorGot) {
  std::string program = sim::files::read_text(kSources + "/tools/examples/gyro_and_plan.py");
  const std::string call = "            estimator.process(data)\n";
  ASSERT_NE(program.find(call), program.npos);
  program.insert(program.find(call),
                 "            t, w, h, g, a = struct.unpack_from('<qIIII', data)\n"
                 "            if w: print(t, np.frombuffer(data, 'u1', w * h, 368 + 40 * (g + a)).mean())\n"
                 "            sys.stdout.flush()\n");
  write("gray.py", program);
  short_walks("one");
  ok("replay one/seed-1 'errors.faults=[{frames_dimmed: {from_s: 0.5, duration_s: 0.2, factor: 0.3}}, "
     "{frames_covered: {from_s: 0.8, duration_s: 0.1}}, {frames_lost: {from_s: 1, duration_s: 0.1}}]' "
     "'estimator={program: [/usr/bin/python3, gray.py]}' --out faults");
  std::map<double, double> means;
  for (const std::string& line : sim::files::lines_of(text_of("faults/estimator.log"))) {
    long long t = 0;
    double mean = 0;
    ASSERT_EQ(std::sscanf(line.c_str(), "%lld %lf", &t, &mean), 2) << line;
    means[1e-9 * static_cast<double>(t)] = mean;
  }
  const json found = shown("faults", "images", "0.61 0.11 0.81 1.01");
  const auto mean_at = [&](double t) { return means.lower_bound(t - 1e-4)->second; };
  ASSERT_EQ(found["seen"].size(), 4u);
  for (int i = 0; i < 3; ++i) {
    const json& seen = found["seen"][i];
    EXPECT_NEAR(seen["mean"], mean_at(seen["t"]), 1) << seen;
    EXPECT_EQ(seen["isLost"], false);
  }
  EXPECT_GT(found["recorded"]["mean"].get<double>(), 2 * found["seen"][0]["mean"].get<double>());
  EXPECT_EQ(found["seen"][3]["isLost"], true);
  EXPECT_THAT(found["said"], IsEmpty());
}

TEST_F(ViewTest, ValuesAtTheCursorMatchTheFilesAndAZoomKeepsTheCursorAtItsTime) {
  short_walks("one");
  const json found = shown("one/seed-1", "values", "250");
  const auto truth = sim::files::read_tum(folder_ / "one/seed-1/truth.tum"),
             estimate = sim::files::read_tum(folder_ / "one/seed-1/estimate.tum");
  std::vector<double> landmarks;
  for (sim::files::CsvReader rows(folder_ / "one/seed-1/frames.csv"); rows.next();)
    landmarks.push_back(rows.number(1));
  std::map<int, std::pair<double, double>> lives;  // begin and end of each landmark
  for (sim::files::CsvReader rows(folder_ / "one/seed-1/landmarks.csv"); rows.next();)
    lives[static_cast<int>(rows.integer(0))] = {1e-9 * rows.number(1),
                                                rows.text(4).empty() ? INFINITY : 1e-9 * rows.number(4)};
  std::set<int> stored;
  for (const auto& [file, column] : {std::pair{"map_over_time.csv", 1}, {"map.csv", 0}})
    for (sim::files::CsvReader rows(folder_ / "one/seed-1" / file); rows.next();)
      stored.insert(static_cast<int>(rows.integer(static_cast<std::size_t>(column))));
  ASSERT_EQ(found["at"].size(), 250u);
  for (const json& at : found["at"]) {
    const std::size_t i = at["index"];
    ASSERT_EQ(truth[i].t, estimate[i].t);
    const Eigen::Vector3d error = 1e3 * (estimate[i].X.translation() - truth[i].X.translation());
    for (const auto& [name, value] : {std::pair{"x", error.x()}, {"distance", error.norm()}})
      EXPECT_NEAR(std::stod(at[name].get<std::string>()), value,
                  0.501 * std::pow(10, std::floor(std::log10(std::abs(value))) - 3))
          << name << " at " << at["t"];
    EXPECT_EQ(std::stod(at["landmarks"].get<std::string>()), landmarks[i]) << at["t"];
    const double t = 1e-9 * static_cast<double>(truth[i].t.count());
    std::map<int, double> ages;
    for (const auto& [id, life] : lives)
      if (life.first <= t + 1e-6 && life.second > t + 1e-6 && stored.contains(id)) ages[id] = t - life.first;
    ASSERT_EQ(at["ages"].size(), ages.size()) << at["t"] << ": the map is the filter's";
    for (const json& age : at["ages"]) EXPECT_NEAR(age[1], ages.at(age[0]), 0.0051) << at["t"];
    EXPECT_THAT(at["said"].get<std::string>(),
                StartsWith(fmt::format("{:.0f} landmarks (positions of ", landmarks[i])));
  }
  for (const json& figure : found["zoomed"]) {
    EXPECT_EQ(figure["range"], found["zoomed"][0]["range"]) << "all figures are zoomed together";
    EXPECT_NEAR(figure["cursor"], figure["legend"], 1e-3);
  }
  EXPECT_NEAR(found["scrubbed"], 0.72, 0.1) << "a drag goes to the time below the mouse";
  EXPECT_GT(found["zoomed"][0]["range"][0], 0.0) << "the wheel zooms";
  EXPECT_EQ(found["hidden"], "none") << "a name in a legend hides its line";
  const json& picked = found["picked"];
  EXPECT_EQ(picked["id"], found["wanted"]);
  EXPECT_EQ(picked["from_scene"], (json{{"id", found["wanted"]}, {"marked", found["wanted"]}}));
  EXPECT_EQ(picked["marked"], true);
  std::string counts;
  for (int i = 0; const char* const how : {" found", " missed", " rejected"})
    counts += (i > 0 ? ", " : "") + picked["counts"][i].dump() + how, ++i;
  EXPECT_THAT(
      picked["text"].get<std::string>(),
      AllOf(Has("landmark " + found["wanted"].dump() + ", ", " s old, σ "), testing::EndsWith(counts)));
  EXPECT_THAT(found["said"], IsEmpty());
}

/// NaN if there is no such mark.
double time_of_mark(const json& found, const std::string& begin) {
  for (const json& mark : found["marked"]["marks"])
    if (mark["text"].get<std::string>().starts_with(begin)) return mark["t"];
  return NAN;
}

TEST_F(ViewTest, TwoRunsAreComparedInOneSceneAndTheirDivergenceIsMarked) {
  short_walks("one");
  ok("replay one/seed-1 'errors.faults=[{frames_lost: {from_s: 0.7, duration_s: 0.3}}]' --out lost");
  const json found = shown("one/seed-1 lost", "compare"), &marked = found["marked"];
  EXPECT_EQ(found["table"][0][0], "errors.faults");
  std::set<std::string> metrics;
  for (const json& line : found["table"]) metrics.insert(line[0].get<std::string>());
  EXPECT_TRUE(metrics.contains("RMSE [mm]")) << found["table"];
  EXPECT_NE(found["table"], found["sorted"]) << "a click on a title orders the rows";
  EXPECT_GT(found["worst"], 0.7) << "a click goes to the worst instant, which is after the fault";
  EXPECT_EQ(marked["scenes"], 1);
  EXPECT_THAT(marked["title"].get<std::string>(), Has("walk, seed 1"));
  EXPECT_THAT(marked["heads"][0].get<std::string>(),
              AllOf(StartsWith("A: errors.faults="), Lacks("frames_lost")));
  EXPECT_THAT(marked["heads"][1].get<std::string>(),
              AllOf(StartsWith("B: errors.faults="), Has("frames_lost")));
  EXPECT_NEAR(marked["t"], 0.7, 0.11) << "a key goes to the first mark";
  EXPECT_EQ(found["beyond"]["value"], nullptr)
      << "a run that ended has no values while a longer one continues";
  EXPECT_THAT(found["beyond"]["state"].get<std::string>(), StartsWith("The run ended at "));
  EXPECT_EQ(marked["shown"][0], marked["shown"][1]) << "both images at one instant";
  EXPECT_EQ(marked["bands"], (json{true, false})) << "3σ of A only";
  EXPECT_THAT(marked["why"].get<std::string>(),
              ContainsRegex("^Why B is worse .RMS error [0-9.]+ mm, A [0-9.]+ mm.: the estimates differ from "
                            "0.[78]0 s; .*frames lost for 0.3 s"));
  for (int run = 0; run < 2; ++run)
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(marked["ghosts"][run][axis], marked["estimates"][run][axis], 1e-5) << run;
  for (const auto& [figure, lines] : marked["lines"].items())
    EXPECT_GE(lines, figure == "distance" ? 3 : 2) << figure << ", with the difference";
  EXPECT_EQ(marked["bottom"], true) << "the errors are on the screen with the scene";
  EXPECT_EQ(marked["table"], true) << "and so are five rows of the table";
  EXPECT_GT(found["covered_at_400"], 20) << "the controls stay on a phone";
  EXPECT_LT(found["covered_at_400"], 80) << "of 800 px";
  EXPECT_NEAR(time_of_mark(found, "first difference between the estimates"), 0.7, 0.11) << marked["marks"];
  EXPECT_LT(found["places"]["apart"], 0.1);
  EXPECT_THAT(found["places"]["text"].get<std::string>(),
              ContainsRegex("A: landmark .* at the same place: B: landmark "));
  EXPECT_EQ(found["nis"], 2) << "a figure on demand has a line of each run";
  EXPECT_EQ(found["hidden"]["columns"], 2) << "a key splits the scene";
  EXPECT_GT(found["differs"], 0) << "each view has its own run";
  EXPECT_LT(found["differs"], 0.1) << "and the same camera";
  EXPECT_EQ(found["hidden"]["visible"], (json{true, false}));
  EXPECT_EQ(found["again"]["visible"], found["hidden"]["visible"]) << "the address holds the layers";
  EXPECT_NEAR(found["again"]["t"], found["hidden"]["t"], 0.01);
  EXPECT_EQ(found["again"]["hash"], found["hidden"]["hash"]);
  EXPECT_LE(found["width_at_400"], 400);
  EXPECT_THAT(found["said"], IsEmpty());
}

TEST_F(LongViewTest, WhereAFaultOfTheSecondRunAloneMovesItsEstimateIsMarkedWithinASecond) {
  write("long.yaml", scenario_of("{stand: {duration_s: 0.3}}, {straight: {forward_m: 1.2}}", "rate_hz: 10"));
  ASSERT_LE(gaitslam("run long.yaml --out one").exit_code, 1);
  gaitslam(
      "replay one/seed-1 'errors.faults=[{frames_lost: {from_s: 3, duration_s: 4}}, {gyro_spike: {from_s: 3, "
      "duration_s: 1, size_rad_s: 0.3}}]' --out lost");
  const json found = shown("one/seed-1 lost", "compare");
  const double mark = time_of_mark(found, "errors differ by more than 3σ");
  EXPECT_NEAR(mark, 3.5, 0.55) << found["marked"]["marks"];
  const json turned = shown("lost one/seed-1", "compare");
  EXPECT_EQ(time_of_mark(turned, "errors differ by more than 3σ"), mark) << "independent of the order";
}

TEST_F(ViewTest, DepthHasAValueAndABarAndLidarPointsAreColoredByHeightOrIntensity) {
  write("rig.yaml", scenario_of("{stand: {duration_s: 0.3}}", "rate_hz: 10") + "rig: d435i_mid360\n");
  ok("run rig.yaml --out rig");
  const json found = shown("rig/seed-1", "rig"), &depth = found["depth"];
  std::set<fs::path> images;
  for (const auto& file : fs::directory_iterator(folder_ / "rig/seed-1/recording/mav0/depth0/data"))
    images.insert(file.path());
  const auto image = sim::recording::decode_png(text_of(*images.rbegin()), CV_16UC1);
  const int u = depth["at"][0], v = depth["at"][1], mm = image->at<std::uint16_t>(v, u);
  EXPECT_GT(mm, 300);
  EXPECT_EQ(depth["text"], fmt::format(" at {}, {}: {} m", u, v, mm / 1000.0)) << "as it was recorded";
  EXPECT_NE(depth["painted"], (json{0, 0, 0, 255}));
  EXPECT_EQ(depth["bars"], 2);
  EXPECT_EQ(found["byHeight"]["depthTest"], true) << "walls hide points";
  for (const char* const how : {"byHeight", "byIntensity"}) EXPECT_GT(found[how]["colors"], 10) << how;
  EXPECT_NE(found["byHeight"]["colors"], found["byIntensity"]["colors"]);
  EXPECT_THAT(found["said"], IsEmpty());
}

TEST_F(ViewTest, TheViewEndsCleanlyWhenInterrupted) {
  ok("run walk.yaml --without camera,slam --out one");
  const auto end_by = [&](const std::string& signal, const std::string& before) {
    viewed("view one/seed-1", before, "kill -" + signal + " $!; wait $!").ends(0);
    EXPECT_EQ(text_of("complaint"), "") << signal;
  };
  for (const char* const signal : {"INT", "TERM", "HUP"}) end_by(signal, "true");
  shell("seq 2000000 | sed 's/$/ 0 0 0 0 0 0 1/' >one/seed-1/truth.tum");  // takes seconds to read
  end_by("TERM", "true");
}

TEST_F(ViewTest, RefusesWhatCannotBeShown) {
  ok("run walk.yaml --without camera,slam --out one");
  const std::string token = " --token 0123456789012345678901";
  expect_refused(
      {{"view nothing", "nothing: no such result folder"},
       {"view one", "one: expected a result folder (score.json), such as one/seed-1"},
       {"view one/seed-1/recording", "is a recording, expected a result folder"},
       {"view one/seed-1 one/seed-1 one/seed-1 one/seed-1 one/seed-1", "5 results, expected 1 to 4"},
       {"view one/seed-1 --address 0.0.0.0" + token,
        "--address 0.0.0.0: means all interfaces, expected a single one"},
       {"view one/seed-1 --address 10.1.2.3", "can be reached by others, expected a --token"},
       {"view one/seed-1 --token short", "--token: expected at least 22"},
       {"view one/seed-1 --port 65536", "--port"},
       {"view one/seed-1 --address 192.0.2.1" + token, "; --port 0 selects any free port"},
       {"run walk.yaml --view --seeds 1,2", "--view: shows one live walk"}});
  write("one/seed-1/truth.tum", "0 1\n");
  EXPECT_THAT(gaitslam("view one/seed-1").ends(2).err, Has("truth.tum"));
}

TEST_F(LongViewTest, TheScriptOfTheFrontPageMakesItsPictures) {
  fs::create_directory(folder_ / "pictures");
  shell("GAITSLAM='" GAITSLAM_PROGRAM "' '" + kSources +
        "/tools/figures/front_page.py' --pictures pictures work")
      .ends(0);
  for (const char* const name : {"walk", "view_live", "view_playback"})
    EXPECT_GT(fs::file_size(folder_ / "pictures" / (std::string(name) + ".webp")), 20'000u) << name;
}

TEST_F(ViewTest, PagesHaveNoSeriousAxeFindingsAndFitANarrowPhone) {
  const std::string modules = kSources + "/build/interop";
  if (!std::getenv("CI") && !fs::exists(modules + "/node_modules/axe-core"))
    GTEST_SKIP() << "tools/test.sh could not install axe-core from npm";
  short_walks("a", "1 2");
  ok("replay a/seed-1 slam.vision.sigma_px=3 --out b");
  ok("report a b --out report.html");
  ok("sweep walk.yaml slam.vision.sigma_px=1,3 slam.depth.first_sight=inverse_depth,particles --jobs 2 --out "
     "sweep");
  ok("report sweep --out sweep.html");
  const std::string use = "timeout 300 node " + kSources +
                          "/tests/tools/use_page.cjs audit \"report.html sweep.html $url\" "
                          "profile " +
                          modules;
  const json found = json::parse(viewed("view a/seed-1 b", use, "kill -INT $!; wait $!").ends(0).out);
  EXPECT_EQ(found.size(), 3u);
  for (const auto& [page, of_page] : found.items()) {
    EXPECT_EQ(of_page["findings"], json::array()) << page;
    EXPECT_LE(of_page["width"], 360) << page;
  }
}

}  // namespace
}  // namespace tests
