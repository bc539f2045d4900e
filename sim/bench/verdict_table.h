// Verdicts as text for the terminal, 80 columns wide.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/bench/verdict.h"

namespace sim::bench {

/// What is said of a comparison besides its verdicts. file: the scenario's; repro: one line to copy and paste
/// that runs one seed of a scenario as it was run, or nothing.
struct Comparison {
  std::string title;
  std::vector<ScenarioVerdict> scenarios;
  std::function<std::string(const std::string& scenario)> file;
  std::function<std::string(const std::string& scenario, std::uint64_t seed)> repro;
};

/// "10 %", "0.002 m", "10 % or 0.002 m"
std::string tolerance_text(const Gate& gate);
/// "+27 %"; of a baseline of 0 the change itself; "-" where there is none
std::string change_text(const MetricVerdict& metric);
/// "2 of 14 rows failed"
std::string count_text(const Comparison& comparison);
/// "3 seeds, paired; ..."
std::string pairing_text(const ScenarioVerdict& scenario);

/// The whole table. colour: of the verdicts, for terminals.
std::string verdict_table(const Comparison& comparison, bool colour);

}  // namespace sim::bench
