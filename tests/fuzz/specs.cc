// The YAML of suites, sweeps and tunings; the first byte of an input selects the reader.
#include "sim/regression/suite.h"
#include "sim/trials/spec.h"
#include "sim/trials/sweep.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto walk =
      fuzz::file("walk.yaml", "walk: {commands: [{stand: {duration_s: 1}}]}\ncamera: {}\nslam: {}\n");
  if (size == 0) return 0;
  const auto spec = fuzz::file("spec.yaml", fuzz::text_of(data + 1, size - 1));
  fuzz::read_or_reject([&] {
    if (data[0] % 3 == 0) sim::regression::read_suite(spec);
    if (data[0] % 3 == 1) sim::trials::read_sweep(spec, {});
    if (data[0] % 3 == 2) sim::trials::read_spec(spec);
  });
  return 0;
}
