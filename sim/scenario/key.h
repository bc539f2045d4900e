// Keys of a scenario, made from what stands beside the options that they set.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "sim/scenario/value.h"

namespace sim::scenario {

/// One thing that can be set in an Owner. Its default is the member's initializer, its unit is in its name.
template <class Owner>
struct Key {
  std::string name;                                ///< dotted: "walk.step_length_m"
  std::string expected;                            ///< "a number from 0.01 to 0.4"
  std::string doc;                                 ///< what the key means
  std::function<void(const Yaml&, Owner&)> read;   ///< throws ConfigError
  std::function<std::string(const Owner&)> print;  ///< as YAML; lists may break lines
};

template <class Part>
auto& present(Part& part) {
  return part;
}
template <class Part>
auto& present(std::optional<Part>& part) {
  return *part;
}
template <class Part>
auto& present(const std::optional<Part>& part) {
  return *part;
}

/// The visitor of an options struct's `keys` that makes the Keys of an Owner which has those options.
/// access(owner): the options.
template <class Owner, class Access>
class KeyCollector {
 public:
  KeyCollector(std::string prefix, Access access, std::vector<Key<Owner>>& keys)
      : prefix_(std::move(prefix)), access_(access), keys_(keys) {}

  /// A number, or a list of numbers, within a range.
  void number(std::string_view name, auto member, double lowest, double highest, std::string_view doc) const {
    add(name, member, {lowest, highest}, doc);
  }
  /// An enumerator, a word or a list of words, each of those given.
  void choice(std::string_view name, auto member, std::span<const std::string_view> words,
              std::string_view doc) const {
    add(name, member, {0, 0, words}, doc);
  }
  /// A switch, a whole number without sign, a name or a list of items.
  void value(std::string_view name, auto member, std::string_view doc) const { add(name, member, {}, doc); }

  /// An angle: degrees in the file, radians in the member.
  void degrees(std::string_view name, auto member, double lowest, double highest,
               std::string_view doc) const {
    const Domain domain{lowest, highest};
    const auto at = below(member);
    const std::string key = prefix_ + std::string(name);
    keys_.push_back({key, expected(domain, lowest), std::string(doc),
                     [=](const Yaml& node, Owner& owner) {
                       double angle = 0;
                       read(node, key, domain, angle);
                       at(owner) = to_radians(angle);
                     },
                     [=](const Owner& owner) { return print(domain, to_degrees(at(owner))); }});
  }

  /// A struct of options with `keys` of its own, or an optional one.
  void part(std::string_view name, auto member) const {
    const auto at = below(member);
    using Part = std::remove_cvref_t<decltype(at(std::declval<Owner&>()))>;
    Part::keys(KeyCollector<Owner, decltype(at)>(prefix_ + std::string(name) + ".", at, keys_));
  }

 private:
  auto below(auto member) const {
    return [ access = access_, member ](auto& owner) -> auto& { return present(access(owner).*member); };
  }

  void add(std::string_view name, auto member, const Domain& domain, std::string_view doc) const {
    const auto at = below(member);
    const std::string key = prefix_ + std::string(name);
    const std::remove_cvref_t<decltype(at(std::declval<Owner&>()))> any{};
    keys_.push_back({key, expected(domain, any), std::string(doc),
                     [=](const Yaml& node, Owner& owner) { read(node, key, domain, at(owner)); },
                     [=](const Owner& owner) { return print(domain, at(owner)); }});
  }

  std::string prefix_;
  Access access_;
  std::vector<Key<Owner>>& keys_;
};

/// All keys of options that have `keys`.
template <class Options>
std::vector<Key<Options>> keys_of() {
  const auto itself = [](auto& options) -> auto& { return options; };
  std::vector<Key<Options>> keys;
  Options::keys(KeyCollector<Options, decltype(itself)>("", itself, keys));
  return keys;
}

}  // namespace sim::scenario
