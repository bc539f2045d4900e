#include "sim/scenario/yaml_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "sim/files/text.h"

namespace sim::scenario {
namespace {

constexpr std::uint64_t kMostSeeds = 100'000;

[[noreturn]] void reject_seeds(const std::string& why) {
  throw std::invalid_argument(why + ", expected for example 1..5 or 1,2,7");
}

std::uint64_t parse_seed(std::string_view text) {
  const auto seed = files::parse_number<std::uint64_t>(text);
  if (!seed) reject_seeds(fmt::format("'{}' is not a seed", text));
  return *seed;
}

}  // namespace

Yaml parse_yaml_file(const std::filesystem::path& file) {
  try {
    return parse_yaml(files::read_text(file, files::kMostOfYaml), {file.string()});
  } catch (const files::FileError& e) {
    throw ConfigError(e.what());
  }
}

void require_map(const Yaml& node, std::string_view key, std::string_view example) {
  if (node.kind != Yaml::Kind::map) fail(node, key, fmt::format("expected {}", example));
}

void read_map(const Yaml& map, const MapReaders& readers) {
  for (std::size_t i = 0; i < map.keys.size(); ++i) {
    const Yaml& key = map.keys[i];
    const auto reader = std::find_if(readers.begin(), readers.end(),
                                     [&](const auto& known) { return known.first == key.text; });
    if (reader == readers.end()) {
      std::vector<std::string_view> names;
      for (const auto& [name, read] : readers) names.push_back(name);
      fail(key, key.text, "unknown key" + did_you_mean(key.text, names));
    }
    reader->second(map.items[i]);
  }
}

std::vector<std::string> read_texts(const Yaml& node, std::string_view key, std::string_view example) {
  if (node.kind != Yaml::Kind::list) fail(node, key, fmt::format("expected a list, as in {}", example));
  std::vector<std::string> all;
  for (const Yaml& item : node.items) {
    if (item.kind != Yaml::Kind::scalar) fail(item, key, fmt::format("expected text, as in {}", example));
    all.push_back(item.text);
  }
  return all;
}

std::filesystem::path read_path(const Yaml& node, std::string_view key, const std::filesystem::path& folder) {
  if (node.kind != Yaml::Kind::scalar) fail(node, key, "expected the path of a file or folder");
  return (folder / node.text).lexically_normal();
}

std::vector<std::uint64_t> parse_seeds(std::string_view text) {
  std::vector<std::uint64_t> seeds;
  while (true) {
    const std::string_view range = text.substr(0, text.find(','));
    const std::size_t dots = range.find("..");
    const std::uint64_t first = parse_seed(range.substr(0, dots));
    const std::uint64_t last = dots == range.npos ? first : parse_seed(range.substr(dots + 2));
    if (last < first) reject_seeds(fmt::format("'{}' goes backwards", range));
    if (last - first >= kMostSeeds - seeds.size())
      reject_seeds(fmt::format("more than {} seeds", kMostSeeds));
    for (std::uint64_t i = 0; i <= last - first; ++i) seeds.push_back(first + i);
    if (range.size() == text.size()) break;
    text.remove_prefix(range.size() + 1);
  }
  if (std::set(seeds.begin(), seeds.end()).size() != seeds.size()) reject_seeds("a seed is given twice");
  return seeds;
}

std::vector<std::uint64_t> read_seeds(const Yaml& node) {
  if (node.kind != Yaml::Kind::scalar) fail(node, "seeds", "expected seeds, as in 1..5 or 1,2,7");
  try {
    return parse_seeds(node.text);
  } catch (const std::invalid_argument& e) {
    fail(node, "seeds", e.what());
  }
}

}  // namespace sim::scenario
