// Keys, made from the functions `keys` of options structs.
#pragma once

#include <cassert>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <typeinfo>
#include <utility>
#include <vector>

#include "sim/scenario/value.h"
#include "walking/keys.h"

namespace sim::scenario {

/// A value that can be set in options, its owner. The member's initializer is its default, its name ends in
/// its unit.
class Key {
 public:
  /// find(owner): the value in it.
  Key(std::string key_name, std::string meaning, const Domain& domain, const ValueType& type,
      std::function<void*(void*)> find, const std::type_info& owner)
      : name(std::move(key_name)),
        expected(type.expected(domain)),
        doc(std::move(meaning)),
        domain_(domain),
        type_(&type),
        find_(std::move(find)),
        owner_(&owner) {}

  std::string name;      ///< dotted: "walk.step_length_m"
  std::string expected;  ///< "a number from 0.01 to 0.4"
  std::string doc;       ///< what the key means

  /// Throws ConfigError.
  template <class Owner>
  void read(const Yaml& node, Owner& owner) const {
    assert(typeid(Owner) == *owner_);
    read_in(node, &owner);
  }
  /// Prints the value as YAML; lists may break lines.
  template <class Owner>
  std::string print(const Owner& owner) const {
    assert(typeid(Owner) == *owner_);
    return print_in(&owner);
  }

  /// The same for an owner of the key's own type.
  void read_in(const Yaml& node, void* owner) const { type_->read(node, name, domain_, find_(owner)); }
  std::string print_in(const void* owner) const {
    return type_->print(domain_, find_(const_cast<void*>(owner)));  // NOLINT: print changes nothing
  }

 private:
  Domain domain_;
  const ValueType* type_;
  std::function<void*(void*)> find_;
  const std::type_info* owner_;
};

template <class Part>
Part& present(Part& part) {
  return part;
}
template <class Part>
Part& present(std::optional<Part>& part) {
  return *part;
}

/// Visitor that makes the Keys of an options struct and of its parts.
template <class Options>
class KeyCollector : public walking::KeyVisitor {
 public:
  /// prefix: of all names; find(owner): the Options in it.
  KeyCollector(std::string prefix, std::function<void*(void*)> find, const std::type_info& owner,
               std::vector<Key>& keys)
      : prefix_(std::move(prefix)), find_(std::move(find)), owner_(owner), keys_(keys) {}

  void number(std::string_view name, auto member, double lowest, double highest, std::string_view doc) const {
    add(name, member, {lowest, highest}, doc);
  }
  void choice(std::string_view name, auto member, std::span<const std::string_view> words,
              std::string_view doc) const {
    add(name, member, {0, 0, words}, doc);
  }
  void value(std::string_view name, auto member, std::string_view doc) const { add(name, member, {}, doc); }
  void degrees(std::string_view name, auto member, double lowest, double highest,
               std::string_view doc) const {
    keys_.emplace_back(prefix_ + std::string(name), std::string(doc), Domain{lowest, highest}, kDegrees,
                       below(member), owner_);
  }
  template <class Part, class Class>
  void part(std::string_view name, Part Class::*member) const {
    using Present = std::remove_reference_t<decltype(present(std::declval<Part&>()))>;
    Present::keys(KeyCollector<Present>(prefix_ + std::string(name) + ".", below(member), owner_, keys_));
  }

 private:
  template <class Value, class Class>
  std::function<void*(void*)> below(Value Class::*member) const {
    return [find = find_, member](void* owner) -> void* {
      return &present(static_cast<Options*>(find(owner))->*member);
    };
  }
  template <class Value, class Class>
  void add(std::string_view name, Value Class::*member, const Domain& domain, std::string_view doc) const {
    keys_.emplace_back(prefix_ + std::string(name), std::string(doc), domain, kValueType<Value>,
                       below(member), owner_);
  }

  std::string prefix_;
  std::function<void*(void*)> find_;
  const std::type_info& owner_;
  std::vector<Key>& keys_;
};

/// All keys of options that have `keys`.
template <class Options>
std::vector<Key> keys_of() {
  std::vector<Key> keys;
  Options::keys(KeyCollector<Options>(
      "", [](void* owner) { return owner; }, typeid(Options), keys));
  return keys;
}

}  // namespace sim::scenario
