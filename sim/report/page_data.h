// The data that a page's script draws from, as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "sim/report/figure.h"
#include "sim/report/run_data.h"

namespace sim::report {

/// {title, subtitle, definitions, figures of all runs together, runs: [{label, verdict, score, figures,
/// scene, ...}]}. Numbers of series are rounded to five digits.
nlohmann::ordered_json page_data(const std::vector<RunData>& runs);

/// A figure as the script reads it; one with equal axes is an SVG.
nlohmann::ordered_json to_json(const Figure& figure);

}  // namespace sim::report
