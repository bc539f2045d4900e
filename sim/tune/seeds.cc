#include "sim/tune/seeds.h"

#include <fmt/format.h>

#include <charconv>
#include <set>
#include <stdexcept>

namespace sim::tune {
namespace {

constexpr std::uint64_t kMost = 100000;

[[noreturn]] void reject(const std::string& why) {
  throw std::invalid_argument(why + ", expected for example 1..5 or 1,2,7");
}

std::uint64_t parse_seed(std::string_view text) {
  std::uint64_t seed = 0;
  const auto [stop, fault] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (fault != std::errc{} || stop != text.data() + text.size())
    reject(fmt::format("'{}' is not a seed", text));
  return seed;
}

}  // namespace

std::vector<std::uint64_t> parse_seeds(std::string_view text) {
  std::vector<std::uint64_t> seeds;
  while (true) {
    const std::string_view range = text.substr(0, text.find(','));
    const std::size_t dots = range.find("..");
    const std::uint64_t first = parse_seed(range.substr(0, dots));
    const std::uint64_t last = dots == range.npos ? first : parse_seed(range.substr(dots + 2));
    if (last < first) reject(fmt::format("'{}' goes backwards", range));
    if (last - first >= kMost - seeds.size()) reject(fmt::format("more than {} seeds", kMost));
    for (std::uint64_t i = 0; i <= last - first; ++i) seeds.push_back(first + i);
    if (range.size() == text.size()) break;
    text.remove_prefix(range.size() + 1);
  }
  if (std::set(seeds.begin(), seeds.end()).size() != seeds.size()) reject("a seed is given twice");
  return seeds;
}

}  // namespace sim::tune
