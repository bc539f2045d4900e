#include "tools/cli/shared/model_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "sim/files/text.h"
#include "sim/scenario/yaml.h"

namespace cli {
namespace {

namespace fs = std::filesystem;
namespace scenario = sim::scenario;

/// The models of a folder by their names: a robot has actuators; a room has none and is part of no other
/// model.
struct ModelNames {
  std::set<std::string> robots, rooms;
};

ModelNames model_names(const fs::path& folder) {
  std::map<std::string, std::string> texts;
  std::error_code fault;
  for (const auto& entry : fs::directory_iterator(folder, fault))
    if (entry.path().extension() == ".xml")
      texts[entry.path().stem().string()] = sim::files::read_text(entry.path());
  const auto is_part = [&](const std::string& name) {
    const std::string include = fmt::format("<include file=\"{}.xml\"", name);
    return std::any_of(texts.begin(), texts.end(),
                       [&](const auto& other) { return other.second.find(include) != std::string::npos; });
  };
  ModelNames names;
  for (const auto& [name, text] : texts) {
    if (text.find("<actuator") != text.npos)
      names.robots.insert(name);
    else if (!is_part(name))
      names.rooms.insert(name);
  }
  return names;
}

void require_model(const scenario::ReadScenario& read, const std::string& key, const std::string& name,
                   const std::set<std::string>& known) {
  if (known.contains(name)) return;
  const auto set_by = read.origin.find(key);
  const std::vector<std::string_view> candidates(known.begin(), known.end());
  throw scenario::ConfigError(fmt::format("{}: {}: is '{}', expected one of {}{}",
                                          set_by == read.origin.end() ? read.scenario.name : set_by->second,
                                          key, name, fmt::join(known, ", "),
                                          scenario::did_you_mean(name, candidates)));
}

}  // namespace

std::filesystem::path standard_models() {
  std::error_code fault;
  const std::filesystem::path of_source = GAITSLAM_MODELS;
  if (std::filesystem::is_directory(of_source, fault)) return of_source;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", fault);
  return program.parent_path().parent_path() / "share/gaitslam/models";
}

void require_models(const scenario::ReadScenario& read, const fs::path& models) {
  const ModelNames names = model_names(models);
  if (names.robots.empty() && names.rooms.empty()) throw sim::files::FileError(models, "has no models");
  require_model(read, "world.robot", read.scenario.world.robot, names.robots);
  require_model(read, "world.room", read.scenario.world.room, names.rooms);
}

}  // namespace cli
