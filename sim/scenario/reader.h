// From YAML to a scenario: each key through the one table, at most once in a file, its origin noted.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "sim/scenario/options.h"
#include "sim/scenario/yaml.h"

namespace sim::scenario {

/// A scenario and where each key that is not at its default was set ("file:line" or "argument 2").
struct ReadScenario {
  Scenario scenario;
  std::map<std::string, std::string, std::less<>> origin;
  std::vector<Origin> command_origins = {};  ///< of each of walk.commands
};

/// The text of a scenario file. Throws ConfigError when it cannot be read or is larger than 1 MiB.
std::string file_text(const std::filesystem::path& file);

/// Fills a scenario from the trees of files and from overrides; what is read later replaces what was read
/// before. All members throw ConfigError.
class ScenarioReader {
 public:
  ReadScenario result;

  /// All keys of a file, after those of the files that its key `base` names. root.origin.file: its path.
  void read_file(const Yaml& root);

  /// Names the scenario after the file, unless it has a key `name`; the name of a base is not inherited.
  void read_name_of_file(const Yaml& root, const std::string& file_name);

  /// "key=value", the n-th of the command line (from 1).
  void read_override(const std::string& argument, int n);

 private:
  void read_bases(const Yaml& root);
  void read_base(const Yaml& node);
  void read_map(const Yaml& map, const std::string& section);
  void read_entry(const Yaml& at, const std::string& path, const Yaml& value);
  void read_value(const Yaml& at, const std::string& path, const Yaml& value, const std::string& origin);
  void note_commands(const Yaml& commands);
  void note_once(const Yaml& at, const std::string& path);
  void begin_section(std::string_view path);
  void require_section(const Yaml& at, const std::string& path);

  std::vector<std::filesystem::path> open_files_;  // each but the first is a base of the one before
  int bases_read_ = 0;
  std::map<std::string, std::string> given_;  // keys of the file at hand, and where
};

}  // namespace sim::scenario
