// YAML with a position on every node, read strictly: unique keys, no aliases, no tags, one document. Also
// readers for maps with known keys, for lists, and for seeds.
#pragma once

#include <functional>
#include <span>

#include "sim/files/text.h"

namespace sim::files {

/// Invalid input. what() is "file:line:column: key: what is wrong, expected ...".
class ConfigError : public FileError {
 public:
  explicit ConfigError(const std::string& text) : FileError(text) {}
};

/// The origin of a text: the file's name, and the line and column (from 1) at which the text starts.
struct Origin {
  std::string file;
  int line = 1, column = 1;
};

/// A node of a YAML tree. A map has keys and one item for each; a list has only items.
struct Yaml {
  enum class Kind { empty, scalar, list, map };
  Kind kind = Kind::empty;
  std::string text;     ///< text of a scalar
  bool quoted = false;  ///< a quoted scalar is always text
  Origin origin;
  std::vector<Yaml> keys, items;

  bool is_map() const { return kind == Kind::map; }
  bool is_list() const { return kind == Kind::list; }
  bool is_scalar() const { return kind == Kind::scalar; }
  /// Returns the value of a map's key, or nullptr.
  const Yaml* find(std::string_view key) const;
  /// Returns each key of a map with its value.
  std::vector<std::pair<const Yaml&, const Yaml&>> entries() const;
};

/// Throws ConfigError at the node's position. key may be empty (the error is about the whole file).
[[noreturn]] void fail(const Yaml& node, std::string_view key, std::string_view message);
/// message: a format string and its arguments.
template <typename First, typename... T>
[[noreturn]] void fail(const Yaml& node, std::string_view key, fmt::format_string<First, T...> message,
                       First&& first, T&&... rest) {
  fail(node, key, fmt::format(message, std::forward<First>(first), std::forward<T>(rest)...));
}

/// Who writes a file. Third-party files may have a byte order mark, OpenCV's directive %YAML:1.0, and tags
/// and anchors, which are ignored.
enum class YamlWriter { own, other };

/// Parses one document. Throws ConfigError.
Yaml parse_yaml(std::string_view text, const Origin& origin, YamlWriter writer = YamlWriter::own);

/// Returns the text as a YAML scalar that reads back as the same text.
std::string quote_if_needed(std::string_view text);

/// "; did you mean 'x'?" for the candidate nearest to the typed word, otherwise the first one that
/// contains it, otherwise "".
std::string did_you_mean(std::string_view typed, std::span<const std::string_view> candidates);
inline std::string did_you_mean(std::string_view typed, const std::vector<std::string>& candidates) {
  return did_you_mean(typed, std::vector<std::string_view>(candidates.begin(), candidates.end()));
}

/// The known keys of a map, each with the function that reads its value.
using MapReaders = std::vector<std::pair<std::string_view, std::function<void(const Yaml& value)>>>;

/// Returns the text of a YAML file. Throws ConfigError if it cannot be read or is larger than 1 MiB.
std::string yaml_text(const fs::path& file);

/// Parses a whole YAML file. Throws ConfigError if it cannot be read or is not YAML.
Yaml parse_yaml_file(const fs::path& file);

/// Throws ConfigError at the node unless it is a map. `example` appears in the message.
void require_map(const Yaml& node, std::string_view key, std::string_view example);

/// Calls the reader of each key of the map. Throws ConfigError at a key without a reader.
void read_map(const Yaml& map, const MapReaders& readers);

/// Returns a list of texts. Throws ConfigError if the node or an item is something else.
std::vector<std::string> read_texts(const Yaml& node, std::string_view key, std::string_view example);

/// Returns the path of a file, relative to `folder`. Throws ConfigError if the node is not a scalar.
fs::path read_path(const Yaml& node, std::string_view key, const fs::path& folder);

/// Returns seeds in the order of the text: 1..5, or 1,2,7, or both. Throws std::invalid_argument if the text
/// is something else, names a seed twice, or names more than 100000 seeds.
std::vector<std::uint64_t> parse_seeds(std::string_view text);
/// Does the same from a node. Throws ConfigError.
std::vector<std::uint64_t> read_seeds(const Yaml& node);

}  // namespace sim::files
