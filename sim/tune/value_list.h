// The values that a sweep gives a key, as users write them: 1,2,5 or range(0, 1, 0.1) or logspace(0.001, 0.1,
// 5).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/bench/scenario_yaml.h"

namespace sim::tune {

/// `name(a, b, c)` with numbers, as a scalar has it; nothing for any other scalar. Throws ConfigError at the
/// node when it looks like one and is none.
struct Call {
  std::string name;
  std::vector<double> arguments;
};
std::optional<Call> call_of(const bench::Yaml& scalar);

/// What one item of a list stands for. range(a, b, step): a, a + step, ... as far as b, b itself included;
/// linspace(a, b, n) and logspace(a, b, n): n values from a to b, evenly spaced or with an even factor;
/// anything else: itself. Throws ConfigError at the node.
std::vector<bench::Yaml> values_of(const bench::Yaml& item);

/// Those of all items: of a list, or of the one that is no list.
std::vector<bench::Yaml> values_of_list(const bench::Yaml& list);

/// Text between commas that stand outside of all brackets and quotes, each with its place.
struct Piece {
  std::string_view text;
  std::size_t begin = 0;
};
std::vector<Piece> split_at_commas(std::string_view text);

/// A number as its own node, with 12 digits at most (0.1 + 0.2 is 0.3).
bench::Yaml number_node(double value, const bench::Origin& origin);

}  // namespace sim::tune
