// The parts of a spec that are lists and maps of its own: which keys are known, which recordings are meant.
#pragma once

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "sim/tune/spec.h"

namespace sim::tune {

/// All of these throw ConfigError at the node.
void require_map(const bench::Yaml& node, std::string_view key, std::string_view example);

/// Calls `each` with every key and value of the map; a key that is not known or given twice is an error.
void for_each_key(const bench::Yaml& map, std::initializer_list<std::string_view> known,
                  const std::function<void(const bench::Yaml& key, const bench::Yaml& value)>& each);

/// A list of words.
std::vector<std::string> texts(const bench::Yaml& node, std::string_view key);

/// A list of {recordings: FOLDER, seeds: 1..5, scenario: FILE, set: [key=value], with: [FILE]}; paths from
/// `folder`. Without recordings: those of the scenario in the cache.
std::vector<Footage> read_footage(const bench::Yaml& node, const std::string& key,
                                  const std::filesystem::path& folder);

/// Part of what a recording has in it: no replay changes it.
bool shapes_recording(std::string_view key);

/// "1..3,7": seeds in the order typed.
std::vector<std::uint64_t> read_seeds(const bench::Yaml& node);

}  // namespace sim::tune
