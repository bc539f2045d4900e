// A trajectory report as a table for the terminal, JSON, CSV and LaTeX.
#pragma once

#include <string>

#include "sim/score/trajectory_report.h"

namespace sim::score {

std::string trajectory_table(const TrajectoryReport& report);
std::string trajectory_json(const TrajectoryReport& report);
std::string trajectory_csv(const TrajectoryReport& report);
std::string trajectory_latex(const TrajectoryReport& report);

}  // namespace sim::score
