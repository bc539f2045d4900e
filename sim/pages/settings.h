// What distinguishes results: their settings, and how their estimates were aligned.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "sim/pages/run_data.h"

namespace sim::pages {

/// Returns all keys of a result's scenario except the seed, plus "revision" and "program" (the hash of an
/// external estimator's files). Contains no scenario keys if the scenario is missing or from another version.
std::map<std::string, std::string> settings_of(const fs::path& result, const result::About& about);

/// Returns the keys (including "estimator") that differ between runs of a scenario, with each run's value or
/// "".
std::map<std::string, std::vector<std::string>> changed_keys(const std::vector<const RunData*>& runs);

/// Returns what distinguishes each run from the others of its scenario, ignoring seeds: the keys that differ,
/// such as "slam.vision.sigma_px=3", preceded by the estimator if it differs or if no key does.
std::vector<std::string> variants(const std::vector<const RunData*>& runs);
/// Returns the same without estimator, controller and robot; "" if no other key differs.
std::vector<std::string> other_settings(const std::vector<const RunData*>& runs);

/// Returns how a result's estimate was aligned with the truth before it was scored, or "none".
std::string alignment_of(const result::About& about);
/// Returns a metric's column in tables over several results: "rmse_m_after_sim3" if alignment affects it.
std::string column_of(const std::string& metric, const std::string& alignment);

}  // namespace sim::pages
