// The table of keys for reading, overrides, help, printing, sweeps and tuning.
#pragma once

#include <concepts>
#include <type_traits>

#include "sim/scenario/options.h"
#include "sim/scenario/value.h"
#include "walking/keys.h"

namespace sim::scenario {

// The lists of a scenario, of items such as `- stand: {duration_s: 1}`, each of one kind of a closed set. A
// kind has kName and keys; problem(), if it exists, returns what is wrong with an item as a whole, and `list`
// is its value if that is a list in the file.

template <class Item>
concept ListItem = std::same_as<Item, walking::Command> || std::same_as<Item, sensor_errors::Fault> ||
    std::same_as<Item, physics::Push> || std::same_as<Item, physics::FloorPatch> ||
    std::same_as<Item, rig::Item>;

/// The operations on these lists. read() replaces the list and throws ConfigError at the item or field that
/// is wrong; print() writes one item to a line.
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

/// A value that can be set in options, its owner: those that keys_of() was asked for. The member's
/// initializer is its default, its name ends in its unit.
struct Key {
  /// A step from an object to its member, or to the content of an optional one.
  struct Step {
    std::ptrdiff_t offset;
    void* (*content)(void* optional) = nullptr;
  };

  std::string name;      ///< dotted: "walk.step_length_m"
  std::string doc;       ///< what the key means
  std::string expected;  ///< "a number from 0.01 to 0.4"
  Domain domain;
  const ValueType* type;
  std::vector<Step> place;  ///< of the value in the owner

  /// Throws ConfigError.
  template <class Owner>
  void read(const Yaml& node, Owner& owner) const {
    read_in(&owner, node);
  }
  /// Prints the value as YAML; lists may break lines.
  template <class Owner>
  std::string print(const Owner& owner) const {
    return print_in(&owner);
  }
  // The same for an owner of unknown type.
  void read_in(void* owner, const Yaml& node) const;
  std::string print_in(const void* owner) const;
};

/// The part of KeyCollector that does not depend on the options; as templates it would take a third of this
/// folder's compilation.
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

/// Visitor that makes the Keys of an options struct and of its parts.
template <class Options>
class KeyCollector : public KeyList {
 public:
  /// prefix: of all names; place: of the Options in the owner.
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

/// All keys but limits.<metric>, sections together, in the order of help and of to_yaml.
const std::vector<Key>& scenario_keys();

/// The key of that name, or nullptr.
const Key* find_key(std::string_view name);

/// Returns the error for a name that is not a key, with the nearest key.
std::string unknown_key(std::string_view name);

/// The default scenario with all optional sections, the source of defaults.
const Scenario& default_scenario();

/// True if the scenario has the section ("camera") of the key.
bool has_section(const Scenario& scenario, std::string_view key);

/// True for a key that shapes what ideal sensors record, as does the seed: walk, stabilizer, world, camera.
bool shapes_recording(std::string_view key);

/// True for a key that shapes the estimates of a filter: below errors or slam, `estimator`, and below
/// estimator.time.
bool shapes_estimate(std::string_view key);

/// True for a key that shapes that scenario's recording; if the estimate steers, shapes_estimate() too.
bool shapes_recording(const Scenario& scenario, std::string_view key);

/// Returns the unit in a key's name, "m" for "walk.step_length_m", if it has one.
std::optional<std::string> unit_of(std::string_view key);

/// A hash (32 hexadecimal digits) of the names and contents of the models' files. Throws FileError.
std::string models_hash(const std::filesystem::path& models);

/// A hash (32 hexadecimal digits) of the keys that shape a scenario's recording (shapes_recording), its seed,
/// whether it has a camera, the models, and `program`, which stands for programs that record other bits.
std::string recording_key(const Scenario& scenario, const std::string& models, const std::string& program);

/// A key that shapes recordings and differs, with its value there and now ("left out" without its section).
struct RecordingDifference {
  std::string key, recorded, now;
};
/// The first key that shapes recordings and has another value in `scenario` than in the recorded one.
std::optional<RecordingDifference> first_difference(const Scenario& recorded, const Scenario& scenario);

/// Why a replay with this scenario, which has slam, would have steered another walk than was recorded: an
/// estimate steered that walk, and now it is another. Nothing otherwise.
std::optional<std::string> counterfactual(const Scenario& recorded, const Scenario& scenario);

// Limits on metrics: `ate_se3_rmse_m: {at_most: 0.1}`, `ate_se3_rmse_m.median: {at_most: 0.05}`.

/// Returns the error for an unknown metric, with the nearest one.
std::string unknown_metric(std::string_view name);

/// Reads limits.<metric>[.<aggregate>].<bound> (the key), replacing an earlier one. Throws ConfigError.
void read_limit(const Yaml& at, const std::string& key, const Yaml& value, std::vector<MetricLimit>& limits);

/// True if the value satisfies the limit.
bool keeps(const MetricLimit& limit, double value);

/// "ate_se3_rmse_m.median"
std::string subject(const MetricLimit& limit);
/// "at_most" or "at_least"
std::string_view word(Bound bound);

}  // namespace sim::scenario
