// The log of trials and the file of tasks: what is read as a record is written as it was.
#include "sim/tune/trial_log.h"

#include "sim/tune/task.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = fuzz::text_of(data, size);
  if (const auto record = sim::tune::from_line(text)) {
    const auto again = sim::tune::from_line(sim::tune::to_line(*record));
    fuzz::require(again && sim::tune::to_line(*again) == sim::tune::to_line(*record));
  }
  const auto file = fuzz::file("tasks", text);
  fuzz::read_or_refuse([&] { sim::tune::read_tasks(file); });
  fuzz::read_or_refuse([&] { sim::tune::read_trial_log(file, text.substr(0, text.find('\n'))); });
  return 0;
}
