// Finished results of a walk in the synthetic room, as played by the page, and their figures over time.
#include <fmt/ranges.h>

#include "sim/files/csv.h"
#include "sim/pages/pages.h"
#include "sim/recording/image_file.h"
#include "sim/recording/recording_format.h"
#include "sim/replay/replay.h"
#include "sim/view/site.h"
#include "tests/sim/files/temporary_folder.h"
#include "tests/sim/trials/synthetic_result.h"

namespace sim::view {
namespace {

const Eigen::AlignedBox2d kSole(Eigen::Vector2d(-0.1, -0.069), Eigen::Vector2d(0.13, 0.069));

namespace fs = std::filesystem;
using tests::Has;

constexpr int kFrames = 40;

/// Replays the walk in this folder into its folder replay, next to the recording.
void replay_walk(const fs::path& walk) {
  result::ResultPlace place;
  place.folder = walk / "replay";
  replay::replay(scenario::read_scenario(walk / "scenario.yaml"), walk / "recording",
                 {{scenario::Ending::completed}}, place, [](double) {});
}

class PlaybackTest : public testing::Test {
 protected:
  PlaybackTest() {
    tests::write_result(folder_ / "walk", tests::short_walk(kFrames),
                        "errors: {faults: [{frames_lost: {from_s: 0.5, duration_s: 0.1}}]}\n");
    replay_walk(folder_ / "walk");
  }

