// The table of keys, used for reading, overrides, help, printing, sweeps and tuning.
#pragma once

#include <concepts>

#include "sim/scenario/options.h"
#include "sim/scenario/value.h"
#include "walking/keys.h"

namespace sim::scenario {

// The lists in a scenario. Each item, such as `- stand: {duration_s: 1}`, is of one of a fixed set of kinds.
// A kind has kName and keys. Its problem(), if any, returns what is wrong with an item as a whole. If it
// has a member `list`, its value in the file is a list, which is stored there.

template <class Item>
concept ListItem = std::same_as<Item, walking::Command> || std::same_as<Item, sensor_errors::Fault> ||
    std::same_as<Item, physics::Push> || std::same_as<Item, physics::FloorPatch> ||
    std::same_as<Item, physics::Actor> || std::same_as<Item, rig::Item> || std::same_as<Item, Session>;

/// The operations on these lists. read() replaces the list and throws ConfigError at the item or field that
/// is wrong. print() writes one item per line.
template <ListItem Item>
struct ListOperations {
  static std::string expected(const Domain&);
  static void read(const Yaml& node, std::string_view key, const Domain&, void* items);
  static std::string print(const Domain&, const void* items);
};
template <ListItem Item>
inline constexpr ValueType kValueType<std::vector<Item>>{
    ListOperations<Item>::expected, ListOperations<Item>::read, ListOperations<Item>::print};

/// One line for each kind of item of a list and each of its fields, for help.
template <ListItem Item>
std::string describe();

/// A value that can be set in an owner, the options object passed to keys_of(). The member's initializer
/// is its default, and the end of its name is its unit.
struct Key {
  /// A step from an object to one of its members, or to the content of an optional one.
  struct Step {
    std::ptrdiff_t offset;
    void* (*content)(void* optional) = nullptr;
  };

  std::string name;      ///< dotted: "walk.step_length_m"
  std::string doc;       ///< meaning of the key
  std::string expected;  ///< "a number from 0.01 to 0.4"
  Domain domain;
  const ValueType* type;
  std::vector<Step> place;  ///< path from the owner to the value

  /// Throws ConfigError.
  template <class Owner>
  void read(const Yaml& node, Owner& owner) const {
    read_in(&owner, node);
  }
  /// Prints the value as YAML. Lists may span lines.
  template <class Owner>
  std::string print(const Owner& owner) const {
    return print_in(&owner);
  }
  // The same for an owner of unknown type.
  void read_in(void* owner, const Yaml& node) const;
  std::string print_in(const void* owner) const;
};

/// The part of KeyCollector that does not depend on the options. As templates it would take a third of this
/// folder's compile time.
class KeyList : public walking::KeyVisitor {
 protected:
  KeyList(std::string prefix, std::vector<Key::Step> place, std::vector<Key>& keys)
      : prefix_(std::move(prefix)), place_(std::move(place)), keys_(keys) {}
  void add(std::string_view name, std::ptrdiff_t offset, const Domain& domain, std::string_view doc,
           const ValueType& type) const;
  std::vector<Key::Step> below(const Key::Step& step) const;

  std::string prefix_;
  std::vector<Key::Step> place_;
  std::vector<Key>& keys_;
};

/// A visitor that creates the Keys of an options struct and of its parts.
template <class Options>
class KeyCollector : public KeyList {
 public:
  /// prefix: start of all names. place: path from the owner to the Options.
  KeyCollector(std::string prefix, std::vector<Key::Step> place, std::vector<Key>& keys)
      : KeyList(std::move(prefix), std::move(place), keys) {}

