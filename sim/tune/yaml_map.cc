#include "sim/tune/yaml_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "sim/files/text.h"
#include "sim/tune/seeds.h"

namespace sim::tune {

using scenario::Yaml;

Yaml parse_yaml_file(const std::filesystem::path& file) {
  try {
    return scenario::parse_yaml(files::read_text(file, files::kMostOfYaml), {file.string()});
  } catch (const files::FileError& e) {
    throw scenario::ConfigError(e.what());
  }
}

void require_map(const Yaml& node, std::string_view key, std::string_view example) {
  if (node.kind != Yaml::Kind::map) scenario::fail(node, key, fmt::format("expected {}", example));
}

void read_map(const Yaml& map, const MapReaders& readers) {
  for (std::size_t i = 0; i < map.keys.size(); ++i) {
    const Yaml& key = map.keys[i];
    const auto reader = std::find_if(readers.begin(), readers.end(),
                                     [&](const auto& known) { return known.first == key.text; });
    if (reader == readers.end()) {
      std::vector<std::string_view> names;
      for (const auto& [name, read] : readers) names.push_back(name);
      scenario::fail(key, key.text, "unknown key" + scenario::did_you_mean(key.text, names));
    }
    reader->second(map.items[i]);
  }
}

std::vector<std::uint64_t> read_seeds(const Yaml& node) {
  if (node.kind != Yaml::Kind::scalar) scenario::fail(node, "seeds", "expected seeds, as in 1..5 or 1,2,7");
  try {
    return parse_seeds(node.text);
  } catch (const std::invalid_argument& e) {
    scenario::fail(node, "seeds", e.what());
  }
}

std::vector<std::string> read_texts(const Yaml& node, std::string_view key) {
  if (node.kind != Yaml::Kind::list) scenario::fail(node, key, "expected a list, as in [a, b]");
  std::vector<std::string> all;
  for (const Yaml& item : node.items) all.push_back(item.text);
  return all;
}

}  // namespace sim::tune
