#include "sim/scenario/yaml.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <set>

namespace sim::scenario {
namespace {

/// Edit distance; swapping neighbors counts as one edit.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  std::iota(d[0].begin(), d[0].end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i)
    for (std::size_t j = 1; j <= b.size(); ++j) {
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

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

std::string did_you_mean(std::string_view typed, std::span<const std::string_view> candidates) {
  const std::size_t allowed = std::max<std::size_t>(2, typed.size() / 3);
  const std::string_view begin = typed.substr(0, 100);
  std::string_view best;
  std::size_t best_distance = allowed + 1;
  for (const std::string_view candidate : candidates) {
    if (std::max(begin.size(), candidate.size()) - std::min(begin.size(), candidate.size()) >= best_distance)
      continue;  // their distance is at least that difference
    const std::size_t distance = edit_distance(begin, candidate);
    if (distance < best_distance && distance < candidate.size()) {
      best = candidate;
      best_distance = distance;
    }
  }
  for (const std::string_view candidate : candidates)
    if (best.empty() && typed.size() > 2 && candidate.find(typed) != candidate.npos) best = candidate;
  return best.empty() ? "" : fmt::format("; did you mean '{}'?", best);
}

std::string yaml_text(const std::filesystem::path& file) {
  std::error_code fault;
  if (std::filesystem::is_directory(file, fault))
    throw ConfigError(fmt::format("{}: is a folder, expected a YAML file", file.string()));
  try {
    return files::read_text(file, files::kMostOfYaml);
  } catch (const files::FileError& e) {
    throw ConfigError(e.what());
  }
}

Yaml parse_yaml_file(const std::filesystem::path& file) {
  return parse_yaml(yaml_text(file), {file.string()});
}

void require_map(const Yaml& node, std::string_view key, std::string_view example) {
  if (node.kind != Yaml::Kind::map) fail(node, key, fmt::format("expected {}", example));
}

void read_map(const Yaml& map, const MapReaders& readers) {
  for (std::size_t i = 0; i < map.keys.size(); ++i) {
    const Yaml& key = map.keys[i];
    const auto reader = std::ranges::find(readers, key.text, &MapReaders::value_type::first);
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
