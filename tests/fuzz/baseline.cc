// A baseline, its seal made for the input.
#include "sim/regression/results.h"

#include "sim/files/hashed_file.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string text(fuzz::text_of(data, size));
  sim::files::Hash hash;
  hash.add(text);
  text += "\"xxh3_128\": \"" + hash.hex() + "\"\n}\n";
  fuzz::read_or_refuse([&] { sim::regression::read_baseline(fuzz::file("baseline.json", text)); });
  return 0;
}
