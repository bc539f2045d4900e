// The log of trials and the file of tasks: what is read as a record is written as it was.
#include "sim/trials/log.h"

#include "sim/trials/task.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = fuzz::text_of(data, size);
  if (const auto record = sim::trials::from_line(text)) {
    const auto again = sim::trials::from_line(sim::trials::to_line(*record));
    fuzz::require(again && sim::trials::to_line(*again) == sim::trials::to_line(*record));
  }
  const auto file = fuzz::file("tasks", text);
  fuzz::read_or_refuse([&] { sim::trials::read_tasks(file); });
  fuzz::read_or_refuse([&] { sim::trials::read_trial_log(file, text.substr(0, text.find('\n'))); });
  return 0;
}
