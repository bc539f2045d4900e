// Frames and readings as received by the page.
#include "sim/view/messages.h"

#include <nlohmann/json.hpp>

#include "sim/recording/image_file.h"

namespace sim::view {
namespace {

using nlohmann::json;

slam::Search search(double variance_u, double variance_v) {
  slam::Search s{.landmark = 5, .pixel = {100, 50}};
  s.S << variance_u, 0, 0, variance_v;
  return s;
}

TEST(FrameJson, AnEmptyFrameHasOnlyItsTime) {
  EXPECT_EQ(to_json(Frame{.t = std::chrono::milliseconds(1234)}).dump(), R"({"t":1.234})");
}

TEST(FrameJson, SearchesAreThreeSigmaEllipsesMarkedFoundMissedOrRejected) {
  Frame frame;
  slam::Search found = search(4, 9), rejected = found, missed = found;
  found.used = true;
  found.match = rejected.match = Eigen::Vector2d(101, 51);
  frame.report.emplace().searched = {found, missed, rejected};
  const auto searches = to_json(frame)["searches"];
  const double along_v = searches[0][5];
  EXPECT_NEAR(std::abs(along_v), 1.5708, 1e-9);
  EXPECT_EQ(searches, nlohmann::ordered_json({{5, 100, 50, 9, 6, along_v, "found", 101, 51},  // 3 sqrt(9)
                                              {5, 100, 50, 9, 6, along_v, "missed"},
                                              {5, 100, 50, 9, 6, along_v, "rejected", 101, 51}}));
}

TEST(FrameJson, WhatIsNotFiniteIsNullAndTheStateIsASentenceOfData) {
  Frame frame;
  frame.zmp = Eigen::Vector2d(NAN, INFINITY);
  frame.report.emplace().refused.add("</script><b>\"&\xff");
  const json read = json::parse(to_message(frame).substr(4));
  EXPECT_EQ(read["zmp"], json({nullptr, nullptr}));
  EXPECT_EQ(read["state"].get<std::string>().substr(0, 58),
            "tracking, no landmark searched for; rejected: </script><b>");
  slam::FrameReport& report = frame.report.emplace();
  report.searched = {search(1, 1)};
  EXPECT_EQ(to_json(frame)["state"], "tracking");
  report.health = slam::Health::lost;
  report.cause = "almost no landmarks were found";
  report.suspect = "inconsistent: gyro, x";
  EXPECT_EQ(to_json(frame)["state"], "lost: almost no landmarks were found; inconsistent: gyro, x");
}

slam::RigReading image_of(const cv::Mat& image) {
  slam::RigReading reading;
  reading.image = image;
  return reading;
}

TEST(SentReading, CameraImagesAreUnchangedAndDepthHasItsValuesAndABlueToRedPalette) {
  using rig::Kind;
  const cv::Mat gray(2, 3, CV_8UC1, cv::Scalar(7)), color(2, 3, CV_8UC3, cv::Scalar(200, 100, 0));
  const auto same = [](const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF) == 0; };
  EXPECT_TRUE(same(*recording::decode_png(sent(image_of(gray), {"", Kind::gray}), CV_8UC1), gray));
  EXPECT_TRUE(same(*recording::decode_png(sent(image_of(color), {"", Kind::color}), CV_8UC3), color));
  const std::string bytes = sent(image_of(cv::Mat(2, 3, CV_16UC1, cv::Scalar(3700))), {"", Kind::depth});
  ASSERT_EQ(bytes.size(), 8u + 12u);
  EXPECT_EQ(reinterpret_cast<const std::uint32_t*>(bytes.data())[0], 3u) << "its width";
  EXPECT_EQ(reinterpret_cast<const std::uint16_t*>(bytes.data())[9], 3700) << "mm of the last pixel";
  const cv::Vec3b near = palette()(0, 36), far = palette()(0, 233);  // red, green, blue
  EXPECT_GT(near[2], near[0] + 50);
  EXPECT_GT(far[0], far[2] + 50);
}

TEST(SentReading, LidarPointsAreInTheHeadCamerasFrameAndAnImuHasNone) {
  rig::RigSensor lidar{"", rig::Kind::lidar};
  slam::RigReading sweep;
  sweep.points = {{3, 2, 1, 0.5F}, {1, 0, 0}};
  lidar.X_CS = rig::camera_from_forward_left_up();
  lidar.X_CS.pretranslate(Eigen::Vector3d(0, -0.1, 0));
  const std::string bytes = sent(sweep, lidar);
  ASSERT_EQ(bytes.size(), 32u);
  const auto points = reinterpret_cast<const float*>(bytes.data());
  EXPECT_TRUE(Eigen::Map<const Eigen::Vector3f>(points).isApprox(Eigen::Vector3f(-2, -1.1, 3), 1e-6));
  EXPECT_EQ(points[3], 0.5F) << "its intensity";
  EXPECT_TRUE(Eigen::Map<const Eigen::Vector3f>(points + 4).isApprox(Eigen::Vector3f(0, -0.1, 1), 1e-6));
  EXPECT_EQ(sent({}, {"", rig::Kind::imu}), "");
}

TEST(FrameMessage, JsonAndImageAreInOneMessage) {
  cv::Mat whole(4, 6, CV_8UC1);
  for (int i = 0; i < 24; ++i) whole.data[i] = static_cast<unsigned char>(i);
  const Frame frame{.t = slam::Stamp(0), .image = whole.colRange(1, 4)};  // not continuous
  const std::string message = to_message(frame);
  const auto length = static_cast<unsigned char>(message[0]) + 256u * static_cast<unsigned char>(message[1]);
  EXPECT_EQ(json::parse(message.substr(4, length))["image"], json({3, 4}));
  EXPECT_EQ(message.substr(4 + length), std::string("\1\2\3\7\x8\x9\xd\xe\xf\x13\x14\x15", 12));
}

}  // namespace
}  // namespace sim::view
