// Command-line arguments, one per line: an override, seeds, and the values of a sweep.
#include <stdexcept>

#include "sim/scenario/scenario.h"
#include "sim/scenario/yaml.h"
#include "sim/trials/sweep.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto walk =
      fuzz::file("walk.yaml", "walk: {commands: [{stand: {duration_s: 1}}]}\ncamera: {}\nslam: {}\n");
  const std::string text(fuzz::text_of(data, size));
  const std::size_t end = text.find('\n');
  const std::string first = text.substr(0, end), second = end == text.npos ? "" : text.substr(end + 1);
  fuzz::read_or_reject([&] { sim::scenario::read_scenario(walk, {{first, second}, {}, {}}); });
  fuzz::read_or_reject([&] { sim::trials::read_sweep(walk, {first, second}); });
  try {
    sim::scenario::parse_seeds(first);
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
