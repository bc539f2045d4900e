// The YAML of a scenario: printed and read back it is the same scenario.
#include "sim/scenario/scenario.h"

#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace scenario = sim::scenario;
  const std::string error = fuzz::read_or_reject([&] {
    const auto read = scenario::read_scenario_text(fuzz::text_of(data, size), "fuzz.yaml");
    const std::string printed = scenario::to_yaml(read.scenario);
    const auto again = scenario::read_scenario_text(printed, "fuzz.yaml");
    fuzz::require(scenario::to_yaml(again.scenario) == printed);
  });
  fuzz::require(error.empty() || (error.starts_with("fuzz.yaml:") && error.find('\n') == error.npos));
  return 0;
}
