// One file of a recording, listed in its manifest; the first byte of an input selects the file. Only files
// that are parsed can be selected.
#include "sim/recording/recording.h"

#include <map>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "sim/files/csv.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording_format.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

namespace recording = sim::recording;

std::filesystem::path root() { return fuzz::folder() / "recording"; }

void record() {
  recording::RecordingSetup setup;
  setup.calibration.camera = {48, 36, 30, 30, 24, 18, slam::OneParameterRadial{1e-4}};
  setup.joints = {"KNEE"};
  recording::RecordingWriter writer(root(), setup);
  slam::Observation o;
  o.image = cv::Mat(36, 48, CV_8UC1, cv::Scalar(7));
  o.gyro = {{slam::Stamp{-5'000'000}, slam::Stamp{0}, {1, 2, 3}}};
  o.accelerometer = o.gyro;
  o.plan.emplace();
  writer.add(o);
  writer.add(recording::TruePoses{});
  writer.add(recording::TrueFeet{});
  writer.add(std::vector{sim::score::StepCorrection{}});
  writer.add(sim::score::Surface{});
  writer.finish();
}

// Relative path -> content of every listed file.
std::map<std::string, std::string> contents() {
  record();
  std::map<std::string, std::string> all;
  sim::files::CsvReader rows(root() / "manifest.csv", {"#xxh3_128,bytes,path"});
  while (rows.next()) all[std::string(rows.text(2))] = sim::files::read_text(root() / rows.text(2));
  return all;
}

void write_manifest(const std::map<std::string, std::string>& contents) {
  std::string manifest = "#xxh3_128,bytes,path\n";
  for (const auto& [name, content] : contents) {
    sim::files::Hash hash;
    hash.add(content);
    manifest += hash.hex() + "," + std::to_string(content.size()) + "," + name + "\n";
  }
  fuzz::file("recording/manifest.csv", manifest);
}

const std::string& changed_file(std::uint8_t byte) {
  using namespace recording::recording_format;
  static const std::vector<std::string> all{
      kFrames,       kCameraSensor,    kCameraRows,     kImuSensor,         kImuRows,   kPlanSensor,
      kPlanRows,     kTrueCamera.file, kTrueWaist.file, kPlannedWaist.file, kFeet.file, kCorrectedSteps.file,
      kSurfaces.file};
  return all[byte % all.size()];
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static std::map<std::string, std::string> files = contents();
  if (size == 0) return 0;
  const std::string& changed = changed_file(data[0]);
  const std::string whole = std::exchange(files[changed], std::string(fuzz::text_of(data + 1, size - 1)));
  write_manifest(files);
  fuzz::file("recording/" + changed, files[changed]);
  fuzz::read_or_reject([&] {
    if (changed.starts_with("truth/")) {
      recording::read_truth(root());
    } else {
      recording::RecordingReader reader(root());
      while (reader.next()) continue;
    }
  });
  fuzz::file("recording/" + changed, files[changed] = whole);
  return 0;
}
