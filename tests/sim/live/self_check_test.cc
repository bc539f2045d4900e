// The self check on a short real walk: it passes what is right and detects a lag of one sample or one frame.
#include "sim/live/self_check.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>

#include "sim/files/csv.h"
#include "sim/live/run.h"
#include "tests/sim/result/result_folder.h"

namespace {

namespace fs = std::filesystem;
using namespace sim;

constexpr const char* kWalk = R"(
walk: {commands: [{stand: {duration_s: 0.5}}, {tangent_arc: {radius_m: 0.75, angle_deg: 60}}]}
camera: {}
)";

class SelfCheckTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder() = fs::temp_directory_path() / ("gaitslam self check " + std::to_string(getpid()));
    fs::create_directories(folder());
    const auto read = scenario::read_scenario_text(kWalk, "walk.yaml");
    live::run(
        read,
        {folder() / "result", files::Existing::reject, fs::path(GAITSLAM_SOURCE_DIR) / "models", "1", "", {}},
        [](double) {});
  }
  static void TearDownTestSuite() { fs::remove_all(folder()); }
  static fs::path& folder() {
    static fs::path path;
    return path;
  }
  static fs::path recording() { return folder() / "result/recording"; }

  static std::vector<recording::TrueMotion> motions();
  static live::InertialCheck inertial(std::size_t lag);
  static live::ViewCheck view(std::size_t lag);
};

std::vector<recording::TrueMotion> SelfCheckTest::motions() {
  std::vector<recording::TrueMotion> all;
  std::ifstream in(recording() / "mav0/state_groundtruth_estimate0/data.csv");
  std::string header;
  std::getline(in, header);
  files::CsvReader rows(recording() / "mav0/state_groundtruth_estimate0/data.csv", {header});
  while (rows.next()) {
    recording::TrueMotion motion{slam::Stamp(rows.integer(0)) - recording::kEpoch,
                                 Eigen::Isometry3d::Identity(), rows.vector(8)};
    motion.X_WG.translation() = rows.vector(1);
    motion.X_WG.linear() =
        Eigen::Quaterniond(rows.number(4), rows.number(5), rows.number(6), rows.number(7)).toRotationMatrix();
    all.push_back(motion);
  }
  return all;
}

// The recorded readings against the truth of `lag` readings earlier.
live::InertialCheck SelfCheckTest::inertial(std::size_t lag) {
  const std::vector<recording::TrueMotion> truth = motions();
  live::InertialCheck check(truth.front());
  recording::RecordingReader reader(recording());
  std::size_t k = 0;
  while (const auto o = reader.next())
    for (std::size_t i = 0; i < o->gyro.size(); ++i, ++k) {
      // The first reading leads to the first recorded motion, the start of the check.
      if (k > lag) check.add(o->gyro[i], o->accelerometer[i], truth.at(k - lag));
    }
  return check;
}

// The recorded pictures with the true poses of `lag` frames earlier.
live::ViewCheck SelfCheckTest::view(std::size_t lag) {
  const recording::Truth truth = recording::read_truth(recording());
  recording::RecordingReader reader(recording());
  live::ViewCheck check(reader.setup().calibration.camera, truth.surfaces);
  for (std::size_t k = 0; const auto o = reader.next(); ++k)
    if (k >= lag) check.add(o->image, o->t, truth.camera.at(k - lag).X);
  return check;
}

double degrees(double radians) { return radians * 180 / 3.14159265358979; }

TEST_F(SelfCheckTest, AWalkPassesIt) {
  const nlohmann::json check = tests::json_of(recording() / "self_check.json");
  EXPECT_EQ(check["complaint"], "");
  EXPECT_GT(check["view_px"]["points"], 50);
  EXPECT_NE(tests::json_of(folder() / "result/about.json")["ending"], "failed");
}

TEST_F(SelfCheckTest, IdealReadingsLeadAlongTheTruePath) {
  const live::InertialCheck check = inertial(0);
  EXPECT_LT(check.worst_position_m(), live::kInertialPosition_m);
  EXPECT_GT(check.worst_position_m(), 0);  // not the inverse of the sensor's formula
  EXPECT_LT(degrees(check.worst_yaw_rad()), live::kInertialYaw_deg);
  RecordProperty("position_mm", std::to_string(1e3 * check.worst_position_m()));
}

