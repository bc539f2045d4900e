#include "sim/files/yaml.h"

#include <fmt/format.h>
#include <yaml-cpp/depthguard.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <numeric>
#include <set>
#include <sstream>

namespace sim::files {
namespace {

constexpr std::size_t kMostKeys = 1000;  // in one map: each is compared with all previous ones

/// Builds the tree from the parser's events, which, unlike YAML::Node, report aliases, tags and all
/// positions.
class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(const Origin& origin, YamlWriter writer) : origin_(origin), writer_(writer) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    close(open(mark, "", anchor, Yaml::Kind::empty));
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    fail(at(mark), "", "aliases (*name) are not supported: write the value out");
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    Yaml node = open(mark, tag, anchor, Yaml::Kind::scalar);
    node.text = value;
    node.quoted = tag == "!";
    close(std::move(node));
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open_.push_back(open(mark, tag, anchor, Yaml::Kind::list));
  }
  void OnSequenceEnd() override { close_collection(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open_.push_back(open(mark, tag, anchor, Yaml::Kind::map));
  }
  void OnMapEnd() override { close_collection(); }

  Yaml at(const YAML::Mark& mark) const {
    Yaml node;
    node.origin = origin_;
    if (mark.line > 0) node.origin = {origin_.file, origin_.line + mark.line, 1};
    node.origin.column += std::max(mark.column, 0);
    return node;
  }
  Yaml root;

 private:
  Yaml open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, Yaml::Kind kind) const {
    Yaml node = at(mark);
    node.kind = kind;
    if (writer_ == YamlWriter::other) return node;
    if (anchor != YAML::NullAnchor) fail(node, "", "anchors (&name) are not supported: write the value out");
    if (!tag.empty() && tag != "?" && tag != "!") fail(node, "", "tags (!name) are not supported");
    return node;
  }
  void close_collection() {
    Yaml node = std::move(open_.back());
    open_.pop_back();
    close(std::move(node));
  }
  void close(Yaml node) {
    if (open_.empty()) {
      root = std::move(node);
    } else if (Yaml& parent = open_.back(); parent.is_map() && parent.keys.size() == parent.items.size()) {
      parent.keys.push_back(checked_key(parent, std::move(node)));
    } else {
      parent.items.push_back(std::move(node));
    }
  }
  static Yaml checked_key(const Yaml& parent, Yaml key) {
    if (!key.is_scalar() || key.text.empty()) fail(key, "", "a key must be plain text");
    if (parent.keys.size() == kMostKeys) fail(key, "", "more than {} keys, expected fewer", kMostKeys);
    for (const Yaml& other : parent.keys)
      if (other.text == key.text) fail(key, key.text, "given twice, first on line {}", other.origin.line);
    return key;
  }

  Origin origin_;
  YamlWriter writer_;
  std::vector<Yaml> open_;
};

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
  const auto seed = parse_number<std::uint64_t>(text);
  if (!seed) reject_seeds(fmt::format("'{}' is not a seed", text));
  return *seed;
}

// OpenCV's reader requires it on the first line; yaml-cpp does not know this version.
constexpr std::string_view kOpenCvDirective = "%YAML:1.0";

}  // namespace

const Yaml* Yaml::find(std::string_view key) const {
  const auto found = std::ranges::find(keys, key, &Yaml::text);
  return found == keys.end() ? nullptr : &items[std::size_t(found - keys.begin())];
}

std::vector<std::pair<const Yaml&, const Yaml&>> Yaml::entries() const {
  std::vector<std::pair<const Yaml&, const Yaml&>> all;
  for (std::size_t i = 0; i < keys.size(); ++i) all.emplace_back(keys[i], items[i]);
  return all;
}

void fail(const Yaml& node, std::string_view key, std::string_view message) {
  const auto& [file, line, column] = node.origin;
  const std::string subject = key.empty() ? "" : fmt::format("{}: ", key);
  std::string text = fmt::format("{}:{}:{}: {}{}", file, line, column, subject, message);
  std::ranges::replace_if(
      text, [](unsigned char c) { return std::iscntrl(c) != 0; }, '?');
  throw ConfigError(text);
}

Yaml parse_yaml(std::string_view text, const Origin& origin, YamlWriter writer) {
  TreeBuilder builder(origin, writer);
  if (writer == YamlWriter::other) {
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);  // byte order mark
    if (text.starts_with(kOpenCvDirective)) text.remove_prefix(std::min(text.find('\n'), text.size()));
  }
  if (text.find('\0') != std::string_view::npos)
    fail(builder.at(YAML::Mark()), "", "has a zero byte, expected text");
  std::istringstream in{std::string(text)};
  try {
    YAML::Parser parser(in);
    if (!parser.HandleNextDocument(builder)) {
      builder.root.origin = origin;
      return builder.root;
    }
    Yaml root = std::move(builder.root);
    if (parser.HandleNextDocument(builder)) fail(builder.root, "", "a second document; expected one");
    return root;
  } catch (const YAML::DeepRecursion& e) {
    fail(builder.at(e.mark), "", "has {} or more levels, expected fewer", e.depth());
  } catch (const YAML::Exception& e) {
    fail(builder.at(e.mark), "", "bad YAML: " + e.msg);
  }
}

std::string quote_if_needed(std::string_view text) {
  const auto plain = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
  if (!text.empty() && std::ranges::all_of(text, plain) && text != "null") return std::string(text);
  YAML::Emitter out;
  out << YAML::DoubleQuoted << std::string(text);
  return out.c_str();
}

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

std::string yaml_text(const fs::path& file) {
  std::error_code fault;
  if (fs::is_directory(file, fault))
    throw ConfigError(fmt::format("{}: is a folder, expected a YAML file", file.string()));
  try {
    return read_text(file, kMostOfYaml);
  } catch (const FileError& e) {
    throw ConfigError(e.what());
  }
}

Yaml parse_yaml_file(const fs::path& file) { return parse_yaml(yaml_text(file), {file.string()}); }

void require_map(const Yaml& node, std::string_view key, std::string_view example) {
  if (!node.is_map()) fail(node, key, "expected {}", example);
}

void read_map(const Yaml& map, const MapReaders& readers) {
  for (const auto& [key, value] : map.entries()) {
    const auto reader = std::ranges::find(readers, key.text, &MapReaders::value_type::first);
    if (reader == readers.end()) {
      std::vector<std::string_view> names;
      for (const auto& [name, read] : readers) names.push_back(name);
      const std::string hint = did_you_mean(key.text, names);
      fail(key, key.text, "unknown key{}",
           hint.empty() ? fmt::format(", expected one of {}", fmt::join(names, ", ")) : hint);
    }
    reader->second(value);
  }
}

std::vector<std::string> read_texts(const Yaml& node, std::string_view key, std::string_view example) {
  if (!node.is_list()) fail(node, key, "expected a list, as in {}", example);
  std::vector<std::string> all;
  for (const Yaml& item : node.items) {
    if (!item.is_scalar()) fail(item, key, "expected text, as in {}", example);
    all.push_back(item.text);
  }
  return all;
}

fs::path read_path(const Yaml& node, std::string_view key, const fs::path& folder) {
  if (!node.is_scalar()) fail(node, key, "expected the path of a file or folder");
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
  if (!node.is_scalar()) fail(node, "seeds", "expected seeds, as in 1..5 or 1,2,7");
  try {
    return parse_seeds(node.text);
  } catch (const std::invalid_argument& e) {
    fail(node, "seeds", e.what());
  }
}

}  // namespace sim::files
