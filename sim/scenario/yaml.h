// Shared readers of scenarios and other YAML files: maps with known keys, lists of texts, seeds, suggestions.
#pragma once

#include <functional>
#include <span>

#include "sim/files/yaml.h"

namespace sim::scenario {

using files::ConfigError, files::Origin, files::Yaml, files::fail, files::parse_yaml, files::quote_if_needed;

/// "; did you mean 'x'?" for the candidate nearest to the typed word, else the first that contains it, or "".
std::string did_you_mean(std::string_view typed, std::span<const std::string_view> candidates);
inline std::string did_you_mean(std::string_view typed, const std::vector<std::string>& candidates) {
  return did_you_mean(typed, std::vector<std::string_view>(candidates.begin(), candidates.end()));
}

/// The known keys of a map, each with the function that reads its value.
using MapReaders = std::vector<std::pair<std::string_view, std::function<void(const Yaml& value)>>>;

/// Returns the text of a YAML file. Throws ConfigError if it cannot be read or is larger than 1 MiB.
std::string yaml_text(const std::filesystem::path& file);

/// Parses a whole YAML file. Throws ConfigError if it cannot be read or is not YAML.
Yaml parse_yaml_file(const std::filesystem::path& file);

/// Throws ConfigError at the node unless it is a map; `example` is in the message.
void require_map(const Yaml& node, std::string_view key, std::string_view example);

/// Calls the reader of each key of the map. Throws ConfigError at a key without a reader.
void read_map(const Yaml& map, const MapReaders& readers);

/// Returns a list of texts. Throws ConfigError if the node or an item is something else.
std::vector<std::string> read_texts(const Yaml& node, std::string_view key, std::string_view example);

/// Returns the path of a file, relative to `folder`. Throws ConfigError if the node is not a scalar.
std::filesystem::path read_path(const Yaml& node, std::string_view key, const std::filesystem::path& folder);

/// Returns seeds in the order of the text: 1..5, or 1,2,7, or both. Throws std::invalid_argument if the text
/// is something else, names a seed twice, or names more than 100000 seeds.
std::vector<std::uint64_t> parse_seeds(std::string_view text);
/// The same from a node. Throws ConfigError.
std::vector<std::uint64_t> read_seeds(const Yaml& node);

}  // namespace sim::scenario