  files::TemporaryFolder folder_;
  fs::path result_ = folder_ / "walk/replay";
};

/// Returns the JSON that the page receives at a path.
nlohmann::json received(Site& site, const std::string& path) {
  return nlohmann::json::parse(*site.at(path, "").value().bytes);
}

TEST_F(PlaybackTest, EveryFrameHasItsPartsAndFaultsAreShownAsMoments) {
  Playback playback = read_playback(result_, {});
  ASSERT_EQ(playback.frames.size(), std::size_t{kFrames});
  ASSERT_EQ(playback.images.size(), std::size_t{kFrames});
  for (std::size_t i = 0; i < playback.frames.size(); ++i) {
    Frame& frame = playback.frames[i];
    EXPECT_TRUE(frame.truth && frame.estimate && frame.covariance && frame.report) << i;
    EXPECT_TRUE(fs::is_regular_file(folder_ / "walk/recording/mav0/cam0/data" / playback.images[i])) << i;
    playback.complete(frame);
  }
  EXPECT_TRUE(playback.frames.front().map.has_value());
  EXPECT_GT(playback.frames.back().report->searched.size(), 5u);
  EXPECT_TRUE(playback.run.camera.has_value());
  EXPECT_NEAR(playback.run.duration_s, slam::seconds(playback.frames.back().t), 1e-9);
  ASSERT_FALSE(playback.run.moments.empty());
  EXPECT_EQ(playback.run.moments[0].kind, "fault");
  EXPECT_EQ(playback.run.moments[0].t_s, 0.5);
  EXPECT_EQ(playback.run.moments[0].text, "frames lost for 0.1 s");
}

TEST_F(PlaybackTest, AReplayElsewhereFindsItsRecordingByItsHash) {
  const auto found_from = [](const fs::path& result, const std::vector<fs::path>& given = {}) {
    return !read_playback(result, {}, given).images[0].empty();
  };
  fs::create_directories(folder_ / "a/b/c");
  for (const char* const place : {"alone", "a/beside"}) {
    fs::rename(result_, folder_ / place);
    EXPECT_TRUE(found_from(folder_ / place)) << place;
    fs::rename(folder_ / place, result_);
  }
  fs::rename(result_, folder_ / "a/b/c/far");
  EXPECT_FALSE(found_from(folder_ / "a/b/c/far"));
  EXPECT_TRUE(found_from(folder_ / "a/b/c/far", {folder_ / "walk"})) << "shown together";
}

TEST_F(PlaybackTest, MissingFilesAreReportedAndTheRecordingOfAnotherWalkIsNotUsed) {
  const auto none = read_playback(result_, {}).run.missing;
  ASSERT_EQ(none.size(), 1u);
  EXPECT_THAT(none[0], Has("built without the simulator"));
  const auto robot = [](const scenario::Scenario&) {
    return RobotModel{{}, kSole, [](const Eigen::VectorXd&, const Eigen::Isometry3d&, double) {
                        return std::vector<float>(7);
                      }};
  };
  fs::rename(folder_ / "walk/recording", folder_ / "walk/moved");
  const Playback alone = read_playback(result_, robot);
  ASSERT_EQ(alone.run.missing.size(), 1u);
  EXPECT_THAT(alone.run.missing[0], Has(pages::read_run(result_).about.recording.substr(0, 12),
                                        "is not in " + (result_ / "recording").string()));
  EXPECT_TRUE(alone.images[0].empty());
  fs::rename(folder_ / "walk/moved", folder_ / "walk/recording");
  tests::write_result(folder_ / "other", tests::short_walk(kFrames + 1));
  fs::remove_all(folder_ / "walk/recording");
  fs::rename(folder_ / "other/recording", folder_ / "walk/recording");
  EXPECT_TRUE(read_playback(result_, {}).images[0].empty()) << "the recording of another walk";
}

TEST_F(PlaybackTest, PicturesAreAsRecordedAndInTheirFolder) {
  const fs::path recording = folder_ / "walk/recording", rows = recording / "mav0/cam0/data.csv";
  const auto playback = read_playback(result_, {});
  const std::string name = playback.images[3];
  const fs::path picture = recording / "mav0/cam0/data" / name;
  const auto complaint = [&] {
    return files::error_of([&] {
      const pages::Pictures pictures(recording);
      pictures.read(recording::head_camera(pictures.setup()), name);
    });
  };
  EXPECT_EQ(complaint(), "");
  std::string edited = files::read_text(picture);
  edited[30] ^= 1;
  files::write_text(picture, edited);
  EXPECT_THAT(complaint(), Has(name));
  files::write_text(rows, "#t,file\n" + std::to_string(recording::kEpoch.count()) + ",../../a.png\n");
  EXPECT_THAT(files::error_of([&] { pages::Pictures(recording).files(playback.frames); }),
              Has("data.csv: truncated"));
}

TEST_F(PlaybackTest, PiecesAreReadOneByOneWithTheSameContentAsAllAtOnce) {
  const auto whole = pages::read_run(result_);
  Playback playback = read_playback(result_, {});
  EXPECT_FALSE(playback.frames.back().map.has_value()) << "not read yet";
  files::write_text(result_ / "map.csv", "#id\n1\n");
  Site site = playback_site({playback}, {});
  std::size_t count = 0;
  for (std::size_t piece = 0; piece < 1; ++piece)
    for (const auto& frame : received(site, fmt::format("/frames/0/{}", piece))) {
      const Frame& expected = whole.frames[count++];
      EXPECT_EQ(frame["searches"].size(), expected.report->searched.size());
      EXPECT_EQ(frame["new"].size(), expected.report->initialized.size());
      EXPECT_EQ(frame.contains("map"), expected.map.has_value());
    }
  EXPECT_GT(count, 20u);
  EXPECT_THAT(files::error_of([&] { site.at("/frames/0/1", ""); }), Has("map.csv"));
}

// The second eye has an image at every frame starting with the third, the lidar a sweep at every third frame.
TEST(PlaybackOfARig, EachFrameHasTheNewestReadingOfEachCameraAndLidar) {
  const files::TemporaryFolder folder;
  std::vector<rig::RigSensor> rig(2);
  rig[0].name = "cam1", rig[0].camera = slam::synthetic::calibration().camera;
  rig[1].name = "lidar0", rig[1].kind = rig::Kind::lidar, rig[1].furthest_m = 9;
  const cv::Size size(rig[0].camera.width_px, rig[0].camera.height_px);
  tests::write_result(folder / "walk", tests::short_walk(9), "", rig, [&](int k, slam::Stamp t) {
    std::vector<slam::RigReading> all;
    for (const int sensor : {0, 1}) {
      if (sensor == 0 ? k < 3 : k % 3 != 0) continue;
      slam::RigReading& reading = all.emplace_back();
      reading.sensor = sensor, reading.t = t;
      if (sensor == 0) reading.image = cv::Mat(size, CV_8UC1, cv::Scalar(k));
      if (sensor == 1) reading.points = {{static_cast<float>(k), 0, 0}};
    }
    return all;
  });
  replay_walk(folder / "walk");
  const Playback playback = read_playback(folder / "walk/replay", {});
  ASSERT_EQ(playback.rig.size(), 2u);
  EXPECT_TRUE(playback.rig[0][2].empty());
  EXPECT_EQ(playback.rig[1][4], playback.rig[1][3]);
  const auto read = [&](std::size_t sensor, std::size_t k) {
    return playback.pictures->read(playback.run.rig[sensor], playback.rig[sensor][k]);
  };
  EXPECT_EQ(read(0, 7).image.at<unsigned char>(5, 5), 7);
  EXPECT_EQ(read(1, 8).points[0].x_m, 6);
}

TEST_F(PlaybackTest, ALineBreaksWhereThereIsNoEstimate) {
  const auto whole = pages::read_run(result_);
  auto lines = files::lines_of(files::read_text(result_ / "estimate_cov.txt"));
  lines.erase(lines.begin() + 10, lines.begin() + 20);
  files::write_text(result_ / "estimate_cov.txt", fmt::format("{}\n", fmt::join(lines, "\n")));
  fs::rename(folder_ / "walk/recording", result_ / "recording");
  const auto gap = pages::read_run(result_);
  EXPECT_THAT(pages::run_sections(gap, "", ""), Has("head camera at"));
  const auto breaks = [](const std::vector<double>& values) {
    return std::ranges::count_if(values, [](double value) { return std::isnan(value); });
  };
  EXPECT_EQ(breaks(whole.errors->distance), 0);
  EXPECT_EQ(breaks(gap.errors->distance), 10);
  EXPECT_EQ(breaks(gap.estimate->x), 10);
}

TEST_F(PlaybackTest, ATruncatedFileIsDetectedAndTimesAreOptional) {
  for (const auto& [file, complaint] : {std::pair{"truth.tum", "it or estimate_cov.txt was truncated"},
                                        {"estimate_cov.txt", "it or estimate_cov.txt was truncated"},
                                        {"plan.tum", "truth.tum: does not end like plan.tum"},
                                        {"waist_truth.tum", "does not end like waist_plan.tum"},
                                        {"waist_plan.tum", "does not end like waist_plan.tum"}}) {
    const std::string whole = files::read_text(result_ / file);
    files::write_text(result_ / file, whole.substr(0, whole.find('\n', whole.size() / 2) + 1));
    EXPECT_THAT(files::error_of([&] { pages::read_run(result_); }), Has("truth.tum", complaint)) << file;
    files::write_text(result_ / file, whole);
  }
  fs::remove(result_ / "timing.json");
  EXPECT_EQ(files::error_of([&] { pages::read_run(result_); }), "");
}

TEST_F(PlaybackTest, ResultsOfTwoScenariosAreNotShownSideBySide) {
  std::vector<Playback> two(2, read_playback(result_, {}));
  EXPECT_NO_THROW(playback_site(two, {}));
  two[1].data.scenario = "another";
  EXPECT_THROW(playback_site(two, {}), std::invalid_argument);
}

TEST_F(PlaybackTest, ErrorsAreComparedOverTheTimeThatBothRunsTrack) {
  const Playback whole = read_playback(result_, {});
  Playback lost = whole;
  for (std::size_t i = kFrames / 2; i < kFrames; ++i) lost.frames[i].report->health = slam::Health::lost;
  Site site = playback_site({whole, lost}, {}), same = playback_site({whole, whole}, {});
  double sum = 0;
  for (int i = 0; i < kFrames / 2; ++i)
    sum += pages::error_of(whole.frames[static_cast<std::size_t>(i)])->error.head<3>().squaredNorm();
  const auto row = received(site, "/about")["changes"]["rows"][0]["cells"];
  EXPECT_THAT(row[0].get<std::string>(), Has("RMS error of position while both track, to 0.6 s [mm]"));
  for (const int run : {1, 2})
    EXPECT_NEAR(std::stod(row[static_cast<std::size_t>(run)].get<std::string>()),
                1e3 * std::sqrt(sum / (kFrames / 2)), 1e-2);
  EXPECT_THAT(received(same, "/about")["changes"].dump(), testing::Not(Has("while both track")));
}

TEST_F(PlaybackTest, RunsWithTheSameImageErrorsShareAnImageAndALostFrameHasNoSource) {
  Playback a = read_playback(result_, {});
  const std::size_t lost = 16;  // at 0.5 s
  EXPECT_FALSE(a.sources[lost].has_value());
  EXPECT_EQ(a.sources[lost - 2], lost - 2);
  Playback b = a;
  b.errors.emplace(sensor_errors::ImageOptions{.gain = 2}, 1, std::vector<sensor_errors::Fault>());
  Site site = playback_site({a, a, b}, {});
  const auto runs = received(site, "/about")["runs"];
  EXPECT_EQ(runs[1]["seen"], 0);
  EXPECT_EQ(runs[2]["seen"], 2);
  EXPECT_FALSE(site.at(fmt::format("/seen/0/{}", kFrames), "").has_value());
}

// A force of 100 N at (0.02, 0.01) of a sole that is turned by a right angle and stands at (1, 2), and three
// times that force at the origin of another.
TEST(ZeroMomentPoint, IsWhereTheForcesAct) {
  const SoleForce sole{{1, 2, M_PI / 2}, {0, 0, 100}, {1, -2, 0}}, other{{5, 6, 0}, {0, 0, 300}, {0, 0, 0}};
  const auto p = zero_moment_point({sole, other});
  ASSERT_TRUE(p.has_value());
  EXPECT_NEAR(p->x(), (1 - 0.01 + 3 * 5) / 4, 1e-12);
  EXPECT_NEAR(p->y(), (2 + 0.02 + 3 * 6) / 4, 1e-12);
  const SoleForce light{{0, 0, 0}, {0, 0, 15}, {0, 0, 0}}, none{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  EXPECT_FALSE(zero_moment_point({light, none}).has_value());
}

constexpr std::size_t kSlip = 12, kMargin = 14;  // columns of Series
static_assert(std::string_view(Series::kNames[kSlip]) == "slip_left" &&
              std::string_view(Series::kNames[kMargin]) == "margin");

// Two soles side by side, of 0.23 m by 0.138 m each, 0.2 m apart.
TEST(Series, TheSupportPolygonIsTheConvexHullAndTheMarginIsToItsNearestEdge) {
  Footing footing(kSole);
  Series series;
  for (const double y : {0.0, 0.15}) {
    Frame frame{.zmp = Eigen::Vector2d(0, y)};
    frame.feet = {FootPlace{{.truth = {0, 0.1, 0}, .load_n = 100}},
                  FootPlace{{.truth = {0, -0.1, 0}, .load_n = 100}}};
    footing.add(frame);
    series.add(frame);
    EXPECT_EQ(frame.support.size(), 4u);
  }
  EXPECT_NEAR(series.rows()[0][kMargin], 100, 1e-3) << "to the heels";
  EXPECT_NEAR(series.rows()[1][kMargin], 19, 1e-3);
}

// The left foot is set down, slips by 3 mm, and is lifted; the right one never carries load.
TEST(Series, SlipIsMeasuredFromWhereAFootWasSetDown) {
  Footing footing(kSole);
  Series series;
  std::optional<Eigen::Vector3d> landed;
  for (const auto& [load, x] : {std::pair{500.0, 1.0}, {400.0, 1.003}, {30.0, 1.003}, {5.0, 1.1}}) {
    Frame frame{.t = std::chrono::milliseconds(33 * series.rows().size())};
    frame.feet.emplace();
    (*frame.feet)[0] = {{.truth = {x, 0, 0}, .load_n = load}};
    footing.add(frame);
    series.add(frame);
    landed = (*frame.feet)[0].landed;
    EXPECT_EQ(frame.support.size(), load > 20 ? 4u : 0u);
  }
  EXPECT_FALSE(landed.has_value());
  const auto slip = [&](std::size_t row) { return series.rows().at(row)[kSlip]; };
  EXPECT_EQ(slip(0), 0);
  EXPECT_NEAR(slip(2), 3, 1e-9);
  EXPECT_TRUE(std::isnan(slip(3)));
  EXPECT_EQ(series.bytes().size() % 4, 0u) << "float32 values are read in place";
}

}  // namespace
}  // namespace sim::view
