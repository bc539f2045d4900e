// The YAML of a sweep.
#include "sim/trials/sweep.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto walk =
      fuzz::file("walk.yaml", "walk: {commands: [{stand: {duration_s: 1}}]}\ncamera: {}\nslam: {}\n");
  fuzz::read_or_refuse(
      [&] { sim::trials::read_sweep(fuzz::file("sweep.yaml", fuzz::text_of(data, size)), {}); });
  return 0;
}
