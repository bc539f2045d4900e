// YAML: scenarios, suites, sweeps and tunings, and arguments of the command line.

#include "sim/regression/suite.h"
#include "sim/scenario/scenario.h"
#include "sim/trials/spec.h"
#include "sim/trials/sweep.h"
#include "tests/fuzz/fuzz_input.h"

namespace fuzz {

namespace scenarios = sim::scenario;

inline const std::filesystem::path& walk() {
  static const auto made =
      file("walk.yaml", "walk: {commands: [{stand: {duration_s: 1}}]}\ncamera: {}\nslam: {}\n");
  return made;
}

/// One argument per line: an override, seeds, and the values of a sweep.
inline void arguments(std::string_view input) {
  const std::string text(input);
  const std::size_t end = text.find('\n');
  const std::string first = text.substr(0, end), second = end == text.npos ? "" : text.substr(end + 1);
  read_or_reject([&] { scenarios::read_scenario(walk(), {{first, second}, {}, {}}); });
  read_or_reject([&] { sim::trials::read_sweep(walk(), {first, second}); });
  read_or_reject<std::invalid_argument>([&] { scenarios::parse_seeds(first); });
}

/// Printed and read back a scenario is the same one.
inline void scenario(std::string_view text) {
  const std::string error = read_or_reject([&] {
    const auto read = scenarios::read_scenario_text(text, "fuzz.yaml");
    const std::string printed = scenarios::to_yaml(read.scenario);
    const auto again = scenarios::read_scenario_text(printed, "fuzz.yaml");
    require(scenarios::to_yaml(again.scenario) == printed);
  });
  require(error.empty() || (error.starts_with("fuzz.yaml:") && error.find('\n') == error.npos));
}

/// Suites, sweeps and tunings; the first byte of an input selects the reader.
inline void specs(std::string_view text) {
  walk();
  if (text.empty()) return;
  const auto spec = file("spec.yaml", text.substr(1));
  read_or_reject([&] {
    const int reader = static_cast<unsigned char>(text[0]) % 3;
    if (reader == 0) sim::regression::read_suite(spec);
    if (reader == 1) sim::trials::read_sweep(spec, {});
    if (reader == 2) sim::trials::read_spec(spec);
  });
}

}  // namespace fuzz
GAITSLAM_FUZZ_ENTRY
