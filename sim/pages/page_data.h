// The data that a page's script draws from, as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "sim/pages/figure.h"
#include "sim/pages/run_data.h"

namespace sim::pages {

/// {title, subtitle, definitions, figures of all runs together, runs: [{label, verdict, score, figures,
/// scene, ...}]}. Numbers of series are rounded to five digits.
nlohmann::ordered_json page_data(const std::vector<RunData>& runs);

/// A figure as the script reads it; one with equal axes is an SVG.
nlohmann::ordered_json to_json(const Figure& figure);

}  // namespace sim::pages
