#include "sim/recording/map_file.h"

#include <numeric>

#include "tests/sim/recording/random_readings.h"

namespace sim::recording {
namespace {

using testing::HasSubstr;

/// A point and an inverse depth with correlated parameters.
slam::SavedMap random_map() {
  sensor_errors::Random random(1, "map");
  slam::SavedMap map{3, {}, std::vector<slam::Landmark>(2), Eigen::VectorXd(9), {}};
  Eigen::MatrixXd A(9, 9);
  for (double& value : A.reshaped()) value = random.normal();
  for (double& value : map.x) value = random.normal();
  map.P = A * A.transpose();
  map.P = Eigen::MatrixXd(map.P.selfadjointView<Eigen::Lower>());
  for (slam::Landmark& l : map.landmarks) {
    l.X_WC_first = tests::random_pose(random);
    l.pixel_first = {20 + random.uniform(), 30 + random.uniform()};
    l.tilt = {random.normal(), random.normal()};
    l.p_WC_inflated = tests::random_vector(random);
    for (float& gray : l.patch.gray) gray = float(255 * random.uniform());
    l.attempts = 40, l.successes = 30, l.last_session = 2;
  }
  map.landmarks[0].kind = slam::Point{}, map.landmarks[0].id = 4;
  map.landmarks[1].at = 3, map.landmarks[1].id = 7;
  return map;
}

fs::path file() { return fs::path(testing::TempDir()) / "map.bin"; }

/// The error on reading the file that has this map, or these bytes.
std::string error_of(const slam::CameraIntrinsics& camera = {}) {
  try {
    read_map(file(), camera);
    return "none";
  } catch (const files::FileError& error) {
    return error.what();
  }
}
std::string error_of(const slam::SavedMap& map) {
  files::write_text(file(), map_bytes(map));
  return error_of();
}

TEST(MapFile, ReadsTheSameBitsThatWereWritten) {
  const slam::SavedMap map = random_map();
  files::write_text(file(), map_bytes(map));
  const slam::SavedMap read = read_map(file(), {});
  EXPECT_EQ(read.sessions, 3);
  EXPECT_EQ(read.x, map.x);
  EXPECT_EQ(read.P, map.P);
  ASSERT_EQ(read.landmarks.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const slam::Landmark &a = read.landmarks[i], &b = map.landmarks[i];
    EXPECT_EQ(a.kind.index(), b.kind.index());
    EXPECT_EQ(std::tuple(a.id, a.at, a.attempts, a.successes, a.last_session),
              std::tuple(b.id, b.at, b.attempts, b.successes, b.last_session));
    EXPECT_EQ(a.X_WC_first.matrix(), b.X_WC_first.matrix());
    EXPECT_EQ(a.pixel_first, b.pixel_first);
    EXPECT_EQ(a.tilt, b.tilt);
    EXPECT_EQ(a.p_WC_inflated, b.p_WC_inflated);
    EXPECT_EQ(a.patch.gray, b.patch.gray);
  }
  const std::string text = files::read_text(file());
  files::write_text(file(), map_bytes(read));
  EXPECT_EQ(files::read_text(file()), text);
  EXPECT_THAT(text, HasSubstr(R"("sessions":3,"camera":"320x240 px)"));
}

TEST(MapFile, AFlippedByteATruncatedFileAndAnotherCameraAreRejected) {
  files::write_text(file(), map_bytes(random_map()));
  const std::string text = files::read_text(file());
  for (std::size_t at = 30; at < text.size(); at += 97) {
    std::string flipped = text;
    flipped[at] = char(flipped[at] ^ 1);
    files::write_text(file(), flipped);
    EXPECT_THAT(error_of(), HasSubstr("map.bin: edited or truncated")) << at;
  }
  for (const std::size_t bytes : {0UL, 10UL, 60UL, text.size() / 2, text.size() - 1}) {
    files::write_text(file(), text.substr(0, bytes));
    EXPECT_NE(error_of(), "none") << bytes;
  }
  files::write_text(file(), text);
  slam::CameraIntrinsics other;
  other.fu_px = 198;
  EXPECT_THAT(error_of(other),
              HasSubstr("was made with another calibration: 320x240 px, focal length 197 195"));
  EXPECT_THAT(error_of(other), HasSubstr("expected 320x240 px, focal length 198 195"));
}

TEST(MapFile, NumbersThatAreNotOfAMapAreRejected) {
  const double nan = std::nan("");
  using Spoil = std::function<void(slam::SavedMap&)>;
  const std::vector<std::pair<Spoil, std::string>> cases{
      {[&](auto& map) { map.x(4) = nan; }, "landmark 2 of 2 has a number that is not finite"},
      {[&](auto& map) { map.landmarks[0].tilt.x() = nan; }, "landmark 1 of 2 has a number"},
      {[&](auto& map) { map.landmarks[0].X_WC_first.linear() *= 2; }, "has a first view without a pose"},
      {[&](auto& map) { map.landmarks[1].patch.gray[9] = float(nan); }, "has an invalid patch"},
      {[&](auto& map) { map.landmarks[1].pixel_first.y() = 240; }, "has a first pixel outside the image"},
      {[&](auto& map) { map.landmarks[1].id = 4; }, "has an invalid count"},
      {[&](auto& map) { map.landmarks[1].last_session = 4; }, "has an invalid count"},
      {[&](auto& map) { map.P(5, 5) = nan; }, "has a covariance that is not positive semidefinite"},
      {[&](auto& map) { map.P(5, 2) *= 100; }, "has a covariance that is not positive semidefinite"},
      {[&](auto& map) { map.P(5, 5) *= 0.1; }, "has a covariance that is not positive semidefinite"},
      {[&](auto& map) { map.sessions = 0; }, "has an invalid number of sessions"}};
  for (const auto& [spoil, error] : cases) {
    slam::SavedMap map = random_map();
    spoil(map);
    EXPECT_THAT(error_of(map), HasSubstr(error));
  }
}

}  // namespace
}  // namespace sim::recording
