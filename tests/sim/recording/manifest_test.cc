#include "sim/recording/manifest.h"

#include "sim/recording/image_file.h"
#include "tests/sim/recording/random_readings.h"

namespace sim::recording {
namespace {

using testing::HasSubstr, tests::encoded, tests::expect_same;

TEST(Manifest, HashIsXxh3Of128Bits) {
  // Values published with the algorithm (empty input, seed 0), and printed by `printf gaitslam | xxh128sum`.
  EXPECT_EQ(files::Hash().hex(), "99aa06d3014798d86001c324468d497f");
  files::Hash whole, pieces;
  whole.add("gaitslam");
  for (const char* piece : {"ga", "", "it", "slam"}) pieces.add(piece);
  EXPECT_EQ(pieces.hex(), whole.hex());
  EXPECT_EQ(pieces.bytes(), 8u);
}

TEST(Manifest, FilesOutsideTheFolderAreRejected) {
  const files::TemporaryFolder folder;
  const std::filesystem::path recording = folder / "recording";
  std::filesystem::create_directories(recording);
  files::write_text(folder / "outside.txt", "content");
  std::filesystem::create_symlink(folder / "outside.txt", recording / "link.txt");
  files::Hash hash;
  hash.add("content");
  for (const std::string& path :
       {std::string("../outside.txt"), (folder / "outside.txt").string(), std::string("link.txt")}) {
    ManifestWriter writer(recording);
    writer.add(path, hash);
    writer.finish();
    EXPECT_THAT(files::error_of([&] { Manifest manifest(recording); }), HasSubstr("leads outside the folder"))
        << path;
  }
}

TEST(HashedFile, AFullDiskIsAnError) {
  files::HashedFile full("/dev/full");
  EXPECT_THAT(files::error_of([&] {
                full.write("x");
                full.close();
              }),
              HasSubstr("/dev/full: cannot be written: No space left on device"));
}

const cv::Mat kGray(35, 48, CV_8UC1, cv::Scalar(99));

// OpenCV rotates images according to the orientation in their metadata, which does not belong to calibration
// and IMU.
TEST(DecodeImage, PixelsAreReadAsStoredWhateverTheirOrientation) {
  const std::string exif(
      "\xff\xe1\0\x22"
      "Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0",
      36);
  cv::Mat image = kGray.clone();
  image(cv::Rect(0, 0, 16, 16)) = 220;
  const std::string bytes = encoded(".jpg", image).insert(2, exif);
  const cv::Mat turned =
      cv::imdecode(std::vector<unsigned char>(bytes.begin(), bytes.end()), cv::IMREAD_GRAYSCALE);
  EXPECT_EQ(turned.size(), cv::Size(35, 48)) << "the orientation is there";
  EXPECT_LT(cv::norm(decode_image("a", bytes, {48, 35}), image, cv::NORM_INF), 10);
}

TEST(DecodeImage, BytesThatAreNoImageAreRejected) {
  for (const std::string& bytes :
       {std::string("no image"), encoded(".png", kGray).substr(0, 60), encoded(".jpg", kGray).substr(0, 20),
        encoded(".bmp", kGray), encoded(".pgm", kGray)})
    EXPECT_THROW(decode_image("a", bytes, {48, 35}), files::FileError);
}

cv::Mat decoded_by_opencv(const std::string& png) {
  const cv::Mat bytes(1, static_cast<int>(png.size()), CV_8UC1, const_cast<char*>(png.data()));
  cv::Mat image = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  if (image.channels() == 3) cv::mixChannels({image.clone()}, {image}, {0, 2, 1, 1, 2, 0});  // it is BGR
  return image;
}

TEST(Png, ImagesAndPartsOfThemAreReadBackHereAndByOpenCv) {
  sensor_errors::Random random(1, "picture");
  for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1})
    for (const cv::Size size : {cv::Size(320, 240), cv::Size(1, 1), cv::Size(7, 300), cv::Size(641, 3)}) {
      const cv::Mat whole = tests::random_image(size, random, type);
      for (const cv::Mat& image : {whole, whole(cv::Rect(size.width / 2, 0, 1, size.height))}) {
        const std::string png = encode_png(image);
        expect_same(decode_png(png, type).value(), image);
        EXPECT_FALSE(decode_png(png, type == CV_8UC1 ? CV_8UC3 : CV_8UC1));
        expect_same(decoded_by_opencv(png), image);
      }
    }
}

TEST(GrayPng, RefusesOtherPicturesAndDamagedOnes) {
  sensor_errors::Random random(1, "picture");
  const cv::Mat image = tests::random_image({32, 20}, random);
  for (const cv::Mat& other :
       {image, cv::Mat(4, 4, CV_16UC1, cv::Scalar(7)), cv::Mat(4, 4, CV_8UC3, cv::Scalar(7))})
    if (const auto decoded = decode_png(encoded(".png", other), CV_8UC1)) expect_same(*decoded, other);
  const std::string whole = encode_png(image);
  for (std::size_t n = 0; n < whole.size(); n += 7)
    EXPECT_FALSE(decode_png(whole.substr(0, n), CV_8UC1)) << n;
  for (std::size_t at = 0; at < whole.size(); at += 5) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
    if (const auto decoded = decode_png(damaged, CV_8UC1)) expect_same(*decoded, image);
  }
}

}  // namespace
}  // namespace sim::recording
