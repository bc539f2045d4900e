#include "sim/recording/grey_png.h"

#include <gtest/gtest.h>
#include <libdeflate.h>

#include <opencv2/imgcodecs.hpp>

#include "sim/sensor_errors/random.h"

namespace sim::recording {
namespace {

std::string png_of(const cv::Mat& image, const std::vector<int>& how = {cv::IMWRITE_PNG_COMPRESSION, 1}) {
  std::vector<unsigned char> bytes;
  cv::imencode(".png", image, bytes, how);
  return {bytes.begin(), bytes.end()};
}

// Five bands for five PNG filters: noise, horizontal, vertical and diagonal slopes, plain grey.
cv::Mat picture(int width, int height) {
  sensor_errors::Random random(1, "picture");
  cv::Mat image(height, width, CV_8UC1);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      const int noise = static_cast<int>(256 * random.uniform()), band = 5 * v / height;
      image.at<unsigned char>(v, u) = static_cast<unsigned char>(band == 0   ? noise
                                                                 : band == 1 ? 3 * u
                                                                 : band == 2 ? 5 * v + u * u
                                                                 : band == 3 ? u + 2 * v + noise / 64
                                                                             : 7);
    }
  return image;
}

bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::countNonZero(a != b) == 0;
}

TEST(GreyPng, ImagesAreReadBackWhoeverEncodedThem) {
  const std::vector<std::vector<int>> ways{{},
                                           {cv::IMWRITE_PNG_COMPRESSION, 0},
                                           {cv::IMWRITE_PNG_COMPRESSION, 1},
                                           {cv::IMWRITE_PNG_COMPRESSION, 9},
                                           {cv::IMWRITE_PNG_STRATEGY, cv::IMWRITE_PNG_STRATEGY_HUFFMAN_ONLY}};
  for (const cv::Size size : {cv::Size(320, 240), cv::Size(1, 1), cv::Size(7, 300), cv::Size(641, 3)}) {
    const cv::Mat image = picture(size.width, size.height);
    for (const std::vector<int>& how : ways)
      EXPECT_TRUE(same(decode_grey_png(png_of(image, how)).value(), image)) << size;
    const std::string png = encode_grey_png(image);
    const cv::Mat bytes(1, static_cast<int>(png.size()), CV_8UC1, const_cast<char*>(png.data()));
    EXPECT_TRUE(same(cv::imdecode(bytes, cv::IMREAD_UNCHANGED), image)) << size;
    EXPECT_TRUE(same(decode_grey_png(png).value(), image)) << size;
  }
}

TEST(GreyPng, EncodesAPartOfAnImage) {
  const cv::Mat part = picture(64, 48)(cv::Rect(5, 7, 20, 30));
  EXPECT_TRUE(same(decode_grey_png(encode_grey_png(part)).value(), part));
}

// A picture of two rows, stored without compression: the filter of the second row is byte `filter`.
std::string two_rows(char filter, const std::string& second) {
  std::string png =
      png_of((cv::Mat_<unsigned char>(2, 4) << 10, 20, 40, 80, 0, 0, 0, 0), {cv::IMWRITE_PNG_COMPRESSION, 0});
  const std::string rows = std::string("\0\x0a\x14\x28\x50", 5) + filter + second;
  const std::uint32_t adler = libdeflate_adler32(1, rows.data(), rows.size());
  std::string stored = std::string("\x78\x01\x01\x0a\x00\xf5\xff", 7) + rows;
  for (int shift = 24; shift >= 0; shift -= 8) stored += static_cast<char>(adler >> shift);
  const std::string length{0, 0, 0, static_cast<char>(stored.size())};
  const std::string checksum(4, '\0'), header = png.substr(0, 33);
  return header + length + "IDAT" + stored + checksum + std::string(4, '\0') + "IEND" + checksum;
}

TEST(GreyPng, KnowsEachFilterOfTheSpecification) {
  const std::string ones(4, '\1');
  const auto row = [&](char filter) {
    const auto image = decode_grey_png(two_rows(filter, ones));
    return image ? std::vector<int>(image->ptr(1), image->ptr(1) + 4) : std::vector<int>{};
  };
  EXPECT_EQ(row(0), (std::vector{1, 1, 1, 1}));
  EXPECT_EQ(row(1), (std::vector{1, 2, 3, 4}));
  EXPECT_EQ(row(2), (std::vector{11, 21, 41, 81}));
  EXPECT_EQ(row(3), (std::vector{6, 14, 28, 55}));
  EXPECT_EQ(row(4), (std::vector{11, 21, 41, 81}));
  EXPECT_EQ(row(5), std::vector<int>{});
}

TEST(GreyPng, RefusesOtherPicturesAndDamagedOnes) {
  const cv::Mat image = picture(32, 20);
  EXPECT_FALSE(decode_grey_png(""));
  EXPECT_FALSE(decode_grey_png("no picture"));
  EXPECT_FALSE(decode_grey_png(png_of(cv::Mat::zeros(4, 4, CV_16UC1))));
  EXPECT_FALSE(decode_grey_png(png_of(cv::Mat::zeros(4, 4, CV_8UC3))));
  const std::string whole = png_of(image);
  for (std::size_t n = 0; n + 12 < whole.size(); n += 7)
    EXPECT_FALSE(decode_grey_png(whole.substr(0, n))) << n;
  for (std::size_t at = 60; at + 16 < whole.size(); at += 11) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
    const auto decoded = decode_grey_png(damaged);
    EXPECT_FALSE(decoded && !same(*decoded, image)) << at;
  }
}

}  // namespace
}  // namespace sim::recording
