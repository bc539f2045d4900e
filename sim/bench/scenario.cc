#include "sim/bench/scenario.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "sim/bench/scenario_reader.h"
#include "sim/bench/scenario_yaml.h"

namespace sim::bench {
namespace {

void leave_out(Scenario& scenario, const std::vector<std::string>& without) {
  static constexpr std::string_view kSections[]{"camera", "slam"};
  for (std::size_t i = 0; i < without.size(); ++i) {
    if (without[i] == "camera") {
      scenario.camera.reset();
    } else if (without[i] == "slam") {
      scenario.slam.reset();
    } else {
      throw ConfigError(fmt::format("--without {}: expected camera or slam{}", without[i],
                                    did_you_mean(without[i], kSections)));
    }
  }
}

/// What no single key can know.
void check_whole(const Scenario& scenario, const Yaml& at) {
  if (scenario.walk.commands.empty()) {
    fail(at, "walk.commands", "missing, expected a list of commands, as in [{stand: {duration_s: 1}}]");
  }
  if (scenario.slam && !scenario.camera) {
    fail(at, "slam",
         "needs the section 'camera': the filter works at its frames (--without camera,slam drops both)");
  }
}

std::string read_file(const std::filesystem::path& file) {
  constexpr std::uintmax_t kLargest = 1 << 20;
  std::error_code fault;
  if (std::filesystem::is_directory(file, fault))
    throw ConfigError(fmt::format("{}: is a folder, expected a scenario file", file.string()));
  std::ifstream in(file, std::ios::binary);
  if (!in) throw ConfigError(fmt::format("{}: cannot be read: {}", file.string(), std::strerror(errno)));
  std::string text(kLargest + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > kLargest)
    throw ConfigError(fmt::format("{}: larger than 1 MiB, expected a scenario", file.string()));
  return text;
}

}  // namespace

ReadScenario read_scenario(const std::filesystem::path& file, const Changes& changes) {
  return read_scenario_text(read_file(file), file.string(), changes);
}

ReadScenario read_scenario_text(std::string_view text, const std::string& file_name, const Changes& changes) {
  const Yaml root = parse_yaml(text, {file_name});
  if (root.kind != Yaml::Kind::map) fail(root, "", "expected a scenario: keys and values, as in seed: 1");
  ScenarioReader reader;
  reader.read_name_of_file(root, file_name);
  reader.read_map(root, "");
  for (const std::string& overlay : changes.with)
    reader.read_overlay(parse_yaml(read_file(overlay), {overlay}));
  int n = 0;
  for (const std::string& argument : changes.overrides) reader.read_override(argument, ++n);
  leave_out(reader.result.scenario, changes.without);
  check_whole(reader.result.scenario, root);
  return reader.result;
}

}  // namespace sim::bench
