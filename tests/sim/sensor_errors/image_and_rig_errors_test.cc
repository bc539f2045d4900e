// Errors of images and of the additional sensors, and their random numbers.
#include "sim/sensor_errors/random.h"
#include "sim/sensor_errors/sensor_errors.h"

namespace sim::sensor_errors {
namespace {

using rig::Kind, slam::Stamp;

constexpr int kTypes[]{CV_8UC1, CV_8UC3, CV_16UC1};  // types of gray, color and depth images

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

/// A number that depends on everything that errors change.
double sum_of(const slam::RigReading& r) {
  return cv::norm(r.image) + (r.points.empty() ? 0 : r.points[0].x_m) + r.gyro.sum();
}

TEST(RigErrors, NoErrorsLeaveTheReadingsUnchangedExceptForTheirClock) {
  for (const Kind kind : {Kind::gray, Kind::color, Kind::depth, Kind::lidar, Kind::imu}) {
    rig::RigSensor ideal = sensor("a", kind);
    ideal.time_offset_s = -0.004;
    slam::RigReading given = reading();
    if (rig::is_camera(ideal)) given.image = cv::Mat(240, 320, kTypes[int(kind)], cv::Scalar(700, 90, 80));
    given.points = {{1, 2, 3, 0.5f, 7}};
    given.gyro = {1, 2, 3}, given.accelerometer = {4, 5, 6};
    const slam::RigReading found = applied(ideal, given);
    EXPECT_EQ(found.t, given.t - Stamp(4'000'000));
    EXPECT_EQ(found.begin, given.begin - Stamp(kind == Kind::imu ? 4'000'000 : 0));
    EXPECT_EQ(found.accelerometer, given.accelerometer);
    EXPECT_EQ(sum_of(found), sum_of(given));
  }
}

TEST(RigErrors, EachImageChannelHasItsOwnNoiseAndTheInputIsUnchanged) {
  rig::RigSensor color = sensor("rgb0", Kind::color);
  color.read_sigma_gray = 3, color.shot_sigma_gray = 4;
  const cv::Mat ideal(240, 320, CV_8UC3, cv::Scalar(30, 128, 200));
  cv::Mat noise;
  cv::subtract(applied(color, reading(ideal)).image, ideal, noise, {}, CV_64F);
  EXPECT_EQ(ideal.at<cv::Vec3b>(17, 5), cv::Vec3b(30, 128, 200));
  std::vector<cv::Mat1d> channels;
  cv::split(noise, channels);
  const double n = 76800;
  for (int channel = 0; channel < 3; ++channel) {
    const cv::Mat1d &one = channels[channel], &next = channels[(channel + 1) % 3];
    const double expected = std::sqrt(9 + 16 * ideal.data[channel] / 255. + 1.0 / 12);
    EXPECT_NEAR(cv::norm(one) / std::sqrt(n) / expected, 1, 0.013);  // five standard errors
    EXPECT_NEAR(one.dot(next) / n / 20, 0, 5 / std::sqrt(n));
  }
}

// The mean over a window of 7 px has a correlation of 1 - d/7 at a distance of d px. The noise is relative to
// its size at that depth, which grows with the square.
TEST(RigErrors, DepthNoiseIsCorrelatedWithinTheMatchingWindowAndThreeQuartersPersistOverFrames) {
  rig::RigSensor camera = sensor("depth0", Kind::depth);
  camera.disparity_sigma_px = 0.2;
  const auto correlation = [](const cv::Mat1f& a, const cv::Mat1f& b, int right, int down) {
    const cv::Rect left(0, 0, 320 - right, 240 - down);
    return a(left).clone().dot(b(left + cv::Point(right, down)).clone()) / left.area();
  };
  for (const auto& [window, z_m] : {std::pair(1.0, 2.0), {7.0, 5.0}}) {
    camera.window_px = window;
    const auto noise = [&, z_m = z_m](int ms) {
      slam::RigReading given = reading(depth(z_m));
      given.t = std::chrono::milliseconds(ms);
      cv::Mat1f error = applied(camera, given).image;
      return cv::Mat1f((error - 1e3 * z_m) / (1e3 * z_m * z_m * 0.2 / (200 * 0.05)));
    };
    double same = 0, half = 0, beyond = 0, next = 0, later = 0;
    for (int second = 0; second < 10; ++second) {
      const cv::Mat1f now = noise(1000 * second);
      same += correlation(now, now, 0, 0) / 10;
      half += (correlation(now, now, 3, 0) + correlation(now, now, 0, 3)) / 20;
      beyond += (correlation(now, now, 10, 0) + correlation(now, now, 0, 10)) / 20;
      next += correlation(now, noise(1000 * second + 10), 0, 0) / 10;
      later += correlation(now, noise(1000 * second + 500), 0, 0) / 10;
    }
    const double error = 2 * window / std::sqrt(10 * 76800.0);  // five standard errors, conservatively
    EXPECT_NEAR(same, 1, 5 * error) << window;
    EXPECT_NEAR(half, window > 1 ? 0.6 : 0, 0.08) << window;
    EXPECT_NEAR(beyond, 0, 5 * error) << window;
    EXPECT_NEAR(next, 0.75, 0.03) << window;  // 10 ms of 250 ms have passed
    EXPECT_NEAR(later, 0, 5 * error) << window;
  }
}

TEST(RigErrors, DepthOutOfRangeIsMissing) {
  const rig::RigSensor camera = sensor("depth0", Kind::depth);
  for (const auto& [z_m, seen] : {std::pair(0.299, false), {0.3, true}, {10, true}, {10.001, false}})
    EXPECT_EQ(cv::countNonZero(applied(camera, reading(depth(z_m))).image), seen ? 76800 : 0) << z_m;
}

TEST(RigErrors, DepthBesideAnOcclusionEdgeIsMissing) {
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

// A floor 1.3 m below a level camera of f = 200 px: at the last row above the horizon a pixel spans a meter.
TEST(RigErrors, SlantedSurfacesCreasesAndMissingPixelsAreNotOcclusionEdges) {
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

TEST(RigErrors, LidarPointsHaveNoiseInRangeAndBothAngles) {
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
TEST(RigErrors, NeitherAnotherSensorNorTheOrderOfReadingsChangesANumber) {
  std::vector<rig::RigSensor> rig;
  std::vector<slam::RigReading> all;
  for (int i = 0; i < 5; ++i) {
    rig.push_back(sensor(std::string(1, char('a' + i)), static_cast<Kind>(i)));
    rig.back().read_sigma_gray = 5, rig.back().disparity_sigma_px = 0.1, rig.back().range_sigma_m = 0.1;
    rig.back().gyro_sigma_rad_s = 1, rig.back().edge_px = 1;
    slam::RigReading& r = all.emplace_back(reading());
    r.sensor = i;
    if (i < 3) r.image = cv::Mat(24, 32, kTypes[i], cv::Scalar(i < 2 ? 90 : 2000, 90, 90));
    r.points = {{1, 2, 3, 0.5f, 7}};
  }
  std::vector<slam::RigReading> together(all.rbegin(), all.rend());
  RigErrors(rig, 3).apply(together);
  for (std::size_t i = 0; i < 5; ++i) {
    all[i].sensor = 0;
    const double found = sum_of(together[4 - i]);
    EXPECT_EQ(found, sum_of(applied(rig[i], all[i], 3))) << i;
    EXPECT_NE(found, sum_of(applied(rig[i], all[i], 4))) << "of another seed";
    rig[i].name = "other";
    EXPECT_NE(found, sum_of(applied(rig[i], all[i], 3))) << "of another name";
  }
}

TEST(SensorErrors, ApplyRigErrorsAndChangeNothingElse) {
  rig::RigSensor camera = sensor("cam1", Kind::gray);
  camera.read_sigma_gray = 5;
  slam::Observation plain;
  plain.image = cv::Mat(240, 320, CV_8UC1, cv::Scalar(128));
  slam::Observation with_rig = plain;
  with_rig.rig = {reading(plain.image)};
  const slam::Observation expected = SensorErrors({}, 1).process(plain).at(0),
                          found = SensorErrors({}, 1, {camera}).process(with_rig).at(0);
  EXPECT_EQ(cv::norm(found.image, expected.image, cv::NORM_INF), 0);
  for (const cv::Mat& other : {plain.image, found.image})
    EXPECT_GT(cv::norm(found.rig.at(0).image, other, cv::NORM_INF), 0);
}

ImageOptions noise(double read, double shot, double gain = 1) {
  ImageOptions sizes;
  sizes.read_sigma_gray = read, sizes.shot_sigma_gray = shot, sizes.gain = gain;
  return sizes;
}

cv::Mat received(const ImageOptions& sizes, int gray, Stamp t = Stamp(1)) {
  return ImageErrors(sizes, 1, {}).apply(cv::Mat(240, 320, CV_8UC1, cv::Scalar(gray)), t);
}

TEST(ImageErrors, NoiseHasTheRequestedSpreadAtEveryGrayLevelAndGain) {
  for (const auto& [gray, gain] : {std::pair(30, 1.0), {128, 1.0}, {220, 1.0}, {40, 4.0}}) {
    cv::Scalar mean, sigma;
    cv::meanStdDev(received(noise(2, 3, gain), gray), mean, sigma);
    const double expected = std::sqrt(gain * gain * (4 + 9.0 * gray / 255) + 1.0 / 12);  // and rounding
    EXPECT_NEAR(mean[0], gain * gray, 0.018 * expected);  // five standard errors of 76800 pixels
    EXPECT_NEAR(sigma[0] / expected, 1, 0.013);
  }
}

TEST(ImageErrors, NoiseSaturatesInsteadOfWrapping) {
  for (const int gray : {0, 255})  // half of the noise goes outward
    EXPECT_NEAR(cv::countNonZero(received(noise(100, 50), gray) == gray), 240 * 320 / 2, 240 * 320 / 50);
}

TEST(ImageErrors, NeighboringPixelsAndFramesAreUncorrelated) {
  cv::Mat a, b;
  received(noise(10, 0), 128, Stamp(1)).convertTo(a, CV_64F, 1, -128);
  received(noise(10, 0), 128, Stamp(2)).convertTo(b, CV_64F, 1, -128);
  const double bound = 5 * 100 * std::sqrt(240 * 320);
  EXPECT_NEAR(a.dot(b), 0, bound);
  for (int shift = 1; shift <= 6; ++shift)  // five pixels share a draw
    EXPECT_NEAR(a.colRange(0, 320 - shift).clone().dot(a.colRange(shift, 320).clone()), 0, bound) << shift;
}

TEST(Random, NumbersAreTheSameOnEveryMachine) {
  // Computed by a second program (Python's integers, own AS 241); a change here changes every run.
  Random random(1, "gyro noise");
  EXPECT_EQ(random.bits(), 0xc0085b38e9e26c8full);
  EXPECT_EQ(random.uniform(), 0x1.fc926265345dcp-3);
  EXPECT_EQ(random.normal(), -0x1.d49c87681a44dp-1);
}

TEST(Random, ADifferentSeedNameOrItemGivesDifferentNumbers) {
  std::set<std::uint64_t> first;
  for (const std::uint64_t seed : {0ull, 1ull, 2ull, ~0ull})
    for (const char* name : {"", "gyro noise", "image noise"}) {
      first.insert(Random(seed, name).bits());
      for (const std::uint64_t item : {0ull, 1ull, ~0ull}) first.insert(Random(seed, name, item).bits());
    }
  EXPECT_EQ(first.size(), 4u * 3u * 4u);
}

TEST(Random, NumbersHaveTheMomentsOfTheirDistributionsAndNoCorrelation) {
  Random random(3, "test");
  // Mean and variance of u, u², z, z², z³, z⁴, and of products of successive numbers and of those of two
  // items.
  const std::array mean{0.5, 1. / 3, 0., 1., 0., 3., 0., 0.},
      variance{1. / 12, 4. / 45, 1., 2., 15., 96., 1., 1.};
  std::array<double, 8> found{};
  double last = 0;
  constexpr int n = 200000;
  for (int i = 0; i < n; ++i) {
    const double u = random.uniform(), z = random.normal();
    ASSERT_TRUE(u >= 0 && u < 1);
    const auto item = std::uint64_t(i);
    const double items = Random(5, "test", item).normal() * Random(5, "test", item + 1).normal();
    const std::array numbers{u, u * u, z, z * z, z * z * z, z * z * z * z, z * std::exchange(last, z), items};
    for (std::size_t k = 0; k < numbers.size(); ++k) found[k] += numbers[k] / n;
  }
  for (std::size_t k = 0; k < found.size(); ++k)
    EXPECT_NEAR(found[k], mean[k], 5 * std::sqrt(variance[k] / n)) << k;
}

TEST(Random, QuantileInvertsTheDistributionFunction) {
  // The C library's erfc is the independent reference: Phi(z) = erfc(−z/√2) / 2.
  for (const double p : {1e-300, 1e-100, 1e-20, 1e-11, 1e-5, 0.01, 0.0749, 0.0751, 0.3, 0.4999, 0.5}) {
    const double z = normal_quantile(p);
    // 1e-13 relative: the condition of Phi, about z², times a few roundings at |z| = 37 loses three digits.
    EXPECT_NEAR(std::erfc(-z / std::sqrt(2.0)) / 2 / p, 1, p < 1e-50 ? 1e-11 : 1e-13) << p;
  }
  EXPECT_EQ(normal_quantile(0.5), 0);
  EXPECT_EQ(normal_quantile(0.25), -normal_quantile(0.75));
  EXPECT_NEAR(normal_quantile(0.975), 1.959963984540054, 1e-15);
}

}  // namespace
}  // namespace sim::sensor_errors
