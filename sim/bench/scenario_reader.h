// From YAML to a scenario: each key through the one table, at most once, its origin noted.
#pragma once

#include <map>
#include <string>

#include "sim/bench/scenario.h"
#include "sim/bench/scenario_yaml.h"

namespace sim::bench {

/// Fills a scenario from a file's tree and from overrides. All members throw ConfigError.
class ScenarioReader {
 public:
  ReadScenario result;

  /// The file's stem names the scenario as long as no key does.
  void read_name_of_file(const Yaml& root, const std::string& file_name);

  /// All keys of a map; section: its dotted name, "" for the file's top.
  void read_map(const Yaml& map, const std::string& section);

  /// All keys of another file, which may set again what the file before set.
  void read_overlay(const Yaml& root);

  /// "key=value", the n-th of the command line (from 1).
  void read_override(const std::string& argument, int n);

 private:
  void read_entry(const Yaml& at, const std::string& path, const Yaml& value);
  void read_value(const Yaml& at, const std::string& path, const Yaml& value, const std::string& origin);
  void note_once(const Yaml& at, const std::string& path);
  void begin_section(std::string_view path);
  void require_section(const Yaml& at, const std::string& path);

  std::map<std::string, std::string> given_;  // keys of the file at hand, and where
};

}  // namespace sim::bench
