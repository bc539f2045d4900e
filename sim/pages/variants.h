// Differences between the runs of a scenario.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "sim/pages/run_data.h"

namespace sim::pages {

/// Returns the keys (including "estimator") that differ between runs of a scenario, with each run's value or
/// "".
std::map<std::string, std::vector<std::string>> changed_keys(const std::vector<const RunData*>& runs);

/// Returns what distinguishes each run from the others of its scenario, ignoring seeds: the keys that differ,
/// such as "slam.vision.sigma_px=3", preceded by the estimator if it differs or if no key does.
std::vector<std::string> variants(const std::vector<const RunData*>& runs);
/// Returns the same without estimator, controller, robot and errors.*; "" if no other key differs.
std::vector<std::string> other_settings(const std::vector<const RunData*>& runs);
/// Returns the same with only errors.*.
std::vector<std::string> changed_errors(const std::vector<const RunData*>& runs);

}  // namespace sim::pages
