#include "sim/view/frame.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/view/model.h"

namespace sim::view {
namespace {

using nlohmann::json;

slam::Search search(double variance_u, double variance_v) {
  slam::Search s{.landmark = 5, .pixel = {100, 50}};
  s.S << variance_u, 0, 0, variance_v;
  return s;
}

TEST(FrameJson, AFrameThatKnowsNothingHasItsTimeAlone) {
  const json read = json::parse(to_json(Frame{.t = std::chrono::milliseconds(1234)}));
  EXPECT_EQ(read, json({{"t", 1.234}}));
}

TEST(FrameJson, ErrorsAreEstimateMinusTruth) {
  Frame frame;
  frame.truth = frame.estimate = Eigen::Isometry3d::Identity();
  frame.estimate->translation() = Eigen::Vector3d(0.01, -0.02, 0.03);
  frame.estimate->rotate(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ()));
  frame.covariance = files::Matrix6d::Identity() * 1e-4;
  const json read = json::parse(to_json(frame));
  EXPECT_EQ(read["error"], json({0.01, -0.02, 0.03, 0.1}));
  EXPECT_EQ(read["sigma"], json({0.01, 0.01, 0.01, 0.01}));
  EXPECT_NEAR(read["nees"], 14, 1e-9);  // (1 + 4 + 9) sigmas squared
}

TEST(FrameJson, EllipsesAreOfThreeSigmasAlongTheirLongerAxis) {
  Frame frame;
  frame.report.emplace().searched = {search(4, 9)};
  const json ellipse = json::parse(to_json(frame))["searches"][0];
  EXPECT_EQ(ellipse[3], 9.0);  // 3 sqrt(9)
  EXPECT_EQ(ellipse[4], 6.0);
  EXPECT_NEAR(std::abs(ellipse[5].get<double>()), 1.571, 1e-9);  // along v
}

TEST(FrameJson, SearchesAreFoundMissedOrRefused) {
  Frame frame;
  slam::Search found = search(1, 1), refused = found, missed = found;
  found.used = true;
  found.match = refused.match = Eigen::Vector2d(101, 51);
  frame.report.emplace().searched = {found, missed, refused};
  const json searches = json::parse(to_json(frame))["searches"];
  EXPECT_EQ(searches[0][6], "found");
  EXPECT_EQ(searches[1][6], "missed");
  EXPECT_EQ(searches[2][6], "refused");
  EXPECT_EQ(searches[0].size(), 9u);
  EXPECT_EQ(searches[1].size(), 7u);
}

TEST(FrameJson, WhatIsNotFiniteIsNullAndTextIsData) {
  Frame frame;
  frame.zmp = Eigen::Vector2d(NAN, INFINITY);
  frame.report.emplace().refused = "</script><b>\"&\xff";
  const json read = json::parse(to_json(frame));
  EXPECT_EQ(read["zmp"], json({nullptr, nullptr}));
  EXPECT_EQ(read["state"].get<std::string>().substr(0, 57),
            "tracking, no landmark searched for; refused: </script><b>");
}

TEST(FrameJson, TheStateIsASentence) {
  slam::FrameReport report;
  report.searched = {search(1, 1)};
  EXPECT_EQ(state_in_words(report), "tracking");
  report.health = slam::Health::lost;
  report.cause = "almost no landmark found";
  report.suspect = "inconsistent: gyro, x";
  EXPECT_EQ(state_in_words(report), "lost: almost no landmark found; inconsistent: gyro, x");
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

// A force of 100 N at (0.02, 0.01) of a sole that is turned by a right angle and stands at (1, 2).
TEST(ZeroMomentPoint, IsWhereTheForceActs) {
  const SoleForce sole{{1, 2, M_PI / 2}, {0, 0, 100}, {1, -2, 0}}, other{{5, 5, 0}, {0, 0, 0}, {0, 0, 0}};
  const auto p = zero_moment_point({sole, other});
  ASSERT_TRUE(p.has_value());
  EXPECT_NEAR(p->x(), 1 - 0.01, 1e-12);
  EXPECT_NEAR(p->y(), 2 + 0.02, 1e-12);
}

TEST(ZeroMomentPoint, OfTwoSolesIsBetweenThemByTheirLoads) {
  const auto p = zero_moment_point(
      {SoleForce{{0, 0, 0}, {0, 0, 100}, {0, 0, 0}}, SoleForce{{0, 1, 0}, {0, 0, 300}, {0, 0, 0}}});
  EXPECT_NEAR(p->y(), 0.75, 1e-12);
  EXPECT_FALSE(zero_moment_point(
                   {SoleForce{{0, 0, 0}, {0, 0, 10}, {0, 0, 0}}, SoleForce{{0, 0, 0}, {0, 0, 5}, {0, 0, 0}}})
                   .has_value());
}

TEST(ModelBytes, NumbersAreAlignedBehindTheirList) {
  Model model;
  model.pieces.push_back({-1, 0, {0, 1, 2}, {0, 0, 1}, {1, 0, 0}, {0.5f, 0.25f}, {0, 0, 0}});
  const std::string bytes = model_bytes(model);
  const auto length = static_cast<std::size_t>(static_cast<unsigned char>(bytes[0]));
  EXPECT_EQ(length % 4, 0u);
  EXPECT_EQ(json::parse(bytes.substr(4, length)),
            json::parse(R"([{"body":-1,"picture":0,"vertices":1,"indices":3}])"));
  EXPECT_EQ(bytes.size(), 4 + length + 4 * (3 + 3 + 3 + 2 + 3));
  float u = 0;
  std::memcpy(&u, bytes.data() + 4 + length + 4 * 9, 4);
  EXPECT_EQ(u, 0.5f);
}

}  // namespace
}  // namespace sim::view