  template <class Value, class Class>
  void number(std::string_view name, Value Class::*member, double lowest, double highest,
              std::string_view doc) const {
    add(name, offset(member), {lowest, highest}, doc, kValueType<Value>);
  }
  template <class Value, class Class>
  void choice(std::string_view name, Value Class::*member, std::span<const std::string_view> words,
              std::string_view doc) const {
    add(name, offset(member), {0, 0, words}, doc, kValueType<Value>);
  }
  template <class Value, class Class>
  void value(std::string_view name, Value Class::*member, std::string_view doc) const {
    add(name, offset(member), {}, doc, kValueType<Value>);
  }
  void degrees(std::string_view name, double Options::*member, double lowest, double highest,
               std::string_view doc) const {
    add(name, offset(member), {lowest, highest}, doc, kDegrees);
  }
  template <class Part, class Class>
  void part(std::string_view name, Part Class::*member) const {
    const std::string prefix = prefix_ + std::string(name) + ".";
    if constexpr (requires(Part part) { part.has_value(); }) {
      using Content = typename Part::value_type;
      const auto content = [](void* part) -> void* { return &**static_cast<Part*>(part); };
      Content::keys(KeyCollector<Content>(prefix, below({offset(member), content}), keys_));
    } else {
      Part::keys(KeyCollector<Part>(prefix, below({offset(member)}), keys_));
    }
  }

 private:
  template <class Value, class Class>
  static std::ptrdiff_t offset(Value Class::*member) {
    static const Options sample{};
    return reinterpret_cast<const char*>(&(sample.*member)) - reinterpret_cast<const char*>(&sample);
  }
};

/// All keys of options that have `keys`.
template <class Options>
std::vector<Key> keys_of() {
  std::vector<Key> keys;
  Options::keys(KeyCollector<Options>("", {}, keys));
  return keys;
}

/// Returns all keys except limits.<metric>, each section's together, in the order of help and of to_yaml.
const std::vector<Key>& scenario_keys();

/// The key of that name, or nullptr.
const Key* find_key(std::string_view name);

/// Returns the error for a name that is not a key, with the nearest key or section.
std::string unknown_key(const std::string& name);

/// The default scenario with all optional sections, the source of defaults.
const Scenario& default_scenario();

/// Returns whether the scenario has the section ("camera") of the key.
bool has_section(const Scenario& scenario, std::string_view key);

/// Returns whether a key affects what ideal sensors record, as the seed does: walk, stabilizer, world,
/// camera.
bool shapes_recording(std::string_view key);

/// Returns whether a key affects a filter's estimates: keys below errors and slam, `estimator`, keys below
/// estimator.time, and `sessions`.
bool shapes_estimate(std::string_view key);

/// Returns whether a key affects that scenario's recording; if the estimate steers, shapes_estimate() counts
/// too.
bool shapes_recording(const Scenario& scenario, std::string_view key);

/// Returns the unit in a key's name, such as "m" for "walk.step_length_m", if any.
std::optional<std::string> unit_of(std::string_view key);

/// A hash (32 hexadecimal digits) of the names and contents of the models' files. Throws FileError.
std::string models_hash(const fs::path& models);

/// Returns a hash (32 hexadecimal digits) of the keys that affect a scenario's recording (shapes_recording),
/// its seed, whether it has a camera, the models, and `program`, which distinguishes programs that record
/// different bits.
std::string recording_key(const Scenario& scenario, const std::string& models, const std::string& program);

/// A key that affects recordings and has changed, with its recorded and its current value ("left out" if its
/// section is missing).
struct RecordingDifference {
  std::string key, recorded, now;
};
/// Returns the first key accepted by `counts` whose value in `scenario` differs from the recorded one.
std::optional<RecordingDifference> first_difference(const Scenario& recorded, const Scenario& scenario,
                                                    bool (*counts)(std::string_view) = shapes_recording);

/// Returns why a replay with this scenario, which has slam, would have steered a walk other than the recorded
/// one: an estimate steered that walk, and the estimate is now different. Returns nothing otherwise.
std::optional<std::string> counterfactual(const Scenario& recorded, const Scenario& scenario);

// Limits on metrics: `ate_se3_rmse_m: {at_most: 0.1}`, `ate_se3_rmse_m.median: {at_most: 0.05}`.

/// Returns the error for an unknown metric, with the nearest one.
std::string unknown_metric(std::string_view name);

/// Reads limits.<metric>[.<aggregate>].<bound> (the key), which replaces an earlier one. Throws ConfigError.
void read_limit(const Yaml& at, const std::string& key, const Yaml& value, std::vector<MetricLimit>& limits);

/// Returns whether the value satisfies the limit.
bool keeps(const MetricLimit& limit, double value);

/// Returns "ate_se3_rmse_m.median".
std::string subject(const MetricLimit& limit);
/// Returns "at_most" or "at_least".
std::string_view word(Bound bound);

}  // namespace sim::scenario
