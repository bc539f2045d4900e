// about.json of a result.
#include "sim/result/about_file.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto about = fuzz::file("about.json", fuzz::text_of(data, size));
  fuzz::read_or_refuse([&] { sim::result::read_about(about); });
  fuzz::read_or_refuse([&] { sim::result::read_about_of_walk(about); });
  return 0;
}