TEST_F(SelfCheckTest, DetectsReadingsThatLagByOneSample) {
  const live::InertialCheck check = inertial(1);
  EXPECT_GT(degrees(check.worst_yaw_rad()), live::kInertialYaw_deg);
}

TEST_F(SelfCheckTest, DetectsImagesThatLagByOneFrame) {
  EXPECT_LT(view(0).median_px().value(), live::kView_px);
  EXPECT_GT(view(1).median_px().value(), live::kView_px);
}

TEST_F(SelfCheckTest, NamesEachDisagreement) {
  live::SelfCheck check{inertial(0), view(0)};
  EXPECT_EQ(check.complaint(), "");
  check.view = view(1);
  EXPECT_THAT(check.complaint(), testing::HasSubstr("px from their projection by the true pose"));
  check.inertial = inertial(1);
  EXPECT_THAT(check.complaint(), testing::HasSubstr("leave the true"));
  EXPECT_THAT(check.complaint(), testing::HasSubstr(fmt::format("integrated over {:.1f} s, leave",
                                                                slam::seconds(motions().back().t))));
}

TEST_F(SelfCheckTest, AWalkThatAViolentPushEndsFellAndDidNotFail) {
  for (const int impulse_ns : {500, 2000, 10000}) {
    const auto read = scenario::read_scenario_text(
        fmt::format("walk: {{commands: [{{straight: {{forward_m: 0.5}}}}]}}\n"
                    "world: {{pushes: [{{push: {{time_s: 2, impulse_ns: {}, duration_s: 0.1}}}}]}}\n",
                    impulse_ns),
        "walk.yaml");
    const fs::path result = folder() / fmt::format("pushed {}", impulse_ns);
    live::run(read, {result, files::Existing::reject, fs::path(GAITSLAM_SOURCE_DIR) / "models", "1", "", {}},
              [](double) {});
    const nlohmann::json about = tests::json_of(result / "about.json");
    EXPECT_EQ(about["ending"], "fell") << impulse_ns << ": " << about["cause"];
    EXPECT_EQ(tests::json_of(result / "recording/self_check.json")["complaint"], "") << impulse_ns;
  }
}

TEST_F(SelfCheckTest, ReadingsAreCheckedAgainAfterABlow) {
  const auto at = [](int i) { return std::chrono::milliseconds(5 * i); };
  live::InertialCheck check(
      recording::TrueMotion{at(0), Eigen::Isometry3d::Identity(), Eigen::Vector3d::Zero()});
  const auto add = [&](int i, const Eigen::Vector3d& force) {  // while it truly stands still
    check.add({at(i), at(i + 1), Eigen::Vector3d::Zero()}, {at(i), at(i + 1), force},
              {at(i + 1), Eigen::Isometry3d::Identity(), Eigen::Vector3d::Zero()});
  };
  const Eigen::Vector3d rest(0, 0, 9.81);
  add(0, rest + Eigen::Vector3d(1000, 0, 0));
  for (int i = 1; i < 200; ++i) add(i, rest);
  EXPECT_LT(check.worst_position_m(), 1e-9);
  for (int i = 200; i < 400; ++i) add(i, rest + Eigen::Vector3d(0.1, 0, 0));
  EXPECT_GT(check.worst_position_m(), live::kInertialPosition_m);
}

TEST_F(SelfCheckTest, ARunThatFailedItIsNotScored) {
  const auto read = scenario::read_scenario_text(kWalk, "walk.yaml");
  const result::RunRecord record{read,
                                 {scenario::Ending::failed, "self-check: it is off"},
                                 recording::RecordingReader(recording()).setup(),
                                 recording::read_truth(recording()),
                                 std::nullopt,
                                 "hash"};
  fs::create_directories(folder() / "failed");
  const result::Outcome outcome = result::write_result(folder() / "failed", record, {}, result::Timing(), 1);
  EXPECT_EQ(outcome.exit_code, 3);
  const nlohmann::json score = tests::json_of(folder() / "failed/score.json");
  EXPECT_EQ(score["ending"], "failed");
  for (const auto& [name, metric] : score["metrics"].items()) {
    EXPECT_TRUE(metric["value"].is_null()) << name;
    EXPECT_EQ(metric["reason"], "not scored: self-check: it is off");
  }
  EXPECT_EQ(tests::json_of(folder() / "failed/about.json")["cause"], "self-check: it is off");
  EXPECT_TRUE(fs::exists(folder() / "failed/truth.tum"));
}

}  // namespace
