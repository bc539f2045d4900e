#include "sim/scenario/keys.h"

#include <fmt/ranges.h>

#include <limits>
#include <set>
#include <sstream>

#include "sim/score/metrics.h"

namespace sim::scenario {
namespace {

using std::string_view_literals::operator""sv;

void* find(void* owner, const std::vector<Key::Step>& place) {
  for (const Key::Step& step : place) {
    owner = static_cast<char*>(owner) + step.offset;
    if (step.content) owner = step.content(owner);
  }
  return owner;
}

constexpr std::array kAggregates{"median"sv, "mean"sv, "worst"sv};
constexpr std::array kBounds{"at_most"sv, "at_least"sv};
constexpr Domain kAnyNumber{std::numeric_limits<double>::lowest(), std::numeric_limits<double>::max()};

/// Returns the index of a name among the choices. Throws a ConfigError that lists them if it is not there.
std::size_t choose(const Yaml& at, const std::string& key, std::string_view name,
                   std::span<const std::string_view> choices) {
  const auto found = std::ranges::find(choices, name);
  if (found != choices.end()) return std::size_t(found - choices.begin());
  fail(at, key, "unknown '{}', expected one of {}{}", name, fmt::join(choices, ", "),
       did_you_mean(name, choices));
}

void check_metric(const Yaml& at, const std::string& key, std::string_view name) {
  if (score::find_metric(name) == nullptr) fail(at, key, unknown_metric(name));
}

}  // namespace

void Key::read_in(void* owner, const Yaml& node) const { type->read(node, name, domain, find(owner, place)); }

std::string Key::print_in(const void* owner) const {
  return type->print(domain, find(const_cast<void*>(owner), place));  // NOLINT: print changes nothing
}

void KeyList::add(std::string_view name, std::ptrdiff_t offset, const Domain& domain, std::string_view doc,
                  const ValueType& type) const {
  keys_.push_back(
      {prefix_ + std::string(name), std::string(doc), type.expected(domain), domain, &type, below({offset})});
}

std::vector<Key::Step> KeyList::below(const Key::Step& step) const {
  std::vector<Key::Step> place = place_;
  place.push_back(step);
  return place;
}

const std::vector<Key>& scenario_keys() {
  static const std::vector<Key> all = keys_of<Scenario>();
  return all;
}

const Key* find_key(std::string_view name) {
  const auto& all = scenario_keys();
  const auto found = std::ranges::find_if(all, [&](const auto& key) { return key.name == name; });
  return found == all.end() ? nullptr : &*found;
}

std::string unknown_key(const std::string& name) {
  std::set<std::string_view> names{"base"};  // keys and sections
  const std::string last = "." + name.substr(name.rfind('.') + 1);
  std::string beside;
  for (const Key& key : scenario_keys()) {
    for (std::size_t dot = 0; dot != key.name.npos; dot = key.name.find('.', dot + 1))
      if (dot > 0) names.insert(std::string_view(key.name).substr(0, dot));
    names.insert(key.name);
    if (key.name.ends_with(last)) beside = fmt::format("; did you mean '{}'?", key.name);
  }
  const std::vector<std::string_view> all(names.begin(), names.end());
  const std::string hint = did_you_mean(name, all);
  return "unknown key" + (!hint.empty()     ? hint
                          : !beside.empty() ? beside
                                            : "; gaitslam config --keys lists all");
}

const Scenario& default_scenario() {
  static const Scenario scenario = [] {
    Scenario s;
    s.camera.emplace();
    s.slam.emplace();
    return s;
  }();
  return scenario;
}

bool has_section(const Scenario& scenario, std::string_view key) {
  const std::string_view section = key.substr(0, key.find('.'));
  if (section == "camera") return scenario.camera.has_value();
  if (section == "slam" || section == "estimator") return scenario.slam.has_value();
  return true;
}

bool shapes_recording(std::string_view key) {
  static constexpr std::array<std::string_view, 6> kSections{"walk",   "stabilizer", "world",
                                                             "camera", "imu",        "rig"};
  const std::string_view section = key.substr(0, key.find('.'));
  return find_key(key) && std::ranges::find(kSections, section) != kSections.end();
}

bool shapes_estimate(std::string_view key) {
  return find_key(key) && (key.starts_with("errors.") || key.starts_with("slam.") ||
                           key.starts_with("estimator") || key == "sessions");
}

bool shapes_recording(const Scenario& scenario, std::string_view key) {
  const walking::SteeredBy by = scenario.walk.steering.by;
  return shapes_recording(key) || (by == walking::SteeredBy::truth && key == "errors.faults") ||
         (by == walking::SteeredBy::estimate && shapes_estimate(key));
}

std::optional<std::string> unit_of(std::string_view key) {
  std::istringstream endings(  // each name ending with its unit
      "_per_s2 1/s² _per_s 1/s _n_m N/m _m_s_per_n m/(N·s) _rad_s_per_nm rad/(N·m·s) _1_m 1/m _gray gray "
      "_rad_s2 rad/s² _rad_s rad/s _m_s2 m/s² _m_s3 m/s³ _m_s m/s _px2 px⁻² _px px _rad rad _deg deg _hz Hz "
      "_ms ms _ns N·s _s s _m m _kg kg _n N");
  for (std::string ending, unit; endings >> ending >> unit;)
    if (key.ends_with(ending)) return unit;
  return std::nullopt;
}

std::optional<RecordingDifference> first_difference(const Scenario& recorded, const Scenario& scenario,
                                                    bool (*counts)(std::string_view)) {
  for (const auto& key : scenario_keys()) {
    if (!counts(key.name) || !has_section(recorded, key.name)) continue;
    const std::string there = key.print(recorded),
                      now = has_section(scenario, key.name) ? key.print(scenario) : "left out";
    if (there != now) return RecordingDifference{key.name, there, now};
  }
  return std::nullopt;
}

std::optional<std::string> counterfactual(const Scenario& recorded, const Scenario& scenario) {
  if (recorded.walk.steering.by != walking::SteeredBy::estimate) return std::nullopt;
  if (recorded.estimator_time.model == TimeModel::measured)
    return "the recorded walk was steered with measured answer times, which are not repeatable";
  if (recorded.seed != scenario.seed)
    return fmt::format("the recorded walk was steered with seed {}, not {}", recorded.seed, scenario.seed);
  if (const auto other = first_difference(recorded, scenario, shapes_estimate))
    return fmt::format("the recorded walk was steered by an estimate with {} {}, not {}", other->key,
                       other->recorded, other->now);
  return std::nullopt;
}

std::string unknown_metric(std::string_view name) {
  std::vector<std::string_view> names;
  for (const auto& metric : score::metric_definitions()) names.push_back(metric.name);
  return fmt::format("unknown metric '{}'{}", name, did_you_mean(name, names));
}

void read_limit(const Yaml& at, const std::string& key, const Yaml& value, std::vector<MetricLimit>& limits) {
  const std::string_view rest = std::string_view(key).substr("limits."sv.size());
  const std::size_t first = rest.find('.'), last = rest.rfind('.');
  MetricLimit limit{std::string(rest.substr(0, first)), {}};
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
  const auto earlier = std::ranges::find_if(limits, same);
  earlier == limits.end() ? limits.push_back(limit) : void(*earlier = limit);
}

bool keeps(const MetricLimit& limit, double value) {
  return limit.bound == Bound::at_most ? value <= limit.value : value >= limit.value;
}

std::string subject(const MetricLimit& limit) {
  return limit.aggregate ? limit.metric + "." + *limit.aggregate : limit.metric;
}

std::string_view word(Bound bound) { return kBounds[std::size_t(bound)]; }

}  // namespace sim::scenario
