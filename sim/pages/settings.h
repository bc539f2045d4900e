// The settings of a result, and how its estimate was aligned.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "sim/result/score_file.h"

namespace sim::pages {

namespace fs = std::filesystem;

/// Returns all keys of a result's scenario except the seed, plus "revision" and "program" (the hash of an
/// external estimator's files). Contains no scenario keys if the scenario is missing or from a different
/// version.
std::map<std::string, std::string> settings_of(const fs::path& result, const result::About& about);

/// Returns a key's value without YAML's indentation and line breaks.
std::string in_one_line(const std::string& value);

/// Returns how a result's estimate was aligned with the truth before it was scored, or "none".
std::string alignment_of(const result::About& about);
/// Returns a metric's column in tables over several results: "rmse_m_after_sim3" if alignment affects it.
std::string column_of(const std::string& metric, const std::string& alignment);

}  // namespace sim::pages
