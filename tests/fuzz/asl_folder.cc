// One file of an ASL folder; the first byte of an input selects it.
#include "sim/recording/asl_folder.h"

#include <array>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "tests/fuzz/fuzz_input.h"

namespace {

using File = std::pair<const char*, const char*>;
constexpr const char* kPose =
    "T_BS:\n  cols: 4\n  rows: 4\n  data: [0, -1, 0, 0.1, 1, 0, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1]\n";
constexpr std::array kFiles{
    File{"cam0/sensor.yaml",
         "rate_hz: 20\nresolution: [48, 36]\nintrinsics: [30, 30, 23, 17]\ndistortion_model: radtan\n"
         "distortion_coefficients: [0, 0, 0, 0]\n"},
    File{"imu0/sensor.yaml", "rate_hz: 20\ngyroscope_noise_density: 1e-4\n"},
    File{"gt/sensor.yaml", ""},
    File{"cam0/data.csv", "#timestamp [ns],filename\n50000000,a.png\n100000000,a.png\n"},
    File{"imu0/data.csv", "#t,wx,wy,wz,ax,ay,az\n45000000,1,2,3,4,5,6\n95000000,1,2,3,4,5,6\n"},
    File{"gt/data.csv", "#t,px,py,pz,qw,qx,qy,qz\n40000000,1,2,3,1,0,0,0\n110000000,1,2,3,1,0,0,0\n"}};

void restore(const File& file) {
  const std::string name = file.first, pose = name.ends_with("sensor.yaml") ? kPose : "";
  fuzz::file("mav0/" + name, pose + file.second);
}

bool make_folder() {
  for (const File& file : kFiles) restore(file);
  std::vector<unsigned char> png;
  cv::imencode(".png", cv::Mat(36, 48, CV_8UC1, cv::Scalar(7)), png);
  fuzz::file("mav0/cam0/data/a.png", fuzz::text_of(png.data(), png.size()));
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const bool made = make_folder();
  if (!made || size == 0) return 0;
  const File& changed = kFiles[data[0] % kFiles.size()];
  fuzz::file(std::string("mav0/") + changed.first, fuzz::text_of(data + 1, size - 1));
  fuzz::read_or_reject([] {
    sim::recording::AslFolder reader(fuzz::folder());
    std::vector<slam::Stamp> times;
    while (const auto observation = reader.next()) times.push_back(observation->t);
    sim::recording::read_asl_truth(fuzz::folder(), reader.sensors(), times);
  });
  restore(changed);
  return 0;
}
