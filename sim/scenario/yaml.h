// YAML with a position on every node, read strictly: unique keys, no aliases, no tags, one document.
#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace sim::scenario {

/// Invalid input. what() is "file:line:column: key: what is wrong, expected ...".
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
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
};

/// Throws ConfigError at the node's position. key may be empty (an error of the whole file).
[[noreturn]] void fail(const Yaml& node, std::string_view key, std::string_view message);

/// Parses one document. Throws ConfigError.
Yaml parse_yaml(std::string_view text, const Origin& origin);

/// "; did you mean 'x'?" for the candidate nearest to the typed word, else for the first that contains it as
/// a whole word (ate in ate_se3_rmse_m), else "".
std::string did_you_mean(std::string_view typed, std::span<const std::string_view> candidates);

/// Text as a YAML scalar that reads back as the same text.
std::string quote_if_needed(std::string_view text);

}  // namespace sim::scenario
