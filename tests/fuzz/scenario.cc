// A scenario's YAML: what is read is printed, and read back as the same.
#include "sim/scenario/scenario.h"

#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace scenario = sim::scenario;
  fuzz::read_or_refuse([&] {
    const auto read = scenario::read_scenario_text(fuzz::text_of(data, size), "fuzz.yaml");
    const std::string printed = scenario::to_yaml(read.scenario);
    const auto again = scenario::read_scenario_text(printed, "fuzz.yaml");
    fuzz::require(scenario::to_yaml(again.scenario) == printed);
  });
  return 0;
}
