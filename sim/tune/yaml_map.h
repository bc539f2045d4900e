// Reads YAML maps strictly: each known key has its reader, and every other key is an error with its place.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/scenario/yaml.h"

namespace sim::tune {

/// The known keys of a map, each with the function that reads its value.
using MapReaders = std::vector<std::pair<std::string_view, std::function<void(const scenario::Yaml& value)>>>;

/// Parses a whole YAML file. Throws ConfigError when it cannot be read or is not YAML.
scenario::Yaml parse_yaml_file(const std::filesystem::path& file);

/// Throws ConfigError at the node unless it is a map; `example` says what was expected.
void require_map(const scenario::Yaml& node, std::string_view key, std::string_view example);

/// Calls the reader of each key of the map. Throws ConfigError at a key that has no reader.
void read_map(const scenario::Yaml& map, const MapReaders& readers);

/// Seeds as parse_seeds reads them. Throws ConfigError at the node.
std::vector<std::uint64_t> read_seeds(const scenario::Yaml& node);

/// A list of words. Throws ConfigError when the node is no list.
std::vector<std::string> read_texts(const scenario::Yaml& node, std::string_view key);

}  // namespace sim::tune
