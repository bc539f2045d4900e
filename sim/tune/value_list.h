// Lists of values as users of a sweep write them: 1,2,5 or range(0, 1, 0.1) or logspace(0.001, 0.1, 5).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/scenario/yaml.h"

namespace sim::tune {

/// A scalar of the form `name(a, b, c)` with numbers; nothing for any other scalar. Throws ConfigError at the
/// node when the name or a number is wrong.
struct Call {
  std::string name;
  std::vector<double> arguments;
};
std::optional<Call> call_of(const scenario::Yaml& scalar);

/// The values that one item of a list stands for. range(a, b, step): a, a + step, ... up to and including b;
/// linspace(a, b, n) and logspace(a, b, n): n values from a to b, evenly spaced or with an even factor;
/// any other item stands for itself. Throws ConfigError at the node.
std::vector<scenario::Yaml> values_of(const scenario::Yaml& item);

/// The most values of a key, and the most trials of a sweep.
inline constexpr std::size_t kMostTrials = 100'000;

/// The values of all items of a list, or of a node that is no list. Throws ConfigError at the item by which
/// they are more than kMostTrials.
std::vector<scenario::Yaml> values_of_list(const scenario::Yaml& list);

/// Text between commas outside of brackets and quotes, and where it begins.
struct Piece {
  std::string_view text;
  std::size_t begin = 0;
};
std::vector<Piece> split_at_commas(std::string_view text);

/// A number as a node, with at most 12 digits (0.1 + 0.2 is 0.3).
scenario::Yaml number_node(double value, const scenario::Origin& origin);

}  // namespace sim::tune
