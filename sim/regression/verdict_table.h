// Verdicts as text for the terminal, 80 columns wide.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/regression/verdict.h"

namespace sim::regression {

/// A comparison for printing. file: of a scenario; repro: the command that repeats the run of one seed, or an
/// empty text.
struct Comparison {
  std::string title;
  std::vector<ScenarioVerdict> scenarios;
  std::function<std::string(const std::string& scenario)> file;
  std::function<std::string(const std::string& scenario, std::uint64_t seed)> repro;
};

/// "10 %", "0.002 m", "10 % or 0.002 m"; of a metric with an expected value "a factor of 1.3"
std::string tolerance_text(const Gate& gate);
/// "+27 %"; the change itself where the baseline is 0; "-" where there is none
std::string change_text(const MetricVerdict& metric);
/// "2 of 14 rows failed"
std::string count_text(const Comparison& comparison);
/// "3 seeds paired, the same recordings"
std::string pairing_text(const ScenarioVerdict& scenario);

/// The whole table; the command that repeats a run stands once for all rows that name it. colours: paint the
/// verdicts for a terminal.
std::string verdict_table(const Comparison& comparison, bool colours);

}  // namespace sim::regression
