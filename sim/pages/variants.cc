#include "sim/pages/variants.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <functional>
#include <set>

#include "sim/pages/settings.h"

namespace sim::pages {

namespace {

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

std::string joined(const std::map<std::string, std::string>& settings, bool (*wanted)(std::string_view key)) {
  std::vector<std::string> words;
  for (const auto& [key, value] : settings)
    if (wanted(key)) words.push_back(key + "=" + value);
  return fmt::format("{}", fmt::join(words, ", "));
}

bool is_error(std::string_view key) { return key.starts_with("errors."); }

}  // namespace

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
    const std::string keys = joined(changed, [](std::string_view key) { return key != "estimator"; });
    if (keys.empty()) return run.estimator;
    return changed.contains("estimator") ? run.estimator + ", " + keys : keys;
  });
}

std::vector<std::string> other_settings(const std::vector<const RunData*>& runs) {
  return within_scenarios(runs, [](const RunData&, const auto& changed) {
    return joined(changed, [](std::string_view key) {
      return key != "estimator" && key != "walk.controller" && key != "world.robot" && !is_error(key);
    });
  });
}

std::vector<std::string> changed_errors(const std::vector<const RunData*>& runs) {
  return within_scenarios(runs,
                          [](const RunData&, const auto& changed) { return joined(changed, is_error); });
}

}  // namespace sim::pages
