// The figures of a sweep's page.
#pragma once

#include <string>
#include <vector>

#include "sim/pages/figure.h"
#include "sim/pages/sweep_data.h"

namespace sim::pages {

/// Of each metric, heat maps of pairs of keys and lines over one key. Of many keys the first ones have
/// figures, and of many trials some are drawn as dots, so that the page of a large sweep can still be opened.
std::vector<Figure> sweep_figures(const ScenarioSweep& sweep);

/// HTML that says which keys have figures, where not all have.
std::string about_left_out(const ScenarioSweep& sweep);

}  // namespace sim::pages
