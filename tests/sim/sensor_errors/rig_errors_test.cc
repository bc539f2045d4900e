#include <gtest/gtest.h>

#include "sim/sensor_errors/sensor_errors.h"

namespace sim::sensor_errors {
namespace {

using rig::Kind;
using slam::Stamp;

rig::RigSensor sensor(const std::string& name, Kind kind) {
  rig::RigSensor s;
  s.name = name, s.kind = kind;
  s.camera = {320, 240, 200, 200, 159.5, 119.5, {}};
  s.nearest_m = 0.3, s.furthest_m = 10, s.baseline_m = 0.05;
  return s;
}

slam::RigReading reading(const cv::Mat& image = {}) {
  slam::RigReading r;
  r.t = Stamp(20'000'000), r.begin = Stamp(15'000'000);
  r.image = image;
  return r;
}

slam::RigReading applied(const rig::RigSensor& sensor, const slam::RigReading& ideal,
                         std::uint64_t seed = 1) {
  std::vector<slam::RigReading> readings{ideal};
  RigErrors({sensor}, seed).apply(readings);
  return readings.at(0);
}

cv::Mat1w depth(double z_m) {
  return cv::Mat1w(240, 320, static_cast<unsigned short>(std::lround(1e3 * z_m)));
}

// Nothing but the shift of the stamps.
TEST(RigErrors, NoneLeaveTheReadingsAsTheyAreButForTheirClock) {
  for (const Kind kind : {Kind::grey, Kind::color, Kind::depth, Kind::lidar, Kind::imu}) {
    rig::RigSensor ideal = sensor("a", kind);
    ideal.time_offset_s = -0.004;
    const int types[]{CV_8UC1, CV_8UC3, CV_16UC1};
    slam::RigReading given = reading();
    if (rig::is_camera(ideal)) given.image = cv::Mat(240, 320, types[int(kind)], cv::Scalar(700, 90, 80));
    given.points = {{1, 2, 3, 0.5f, 7}};
    given.gyro = {1, 2, 3}, given.accelerometer = {4, 5, 6};
    const slam::RigReading found = applied(ideal, given);
    EXPECT_EQ(found.t, given.t - Stamp(4'000'000));
    EXPECT_EQ(found.begin, given.begin - Stamp(kind == Kind::imu ? 4'000'000 : 0));
    EXPECT_EQ(found.gyro, given.gyro);
    EXPECT_EQ(found.accelerometer, given.accelerometer);
    EXPECT_NEAR(found.points[0].z_m, 3, 1e-6);
    EXPECT_EQ(found.points[0].offset_ns, 7);
    if (rig::is_camera(ideal)) {
      EXPECT_EQ(cv::norm(found.image, given.image, cv::NORM_INF), 0);
    }
  }
}

TEST(RigErrors, EachChannelOfAnImageHasNoiseOfItsOwnAndTheGivenPixelsStay) {
  rig::RigSensor color = sensor("rgb0", Kind::color);
  color.read_sigma_grey = 3, color.shot_sigma_grey = 4;
  const cv::Mat ideal(240, 320, CV_8UC3, cv::Scalar(30, 128, 200));
  const cv::Mat found = applied(color, reading(ideal)).image;
  ASSERT_EQ(found.type(), CV_8UC3);
  EXPECT_EQ(ideal.at<cv::Vec3b>(17, 5), cv::Vec3b(30, 128, 200));
  std::vector<cv::Mat1d> noise(3);
  for (int channel = 0; channel < 3; ++channel) {
    cv::Mat one;
    cv::extractChannel(found, one, channel);
    const double light = std::array{30, 128, 200}[std::size_t(channel)];
    one.convertTo(noise[std::size_t(channel)], CV_64F, 1, -light);
    const double expected = std::sqrt(9 + 16 * light / 255 + 1.0 / 12);
    EXPECT_NEAR(cv::norm(noise[std::size_t(channel)]) / std::sqrt(76800.0) / expected, 1, 0.013);  // 5 sigma
  }
  for (const auto& [a, b] : {std::pair(0, 1), {1, 2}, {2, 0}})
    EXPECT_NEAR(noise[std::size_t(a)].dot(noise[std::size_t(b)]) / 76800 / 20, 0, 5 / std::sqrt(76800.0));
}

TEST(RigErrors, DepthHasNoiseThatGrowsWithItsSquareInWholeMillimeters) {
  rig::RigSensor camera = sensor("depth0", Kind::depth);
  camera.disparity_sigma_px = 0.1;
  for (const double z_m : {1.0, 4.0}) {
    const cv::Mat1w ideal = depth(z_m);
    cv::Scalar mean, sigma;
    cv::meanStdDev(applied(camera, reading(ideal)).image, mean, sigma);
    const double expected = 1e3 * z_m * z_m * 0.1 / (200 * 0.05);
    EXPECT_NEAR(sigma[0] / expected, 1, 0.013);  // five standard errors of 76800 pixels
    EXPECT_NEAR(mean[0], 1e3 * z_m, 5 * expected / std::sqrt(76800.0));
    EXPECT_EQ(cv::countNonZero(ideal != 1e3 * z_m), 0);
  }
}

TEST(RigErrors, DepthOutOfRangeIsNone) {
  const rig::RigSensor camera = sensor("depth0", Kind::depth);
  for (const auto& [z_m, seen] : {std::pair(0.299, false), {0.3, true}, {10, true}, {10.001, false}})
    EXPECT_EQ(cv::countNonZero(applied(camera, reading(depth(z_m))).image), seen ? 76800 : 0) << z_m;
}

TEST(RigErrors, DepthBesideAnOcclusionEdgeIsNone) {
  cv::Mat1w step = depth(3);
  step.colRange(0, 100).setTo(2000);
  for (const int reach : {0, 1, 3}) {
    rig::RigSensor camera = sensor("depth0", Kind::depth);
    camera.edge_px = reach;
    const cv::Mat found = applied(camera, reading(step)).image;
    EXPECT_EQ(cv::countNonZero(found == 0), 2 * reach * 240);
    if (reach > 0) {
      EXPECT_EQ(cv::countNonZero(found.colRange(100 - reach, 100 + reach)), 0);
    }
  }
}

// A floor 1.3 m below a level camera of f = 200 px: at the last row above the horizon a pixel is a meter.
TEST(RigErrors, SlantedSurfacesTheirCreasesAndMissingPixelsAreNoOcclusionEdges) {
  cv::Mat1w room(cv::Size(320, 240), 0);
  for (int row = 0; row < 240; ++row) {
    const double floor_m = row > 120 ? 1.3 * 200 / (row - 119.5) : 60;
    room.row(row).setTo(std::round(1e3 * std::min(floor_m, 12.0)));
  }
  room(cv::Rect(50, 50, 30, 100)).setTo(0);
  EXPECT_EQ(cv::countNonZero(beside_edges(room, 1)), 0);
  room(cv::Rect(200, 100, 20, 100)).setTo(1000);  // a post in front of it
  EXPECT_GT(cv::countNonZero(beside_edges(room, 1)), 2 * 2 * 90);
}

TEST(RigErrors, LidarPointsHaveNoiseOfRangeAndBothAngles) {
  rig::RigSensor lidar = sensor("lidar0", Kind::lidar);
  lidar.range_sigma_m = 0.02, lidar.angle_sigma_rad = 0.003;
  constexpr int n = 20'000;
  slam::RigReading sweep = reading();
  const Eigen::Vector3d p(3, 4, 5);
  for (int i = 0; i < n; ++i) sweep.points.push_back({3, 4, 5, 0.5f, i});
  const auto points = applied(lidar, sweep).points;
  ASSERT_EQ(points.size(), std::size_t(n));
  Eigen::Vector3d square = Eigen::Vector3d::Zero();
  for (const slam::LidarPoint& point : points) {
    const Eigen::Vector3d found(point.x_m, point.y_m, point.z_m);
    square += Eigen::Vector3d(found.norm() - p.norm(), std::atan2(found.y(), found.x()) - std::atan2(4, 3),
                              std::asin(found.z() / found.norm()) - std::asin(p.z() / p.norm()))
                  .cwiseAbs2() /
              n;
  }
  const Eigen::Vector3d sigma = square.cwiseSqrt();
  EXPECT_NEAR(sigma[0] / 0.02, 1, 0.025);  // five standard errors
  EXPECT_NEAR(sigma[1] / 0.003, 1, 0.025);
  EXPECT_NEAR(sigma[2] / 0.003, 1, 0.025);
}

TEST(RigErrors, LidarPointsWhoseMeasuredRangeIsOutOfRangeAreDropped) {
  rig::RigSensor lidar = sensor("lidar0", Kind::lidar);
  lidar.furthest_m = 5;
  slam::RigReading sweep = reading();
  for (int i = 0; i < 10'000; ++i) sweep.points.push_back({5, 0, 0, 0.5f, i});
  sweep.points[0] = {0, 0, 0.2f, 1, 0};
  EXPECT_EQ(applied(lidar, sweep).points.size(), 9'999u);
  lidar.range_sigma_m = 0.02;
  EXPECT_NEAR(double(applied(lidar, sweep).points.size()), 5000, 250);  // half of the noise goes outward
}

TEST(RigErrors, ImuReadingsHaveWhiteNoiseAndOneBiasPerSeed) {
  rig::RigSensor imu = sensor("imu1", Kind::imu);
  imu.rate_hz = 200;
  imu.gyro_sigma_rad_s = 0.01, imu.accelerometer_sigma_m_s2 = 0.2;
  imu.gyro_bias_sigma_rad_s = 0.5, imu.accelerometer_bias_sigma_m_s2 = 3;
  constexpr int n = 10'000;
  double bias_square = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    std::vector<slam::RigReading> readings(n);
    for (int i = 0; i < n; ++i) readings[std::size_t(i)].begin = Stamp(5'000'000ll * i);
    for (int i = 0; i < n; ++i) readings[std::size_t(i)].t = Stamp(5'000'000ll * (i + 1));
    RigErrors({imu}, seed).apply(readings);
    for (const auto& [value, sigma] :
         {std::pair(&slam::RigReading::gyro, 0.01), {&slam::RigReading::accelerometer, 0.2}}) {
      Eigen::Vector3d mean = Eigen::Vector3d::Zero(), square = mean;
      for (const slam::RigReading& r : readings) mean += r.*value / n;
      for (const slam::RigReading& r : readings) square += (r.*value - mean).cwiseAbs2() / n;
      for (const int axis : {0, 1, 2}) EXPECT_NEAR(std::sqrt(square[axis]) / sigma, 1, 0.036);
      bias_square += mean.squaredNorm() / std::pow(sigma == 0.01 ? 0.5 : 3, 2) / 48;
    }
  }
  EXPECT_NEAR(bias_square, 1, 5 * std::sqrt(2.0 / 48));  // 48 draws
}

// Sensors with all errors: gray, color, depth, lidar, IMU.
TEST(RigErrors, AFurtherSensorChangesNoNumberOfAnotherNorDoesTheOrderOfReadings) {
  std::vector<rig::RigSensor> rig;
  for (const auto& [name, kind] : {std::pair("cam1", Kind::grey),
                                   {"rgb0", Kind::color},
                                   {"depth0", Kind::depth},
                                   {"lidar0", Kind::lidar},
                                   {"imu1", Kind::imu}}) {
    rig.push_back(sensor(name, kind));
    rig.back().read_sigma_grey = 5, rig.back().disparity_sigma_px = 0.1, rig.back().range_sigma_m = 0.1;
    rig.back().gyro_sigma_rad_s = 1, rig.back().edge_px = 1;
  }
  std::vector<slam::RigReading> all;
  for (int i = 0; i < 5; ++i) {
    const int types[]{CV_8UC1, CV_8UC3, CV_16UC1};
    slam::RigReading& r = all.emplace_back(reading());
    r.sensor = i;
    if (i < 3) r.image = cv::Mat(24, 32, types[i], cv::Scalar(i < 2 ? 90 : 2000, 90, 90));
    r.points = {{1, 2, 3, 0.5f, 7}};
  }
  std::vector<slam::RigReading> together(all.rbegin(), all.rend());
  RigErrors(rig, 3).apply(together);
  for (int i = 0; i < 5; ++i) {
    slam::RigReading one = all[std::size_t(i)];
    one.sensor = 0;
    const slam::RigReading alone = applied(rig[std::size_t(i)], one, 3),
                           other = applied(rig[std::size_t(i)], one, 4);
    const slam::RigReading& found = together[std::size_t(4 - i)];
    if (i < 3) {
      EXPECT_EQ(cv::norm(found.image, alone.image, cv::NORM_INF), 0);
      EXPECT_GT(cv::norm(found.image, other.image, cv::NORM_INF), 0) << "of another seed";
    }
    EXPECT_EQ(found.points[0].x_m, alone.points[0].x_m);
    EXPECT_EQ(found.gyro, alone.gyro);
    EXPECT_EQ(i == 3, alone.points[0].x_m != other.points[0].x_m);
    EXPECT_EQ(i == 4, alone.gyro != other.gyro);
  }
  rig[0].name = "cam2";
  EXPECT_GT(cv::norm(applied(rig[0], all[0], 3).image, together[4].image, cv::NORM_INF), 0)
      << "of another name";
}

TEST(SensorErrors, ApplyThoseOfTheRigAndChangeNothingElse) {
  rig::RigSensor camera = sensor("cam1", Kind::grey);
  camera.read_sigma_grey = 5;
  slam::Observation plain;
  plain.t = Stamp(20'000'000);
  plain.image = cv::Mat(240, 320, CV_8UC1, cv::Scalar(128));
  slam::Observation with_rig = plain;
  with_rig.rig = {reading(plain.image)};
  const auto a = SensorErrors({}, 1).process(plain), b = SensorErrors({}, 1, {camera}).process(with_rig);
  EXPECT_EQ(cv::norm(a.at(0).image, b.at(0).image, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(b.at(0).rig.at(0).image, plain.image, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(b.at(0).rig.at(0).image, b.at(0).image, cv::NORM_INF), 0);
  EXPECT_EQ(cv::countNonZero(plain.image != 128), 0);
}

}  // namespace
}  // namespace sim::sensor_errors
