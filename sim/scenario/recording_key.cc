#include <fmt/format.h>

#include <algorithm>

#include "sim/files/hash.h"
#include "sim/model_file/model_file.h"
#include "sim/scenario/keys.h"
#include "sim/scenario/robot.h"

namespace sim::scenario {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_below(const fs::path& folder) {
  std::error_code fault;
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder, fault))
    if (entry.is_regular_file() && entry.path().extension() != ".md") files.push_back(entry.path());
  if (fault || files.empty()) throw files::FileError(folder, "has no models");
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

std::string models_hash(const fs::path& models) {
  files::Hash hash;
  for (const fs::path& file : files_below(models)) {
    hash.add_part(file.lexically_relative(models).generic_string());
    hash.add_part(files::read_text(file));
  }
  return hash.hex();
}

std::string recording_key(const Scenario& scenario, const std::string& models, const std::string& program) {
  files::Hash hash;
  hash.add_part("recording 1");
  hash.add_part(program);
  hash.add_part(models);
  const auto add_files = [&](const fs::path& model, const model_file::Packages& packages = {}) {
    for (const fs::path& file : model_file::files_of(model, packages)) hash.add_part(files::read_text(file));
  };
  if (const fs::path folder = std::string(scenario.world.robot); scenario.world.robot.is_path()) {
    const physics::RobotFile robot = read_robot(folder);
    hash.add_part(files::read_text(folder / "robot.yaml"));
    add_files(folder / robot.model, robot.packages);
  }
  if (scenario.world.room.is_path()) add_files(std::string(scenario.world.room));
  hash.add_part(fmt::format("seed {}{}", scenario.seed, programs::files_identity(scenario.controller)));
  for (const auto& key : scenario_keys()) {
    if (!shapes_recording(scenario, key.name) || !has_section(scenario, key.name)) continue;
    hash.add_part(key.name);
    hash.add_part(key.print(scenario));
  }
  return hash.hex();
}

}  // namespace sim::scenario
