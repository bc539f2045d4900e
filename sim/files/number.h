// Numbers in text.
#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

namespace sim::files {

/// The number that the whole text is, in decimals; nothing where it is none or does not fit the type.
template <typename Number>
std::optional<Number> parse_number(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// parse_number of a number that is neither infinite nor NaN.
inline std::optional<double> parse_finite(std::string_view text) {
  const auto value = parse_number<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

}  // namespace sim::files
