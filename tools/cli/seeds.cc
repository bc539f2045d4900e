#include "tools/cli/seeds.h"

#include <fmt/format.h>

#include <charconv>
#include <set>
#include <string_view>

#include "tools/cli/commands.h"

namespace cli {
namespace {

constexpr std::uint64_t kMost = 100000;

[[noreturn]] void reject(const std::string& text, const std::string& why) {
  throw UsageError(fmt::format("--seeds {}: {}, expected for example 1..5 or 1,2,7", text, why));
}

std::uint64_t parse_seed(const std::string& text, std::string_view part) {
  std::uint64_t seed = 0;
  const auto [stop, fault] = std::from_chars(part.data(), part.data() + part.size(), seed);
  if (fault != std::errc{} || stop != part.data() + part.size()) {
    reject(text, fmt::format("'{}' is not a seed", part));
  }
  return seed;
}

}  // namespace

std::vector<std::uint64_t> parse_seeds(const std::string& text) {
  std::vector<std::uint64_t> seeds;
  for (std::string_view rest = text; !rest.empty() || seeds.empty();) {
    const std::string_view part = rest.substr(0, rest.find(','));
    const std::size_t dots = part.find("..");
    const std::uint64_t first = parse_seed(text, part.substr(0, dots));
    const std::uint64_t last = dots == part.npos ? first : parse_seed(text, part.substr(dots + 2));
    if (last < first) reject(text, fmt::format("'{}' goes backwards", part));
    if (last - first >= kMost - seeds.size()) reject(text, fmt::format("more than {} seeds", kMost));
    for (std::uint64_t seed = first; seed != last; ++seed) seeds.push_back(seed);
    seeds.push_back(last);
    rest.remove_prefix(part.size());
    if (rest == ",") reject(text, "ends in a comma");
    if (!rest.empty()) rest.remove_prefix(1);
  }
  if (std::set(seeds.begin(), seeds.end()).size() != seeds.size()) reject(text, "a seed is given twice");
  return seeds;
}

}  // namespace cli
