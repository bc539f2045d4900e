// YAML with a position on every node, read strictly: unique keys, no aliases, no tags, one document.
#pragma once

#include "sim/files/text.h"

namespace sim::files {

/// Invalid input. what() is "file:line:column: key: what is wrong, expected ...".
class ConfigError : public FileError {
 public:
  explicit ConfigError(const std::string& text) : FileError(text) {}
};

/// Origin of a text: the file's name, and the line and column (from 1) of its start.
struct Origin {
  std::string file;
  int line = 1, column = 1;
};

/// A node of a YAML tree. A map's keys and items go together, a list has items only.
struct Yaml {
  enum class Kind { empty, scalar, list, map };
  Kind kind = Kind::empty;
  std::string text;     ///< of a scalar
  bool quoted = false;  ///< a scalar in quotes is text, whatever it looks like
  Origin origin;
  std::vector<Yaml> keys, items;

  bool is_map() const { return kind == Kind::map; }
  bool is_list() const { return kind == Kind::list; }
  /// Returns the value of a map's key, or nullptr.
  const Yaml* find(std::string_view key) const;
};

/// Throws ConfigError at the node's position. key may be empty (an error of the whole file).
[[noreturn]] void fail(const Yaml& node, std::string_view key, std::string_view message);

/// The programs that write a file. The files of others may have a byte order mark, OpenCV's directive
/// %YAML:1.0, and tags and anchors, which are ignored.
enum class YamlWriter { own, other };

/// Parses one document. Throws ConfigError.
Yaml parse_yaml(std::string_view text, const Origin& origin, YamlWriter writer = YamlWriter::own);

/// Text as a YAML scalar that reads back as the same text.
std::string quote_if_needed(std::string_view text);

}  // namespace sim::files
