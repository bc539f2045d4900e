// The sensor.yaml of cameras, IMUs, plans and mountings, ours and others'.
#include "sim/recording/sensor_yaml.h"

#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace recording = sim::recording;
  const std::string text(fuzz::text_of(data, size));
  recording::RecordingSetup setup;
  const std::string camera =
      fuzz::read_or_refuse([&] { recording::read_camera_yaml("sensor.yaml", text, setup); });
  const std::string imu = fuzz::read_or_refuse([&] { recording::read_imu_yaml("sensor.yaml", text, setup); });
  // All have one parser, whose words these are: the others would only repeat them.
  if (!camera.empty() && camera == imu) return 0;
  fuzz::read_or_refuse([&] { recording::read_mounted_imu("sensor.yaml", text); });
  fuzz::read_or_refuse([&] { recording::read_mounting("sensor.yaml", text); });
  fuzz::read_or_refuse([&] { recording::read_plan_yaml("sensor.yaml", text, setup); });
  return 0;
}
