// The sensor.yaml of cameras, IMUs, plans and mountings, written by this and by other programs.
#include "sim/recording/sensor_yaml.h"

#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace recording = sim::recording;
  const std::string text(fuzz::text_of(data, size));
  recording::RecordingSetup setup;
  const std::string camera =
      fuzz::read_or_reject([&] { recording::read_camera_yaml("sensor.yaml", text, setup); });
  const std::string imu = fuzz::read_or_reject([&] { recording::read_imu_yaml("sensor.yaml", text, setup); });
  // Both messages are the parser's, which the other readers share.
  if (!camera.empty() && camera == imu) return 0;
  fuzz::read_or_reject([&] { recording::read_mounted_imu("sensor.yaml", text); });
  fuzz::read_or_reject([&] { recording::read_mounting("sensor.yaml", text); });
  fuzz::read_or_reject([&] { recording::read_plan_yaml("sensor.yaml", text, setup); });
  return 0;
}
