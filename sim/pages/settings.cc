#include "sim/pages/settings.h"

#include <algorithm>
#include <array>

#include "sim/scenario/keys.h"
#include "sim/scenario/scenario.h"

namespace sim::pages {

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
