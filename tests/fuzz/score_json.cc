// score.json and timing.json of a result.
#include "sim/result/score_file.h"
#include "sim/result/score_table.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr const char* kTiming =
      "{\"frame_cpu_ms_median\": 1, \"frame_cpu_ms_p99\": 1, \"realtime_factor\": 1}";
  fuzz::file("timing.json", kTiming);
  const auto score = fuzz::file("score.json", fuzz::text_of(data, size));
  fuzz::read_or_refuse([&] { sim::result::read_score(score); });
  fuzz::read_or_refuse([] { sim::result::score_table(fuzz::folder()); });
  fuzz::file("timing.json", fuzz::text_of(data, size));
  fuzz::read_or_refuse([] { sim::result::score_table(fuzz::folder()); });
  return 0;
}
