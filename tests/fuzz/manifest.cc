// The list of a recording's files. None outside of the folder is opened, whatever the list says.
#include "sim/recording/manifest.h"

#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto outside = fuzz::file("outside.txt", "content"),
                    inside = fuzz::file("recording/inside.txt", "content");
  fuzz::file("recording/manifest.csv", fuzz::text_of(data, size));
  fuzz::read_or_refuse([] {
    const sim::recording::Manifest manifest(fuzz::folder() / "recording");
    fuzz::require(!manifest.lists("../outside.txt"));
    manifest.check_sizes();
    manifest.read("inside.txt");
  });
  return 0;
}
