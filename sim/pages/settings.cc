#include "sim/pages/settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <set>

#include "sim/scenario/keys.h"
#include "sim/scenario/scenario.h"

namespace sim::pages {

namespace {

/// Returns a key's value without YAML's indentation and line breaks.
std::string in_one_line(const std::string& value) {
  std::string line;
  for (const char c : value) {
    if (static_cast<unsigned char>(c) > ' ')
      line += c;
    else if (!line.empty() && line.back() != ' ' && line.back() != '[' && line.back() != '{')
      line += ' ';
  }
  return line;
}

/// Returns a text for each run, from what differs within its scenario.
std::vector<std::string> within_scenarios(
    const std::vector<const RunData*>& runs,
    const std::function<std::string(const RunData& run, const std::map<std::string, std::string>& changed)>&
        text) {
  std::map<std::string, std::vector<const RunData*>> scenarios;
  for (const RunData* run : runs) scenarios[run->scenario].push_back(run);
  std::map<const RunData*, std::map<std::string, std::string>> changed;
  for (const auto& [scenario, its_runs] : scenarios)
    for (const auto& [key, values] : changed_keys(its_runs))
      for (std::size_t i = 0; i < its_runs.size(); ++i)
        if (!values[i].empty()) changed[its_runs[i]][key] = values[i];
  std::vector<std::string> texts;
  for (const RunData* run : runs) texts.push_back(text(*run, changed[run]));
  return texts;
}

std::string joined(const std::map<std::string, std::string>& settings, const std::set<std::string>& without) {
  std::vector<std::string> words;
  for (const auto& [key, value] : settings)
    if (!without.contains(key)) words.push_back(key + "=" + value);
  return fmt::format("{}", fmt::join(words, ", "));
}

}  // namespace

std::string RunData::setting(const std::string& key) const {
  const auto found = settings.find(key);
  return found == settings.end() ? "" : in_one_line(found->second);
}

std::string RunData::label() const {
  return fmt::format("{}, seed {}{}{}", scenario, seed, estimator == "filter" ? "" : ", " + estimator,
                     alignment == "none" ? "" : " after " + alignment);
}

std::map<std::string, std::string> settings_of(const fs::path& result, const result::About& about) {
  std::map<std::string, std::string> settings;
  try {
    const scenario::Scenario read = scenario::read_scenario(result / "scenario.yaml").scenario;
    for (const auto& key : scenario::scenario_keys())
      if (key.name != "seed" && scenario::has_section(read, key.name))
        settings[std::string(key.name)] = key.print(read);
    for (const char* const section : {"camera", "slam"})
      settings[section] = scenario::has_section(read, section) ? "given" : "none";
  } catch (const std::exception&) {
    settings.clear();
  }
  if (!about.revision.empty()) settings["revision"] = about.revision;
  if (!about.estimator_files.empty()) settings["program"] = about.estimator_files.substr(0, 12);
  return settings;
}

std::map<std::string, std::vector<std::string>> changed_keys(const std::vector<const RunData*>& runs) {
  std::map<std::string, std::vector<std::string>> all;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    auto settings = runs[i]->settings;
    settings["estimator"] = runs[i]->estimator;
    for (const auto& [key, value] : settings) {
      all.try_emplace(key, runs.size()).first->second[i] = in_one_line(value);
    }
  }
  std::erase_if(all, [](const auto& of_key) {
    std::set<std::string> values(of_key.second.begin(), of_key.second.end());
    values.erase("");
    return values.size() < 2;
  });
  return all;
}

std::vector<std::string> variants(const std::vector<const RunData*>& runs) {
  return within_scenarios(runs, [](const RunData& run, const auto& changed) {
    const std::string keys = joined(changed, {"estimator"});
    if (keys.empty()) return run.estimator;
    return changed.contains("estimator") ? run.estimator + ", " + keys : keys;
  });
}

std::vector<std::string> other_settings(const std::vector<const RunData*>& runs) {
  return within_scenarios(runs, [](const RunData&, const auto& changed) {
    return joined(changed, {"estimator", "walk.controller", "world.robot"});
  });
}

std::string alignment_of(const result::About& about) {
  const bool is_name =
      about.alignment.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789") == std::string::npos;
  return about.alignment.empty() ? "none" : is_name ? about.alignment : "unknown";
}

std::string column_of(const std::string& metric, const std::string& alignment) {
  constexpr std::array kAligned{"rmse_m", "rotation_rmse_deg", "end_",     "drift_",
                                "nees_",  "loop_error_",       "landmark_"};
  const bool depends =
      std::ranges::any_of(kAligned, [&](const char* prefix) { return metric.starts_with(prefix); });
  return depends && alignment != "none" ? metric + "_after_" + alignment : metric;
}

}  // namespace sim::pages
