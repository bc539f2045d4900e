#include "sim/recording/image_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "sim/files/text.h"

namespace sim::recording {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

std::string encoded(const std::string& ending, int type = CV_8UC1) {
  std::vector<unsigned char> bytes;
  cv::imencode(ending, cv::Mat(35, 48, type, cv::Scalar::all(99)), bytes);
  return {bytes.begin(), bytes.end()};
}

// A PNG with this size in its header and 48 x 35 pixels.
std::string png_of_size(std::uint32_t width, std::uint32_t height) {
  std::string png = encoded(".png");
  for (int i = 0; i < 4; ++i) {
    png[static_cast<std::size_t>(16 + i)] = static_cast<char>(width >> (24 - 8 * i));
    png[static_cast<std::size_t>(20 + i)] = static_cast<char>(height >> (24 - 8 * i));
  }
  return png;
}

TEST(ImageSize, IsThatOfTheDecodedImage) {
  for (const char* ending : {".png", ".jpg", ".pgm"})
    EXPECT_EQ(image_size(encoded(ending)), (ImageSize{48, 35})) << ending;
  EXPECT_EQ(image_size(encoded(".ppm", CV_8UC3)), (ImageSize{48, 35}));
  EXPECT_EQ(image_size("P5 # a remark 7 8\n 48 # another\n35 255\n"), (ImageSize{48, 35}));
  EXPECT_FALSE(image_size(encoded(".bmp")));
  EXPECT_FALSE(image_size(""));
}

TEST(DecodeImage, KindsThatOtherProgramsWriteAreDecoded) {
  for (const char* ending : {".png", ".jpg", ".pgm"}) {
    const cv::Mat image = decode_image("a", encoded(ending), {48, 35}, cv::IMREAD_GRAYSCALE);
    EXPECT_EQ(image.size(), cv::Size(48, 35)) << ending;
    EXPECT_EQ(image.at<unsigned char>(7, 9), 99) << ending;
  }
}

// The message names the size in the header, before anything is decoded.
TEST(DecodeImage, AnotherSizeIsRejectedByTheHeader) {
  for (const std::uint32_t side : {12000u, 60000u})
    EXPECT_THAT(
        [&] {
          decode_image("big.png", png_of_size(side, side), {320, 240}, cv::IMREAD_GRAYSCALE);
        },
        ThrowsMessage<files::FileError>(HasSubstr("big.png: is an image of " + std::to_string(side) + "x" +
                                                  std::to_string(side) +
                                                  ", the camera's sensor.yaml has 320x240")));
  for (const std::uint32_t width : {0xffffffff, 0u})
    EXPECT_THAT(
        [&] {
          decode_image("a.png", png_of_size(width, 1), {320, 240}, cv::IMREAD_GRAYSCALE);
        },
        ThrowsMessage<files::FileError>(HasSubstr("cannot be read as an image")));
}

TEST(DecodeImage, OtherBytesAreRejected) {
  for (const std::string& bytes : {std::string("no image"), encoded(".png").substr(0, 60),
                                   encoded(".jpg").substr(0, 20), encoded(".bmp")})
    EXPECT_THROW(decode_image("a", bytes, {48, 35}, cv::IMREAD_GRAYSCALE), files::FileError);
}

}  // namespace
}  // namespace sim::recording
