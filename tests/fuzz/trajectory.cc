// Trajectories of other programs: TUM with and without covariance, EuRoC, KITTI.
#include "sim/files/trajectory_file.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto file = fuzz::file("trajectory.txt", fuzz::text_of(data, size));
  fuzz::read_or_reject([&] { sim::files::read_trajectory(file); });
  fuzz::read_or_reject([&] { sim::files::read_tum(file); });
  return 0;
}
