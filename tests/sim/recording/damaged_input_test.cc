// Readers of external files return a value or throw a FileError, whatever the file contains.
#include <gtest/gtest.h>
#include <libdeflate.h>

#include <functional>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "sim/files/text.h"
#include "sim/files/trajectory_file.h"
#include "sim/recording/asl_folder.h"
#include "sim/recording/recording.h"
#include "tests/sim/files/damage.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::recording {
namespace {

namespace fs = std::filesystem;
using slam::Stamp;

constexpr int kTrials = 150;  // of each file

void replace(const fs::path& file, const std::string& bytes) {
  fs::create_directories(file.parent_path());
  files::write_text(file, bytes);
}

/// Reads `file` with random damage many times, then intact; some of the damage must be noticed.
void read_damaged(const fs::path& file, const std::function<void()>& read) {
  const std::string whole = files::read_text(file);
  sensor_errors::Random random(1, file.filename().string());
  int rejected = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const std::string bytes = tests::damaged(whole, random);
    replace(file, bytes);
    try {
      read();
    } catch (const files::FileError& error) {
      EXPECT_NE(std::string(error.what()), "");
      ++rejected;
    } catch (const std::exception& error) {
      ADD_FAILURE() << file << ", trial " << trial << ": " << error.what() << "\n" << bytes.substr(0, 2000);
      break;
    }
  }
  replace(file, whole);
  EXPECT_GT(rejected, kTrials / 20) << file;
  EXPECT_NO_THROW(read()) << file;
}

std::string png() {
  cv::Mat grey(36, 48, CV_8UC1);
  for (int i = 0; i < 36 * 48; ++i) grey.data[i] = static_cast<unsigned char>(37 * i);
  std::vector<unsigned char> bytes;
  cv::imencode(".png", grey, bytes);
  return {bytes.begin(), bytes.end()};
}

constexpr const char* kMounting = R"(T_BS:
  cols: 4
  rows: 4
  data: [0.0, -1.0, 0.0, 0.1, 1.0, 0.0, 0.0, 0.2, 0.0, 0.0, 1.0, 0.3, 0.0, 0.0, 0.0, 1.0]
)";

// An external recording: a camera at 20 Hz, an IMU at 200 Hz, truth and a plan.
class DamagedFolder {
 public:
  explicit DamagedFolder(const fs::path& folder) : folder_(folder) {
    const fs::path mav0 = folder / "mav0";
    replace(mav0 / "cam0/sensor.yaml", "sensor_type: camera\n" + std::string(kMounting) +
                                           "rate_hz: 20\nresolution: [48, 36]\ncamera_model: pinhole\n"
                                           "intrinsics: [30.1, 30.2, 23.5, 17.5]\n"
                                           "distortion_model: radial-tangential\n"
                                           "distortion_coefficients: [-0.28, 0.07, 0.0002, 1.7e-05]\n");
    replace(mav0 / "imu0/sensor.yaml", "sensor_type: imu\n" + std::string(kMounting) +
                                           "rate_hz: 200\ngyroscope_noise_density: 1.6968e-04\n");
    replace(mav0 / "state_groundtruth_estimate0/sensor.yaml", kMounting);
    std::string frames = "#timestamp [ns],filename\n", imu = "#timestamp [ns],wx,wy,wz,ax,ay,az\n",
                truth = "#timestamp,px,py,pz,qw,qx,qy,qz\n";
    for (int k = 0; k < 4; ++k) {
      const std::string t = std::to_string(kStart + 50'000'000 * k);
      frames += t + "," + t + ".png\n";
      truth += t + ",1,2,3,1,0,0,0\n";
      replace(mav0 / "cam0/data" / (t + ".png"), png());
    }
    for (int k = 0; k < 35; ++k) imu += std::to_string(kStart + 5'000'000 * k) + ",0.1,0.2,0.3,9.8,0.1,0.2\n";
    replace(mav0 / "cam0/data.csv", frames);
    replace(mav0 / "imu0/data.csv", imu);
    replace(mav0 / "state_groundtruth_estimate0/data.csv", truth);
  }

  void read() const {
    AslFolder reader(folder_);
    std::vector<Stamp> times;
    while (const auto observation = reader.next()) times.push_back(observation->t);
    read_asl_truth(folder_, reader.sensors(), times);
  }

 private:
  static constexpr std::int64_t kStart = 1403636579763555584;
  fs::path folder_;
};

TEST(DamagedInput, AFolderDamagedFolderIsReadOrRejected) {
  const files::TemporaryFolder folder;
  const DamagedFolder recorded(folder.path());
  for (const char* file : {"cam0/sensor.yaml", "cam0/data.csv", "imu0/sensor.yaml", "imu0/data.csv",
                           "state_groundtruth_estimate0/sensor.yaml", "state_groundtruth_estimate0/data.csv",
                           "cam0/data/1403636579863555584.png"})
    read_damaged(folder / "mav0" / file, [&] { recorded.read(); });
}

// CRC-32 of PNG: four bytes, the highest first.
std::string crc(const std::string& bytes) {
  const std::uint32_t c = libdeflate_crc32(0, bytes.data(), bytes.size());
  return {static_cast<char>(c >> 24), static_cast<char>(c >> 16), static_cast<char>(c >> 8),
          static_cast<char>(c)};
}

// 900 000 x 900 000 px and 0 x 0 px, with the right checksum.
TEST(DamagedInput, AnImageOfAnImpossibleSizeIsRejected) {
  using namespace std::string_literals;
  const files::TemporaryFolder folder;
  const DamagedFolder recorded(folder.path());
  const fs::path file = folder / "mav0/cam0/data/1403636579863555584.png";
  for (const std::string& side : {"\x00\x0d\xbb\xa0"s, "\x00\x00\x00\x00"s}) {
    std::string bytes = png();
    bytes.replace(16, 8, side + side);
    bytes.replace(29, 4, crc(bytes.substr(12, 17)));
    replace(file, bytes);
    EXPECT_THROW(recorded.read(), files::FileError);
  }
}

TEST(DamagedInput, ATrajectoryIsReadOrRejected) {
  const files::TemporaryFolder folder;
  std::string tum = "# t x y z\n", euroc = "#timestamp,x,y,z,qw,qx,qy,qz\n", kitti;
  for (int k = 0; k < 20; ++k) {
    tum += std::to_string(0.1 * k) + " 1.5 2 3 0 0 0 1\n";
    euroc += std::to_string(1403636579763555584 + 50'000'000ll * k) + ",1.5,2,3,1,0,0,0\n";
    kitti += "1 0 0 " + std::to_string(k) + " 0 1 0 0.5 0 0 1 0\n";
  }
  for (const auto& [name, text] :
       std::map<std::string, std::string>{{"a.tum", tum}, {"data.csv", euroc}, {"00.txt", kitti}}) {
    const std::filesystem::path file = folder / name;
    replace(file, text);
    read_damaged(file, [&] { files::read_trajectory(file); });
  }
  read_damaged(folder / "a.tum", [&] { files::read_tum(folder / "a.tum"); });
}

}  // namespace
}  // namespace sim::recording
