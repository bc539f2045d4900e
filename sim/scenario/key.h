// A key of the scenario. Its line is in the function `keys` of the options struct that owns it.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "sim/scenario/value.h"
#include "walking/keys.h"

namespace sim::scenario {

/// A value that can be set in options, its owner: those that keys_of() was asked for. The member's
/// initializer is its default, its name ends in its unit.
struct Key {
  std::string name;      ///< dotted: "walk.step_length_m"
  std::string doc;       ///< what the key means
  std::string expected;  ///< "a number from 0.01 to 0.4"
  Domain domain;
  const ValueType* type;
  std::function<void*(void*)> find;  ///< the value in the owner

  /// Throws ConfigError.
  template <class Owner>
  void read(const Yaml& node, Owner& owner) const {
    type->read(node, name, domain, find(&owner));
  }
  /// Prints the value as YAML; lists may break lines.
  template <class Owner>
  std::string print(const Owner& owner) const {
    return type->print(domain, find(const_cast<Owner*>(&owner)));  // NOLINT: print changes nothing
  }
};

/// Visitor that makes the Keys of an options struct and of its parts.
template <class Options>
class KeyCollector : public walking::KeyVisitor {
 public:
  /// prefix: of all names; find(owner): the Options in it.
  KeyCollector(std::string prefix, std::function<void*(void*)> find, std::vector<Key>& keys)
      : prefix_(std::move(prefix)), find_(std::move(find)), keys_(keys) {}

  void number(std::string_view name, auto member, double lowest, double highest, std::string_view doc) const {
    add(name, member, {lowest, highest}, doc);
  }
  void choice(std::string_view name, auto member, std::span<const std::string_view> words,
              std::string_view doc) const {
    add(name, member, {0, 0, words}, doc);
  }
  void value(std::string_view name, auto member, std::string_view doc) const { add(name, member, {}, doc); }
  void degrees(std::string_view name, double Options::*member, double lowest, double highest,
               std::string_view doc) const {
    add(name, member, {lowest, highest}, doc, kDegrees);
  }
  template <class Part, class Class>
  void part(std::string_view name, Part Class::*member) const {
    using Present = std::remove_pointer_t<decltype(present(std::declval<Part&>()))>;
    Present::keys(KeyCollector<Present>(prefix_ + std::string(name) + ".", below(member), keys_));
  }

 private:
  /// The part, also of an optional one.
  static auto* present(auto& part) {
    if constexpr (requires { part.has_value(); }) {
      return &*part;
    } else {
      return &part;
    }
  }
  template <class Value, class Class>
  std::function<void*(void*)> below(Value Class::*member) const {
    return [find = find_, member](void* owner) -> void* {
      return present(static_cast<Options*>(find(owner))->*member);
    };
  }
  template <class Value, class Class>
  void add(std::string_view name, Value Class::*member, const Domain& domain, std::string_view doc,
           const ValueType& type = kValueType<Value>) const {
    keys_.push_back(
        {prefix_ + std::string(name), std::string(doc), type.expected(domain), domain, &type, below(member)});
  }

  std::string prefix_;
  std::function<void*(void*)> find_;
  std::vector<Key>& keys_;
};

/// All keys of options that have `keys`.
template <class Options>
std::vector<Key> keys_of() {
  std::vector<Key> keys;
  Options::keys(KeyCollector<Options>(
      "", [](void* owner) { return owner; }, keys));
  return keys;
}

}  // namespace sim::scenario
