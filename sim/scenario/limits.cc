#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <limits>

#include "sim/scenario/keys.h"
#include "sim/scenario/value.h"
#include "sim/score/metrics.h"

namespace sim::scenario {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::array kAggregates{"median"sv, "mean"sv, "worst"sv};
constexpr std::array kBounds{"at_most"sv, "at_least"sv};
constexpr Domain kAnyNumber{std::numeric_limits<double>::lowest(), std::numeric_limits<double>::max()};

/// Returns the index of name among the choices, or throws a ConfigError that lists them.
std::size_t choose(const Yaml& at, const std::string& key, std::string_view name,
                   std::span<const std::string_view> choices) {
  const auto found = std::find(choices.begin(), choices.end(), name);
  if (found != choices.end()) return static_cast<std::size_t>(found - choices.begin());
  fail(at, key,
       fmt::format("unknown '{}', expected one of {}{}", name, fmt::join(choices, ", "),
                   did_you_mean(name, choices)));
}

void check_metric(const Yaml& at, const std::string& key, std::string_view name) {
  if (score::find_metric(name) == nullptr) fail(at, key, unknown_metric(name));
}

}  // namespace

std::string unknown_metric(std::string_view name) {
  if (const std::string former = former_name(name); !former.empty())
    return fmt::format("metric {} {}", name, former);
  std::vector<std::string_view> names;
  for (const auto& metric : score::metric_definitions()) names.push_back(metric.name);
  return fmt::format("unknown metric '{}'{}", name, did_you_mean(name, names));
}

void read_limit(const Yaml& at, const std::string& key, const Yaml& value, std::vector<MetricLimit>& limits) {
  const std::string_view rest = std::string_view(key).substr("limits."sv.size());
  const std::size_t first = rest.find('.'), last = rest.rfind('.');
  MetricLimit limit{std::string(rest.substr(0, first)), ""};
  if (first == std::string_view::npos) {
    static constexpr std::array kOther{"limits.ending"sv};
    const std::string hint = did_you_mean(key, kOther);
    if (!hint.empty()) fail(at, key, "unknown key" + hint);
    check_metric(at, key, rest);
    fail(at, key, "expected a bound below the metric, as in {at_most: 0.1} or {at_least: 1}");
  }
  limit.bound = static_cast<Bound>(choose(at, key, rest.substr(last + 1), kBounds));
  if (last > first)
    limit.aggregate = kAggregates[choose(at, key, rest.substr(first + 1, last - first - 1), kAggregates)];
  check_metric(at, key, limit.metric);
  read(value, key, kAnyNumber, limit.value);
  const auto same = [&](const MetricLimit& l) {
    return subject(l) == subject(limit) && l.bound == limit.bound;
  };
  const auto earlier = std::find_if(limits.begin(), limits.end(), same);
  earlier == limits.end() ? limits.push_back(limit) : void(*earlier = limit);
}

bool keeps(const MetricLimit& limit, double value) {
  return limit.bound == Bound::at_most ? value <= limit.value : value >= limit.value;
}

std::string subject(const MetricLimit& limit) {
  return limit.aggregate.empty() ? limit.metric : limit.metric + "." + limit.aggregate;
}

std::string_view word(Bound bound) { return kBounds[static_cast<std::size_t>(bound)]; }

}  // namespace sim::scenario
