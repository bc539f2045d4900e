#include "sim/tune/value_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace sim::tune {
namespace {

using scenario::Yaml;

constexpr std::array<std::string_view, 5> kFunctions{"range", "linspace", "logspace", "uniform",
                                                     "loguniform"};

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(' '), end = text.find_last_not_of(' ');
  return begin == text.npos ? std::string_view{} : text.substr(begin, end - begin + 1);
}

double argument_of(const Yaml& node, const std::string& function, std::string_view text) {
  double value = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (fault != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    scenario::fail(node, "", fmt::format("{}(...): '{}' is no number", function, text));
  return value;
}

void require_arguments(const Yaml& node, const Call& call, std::size_t n, std::string_view example) {
  if (call.arguments.size() != n)
    scenario::fail(
        node, "",
        fmt::format("{}(...): has {} numbers, expected {}", call.name, call.arguments.size(), example));
}

std::vector<Yaml> range(const Yaml& node, const Call& call) {
  require_arguments(node, call, 3, "range(first, last, step)");
  const double first = call.arguments[0], last = call.arguments[1], step = call.arguments[2];
  const double steps = std::floor((last - first) / step + 1e-9);  // a last one that rounding misses is meant
  if (!(steps >= 0) || step == 0)
    scenario::fail(node, "", fmt::format("range(...): no step of {} leads from {} to {}", step, first, last));
  if (steps >= static_cast<double>(kMostTrials))
    scenario::fail(node, "", fmt::format("range(...): more than {} values", kMostTrials));
  std::vector<Yaml> values;
  for (int i = 0; i <= static_cast<int>(steps); ++i)
    values.push_back(number_node(first + i * step, node.origin));
  return values;
}

std::vector<Yaml> spaced(const Yaml& node, const Call& call) {
  const bool even_factor = call.name == "logspace";
  require_arguments(node, call, 3, call.name + "(first, last, how many)");
  double first = call.arguments[0], last = call.arguments[1];
  const double n = call.arguments[2];
  if (n != std::floor(n) || n < 2 || n > static_cast<double>(kMostTrials))
    scenario::fail(
        node, "",
        fmt::format("{}(...): {} values, expected a whole number from 2 to {}", call.name, n, kMostTrials));
  if (even_factor && !(first > 0 && last > 0))
    scenario::fail(
        node, "",
        fmt::format("logspace({}, {}, {}): expected bounds above 0, not their exponents", first, last, n));
  if (even_factor) first = std::log10(first), last = std::log10(last);
  std::vector<Yaml> values;
  for (int i = 0; i < static_cast<int>(n); ++i) {
    const double x = first + (last - first) * i / (n - 1);
    values.push_back(number_node(even_factor ? std::pow(10, x) : x, node.origin));
  }
  return values;
}

}  // namespace

Yaml number_node(double value, const scenario::Origin& origin) {
  Yaml node;
  node.kind = Yaml::Kind::scalar;
  node.text = fmt::format("{:.12g}", value);
  node.origin = origin;
  return node;
}

std::vector<Piece> split_at_commas(std::string_view text) {
  std::vector<Piece> pieces;
  std::size_t begin = 0;
  int depth = 0;
  char quote = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quote) {
      quote = c == quote ? 0 : quote;
    } else if (c == '\'' || c == '"') {
      quote = c;
    } else if (c == '(' || c == '[' || c == '{') {
      ++depth;
    } else if (c == ')' || c == ']' || c == '}') {
      --depth;
    } else if (c == ',' && depth == 0) {
      pieces.push_back({text.substr(begin, i - begin), begin});
      begin = i + 1;
    }
  }
  pieces.push_back({text.substr(begin), begin});
  return pieces;
}

std::optional<Call> call_of(const Yaml& scalar) {
  if (scalar.kind != Yaml::Kind::scalar) return std::nullopt;
  const std::string_view text = trimmed(scalar.text);
  const std::size_t open = text.find('(');
  if (open == text.npos) return std::nullopt;
  Call call{std::string(trimmed(text.substr(0, open))), {}};
  if (std::find(kFunctions.begin(), kFunctions.end(), call.name) == kFunctions.end())
    scenario::fail(
        scalar, "",
        fmt::format("unknown function '{}'{}", call.name, scenario::did_you_mean(call.name, kFunctions)));
  if (!text.ends_with(')'))
    scenario::fail(scalar, "",
                   fmt::format("'{}' has no ')'; in YAML's braces and brackets put it in quotes", text));
  for (const Piece& piece : split_at_commas(text.substr(open + 1, text.size() - open - 2)))
    call.arguments.push_back(argument_of(scalar, call.name, trimmed(piece.text)));
  return call;
}

std::vector<Yaml> values_of(const Yaml& item) {
  const std::optional<Call> call = call_of(item);
  if (!call) return {item};
  if (call->name == "range") return range(item, *call);
  if (call->name == "linspace" || call->name == "logspace") return spaced(item, *call);
  scenario::fail(
      item, "",
      fmt::format("{}(...) is for samples, expected values, range, linspace or logspace", call->name));
}

std::vector<Yaml> values_of_list(const Yaml& list) {
  if (list.kind != Yaml::Kind::list) return values_of(list);
  std::vector<Yaml> values;
  for (const Yaml& item : list.items) {
    for (Yaml& value : values_of(item)) values.push_back(std::move(value));
    if (values.size() > kMostTrials)
      scenario::fail(item, "",
                     fmt::format("makes {} values, expected at most {}", values.size(), kMostTrials));
  }
  return values;
}

}  // namespace sim::tune
