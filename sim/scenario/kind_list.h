// Lists in a scenario whose items are each of one kind of a closed set: `- stand: {duration_s: 1}`.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "sim/scenario/key.h"

namespace sim::scenario {

/// What a kind of item has fields for: itself; or, when its value in the file is a list, an entry of that.
template <class Kind>
struct Entry {
  using Type = Kind;
};
template <class Kind>
requires requires(Kind kind) { kind.list; }
struct Entry<Kind> {
  using Type = typename decltype(Kind::list)::value_type;
};

/// A kind of item: its word in the file and its fields.
template <class Kind>
struct Grammar {
  std::string_view word = Kind::kName;
  std::vector<Key<typename Entry<Kind>::Type>> fields = keys_of<typename Entry<Kind>::Type>();
};

/// The grammars of an item's kinds: those of a variant's alternatives, or of the item itself.
template <class Item>
struct Grammars {
  using Type = std::tuple<Grammar<Item>>;
};
template <class... Kinds>
struct Grammars<std::variant<Kinds...>> {
  using Type = std::tuple<Grammar<Kinds>...>;
};

/// How a list of Items is written. A kind has kName and keys, and may have problem(), which says what is
/// wrong with an item as a whole. noun: what an item is called in messages; example: a whole item as YAML,
/// without the dash; least: how many items there must be.
template <class Item>
class KindList {
 public:
  KindList(std::string noun, std::string example, std::size_t least = 0)
      : noun_(std::move(noun)), example_(std::move(example)), least_(least) {}

  /// "a list of commands"
  std::string expected() const { return fmt::format("a list of {}s", noun_); }

  /// Reads the whole list. Throws ConfigError at the item or field that is wrong.
  void read(const Yaml& node, std::string_view key, std::vector<Item>& items) const {
    if (node.kind != Yaml::Kind::list || node.items.size() < least_)
      fail(node, key, fmt::format("expected {}, as in [{{{}}}]", expected(), example_));
    std::vector<Item> all;
    for (const Yaml& item : node.items) all.push_back(read_item(item, key));
    items = std::move(all);
  }

  /// As YAML, one item to a line.
  std::string print(const std::vector<Item>& items) const {
    if (items.empty()) return "[]";
    std::vector<std::string> lines;
    for (const Item& item : items) lines.push_back(print_item(item));
    return fmt::format("[\n    {}]", fmt::join(lines, ",\n    "));
  }

  /// One line for each kind and each of its fields, for help.
  std::string describe() const {
    std::string text;
    for_each_kind([&](const auto& grammar) {
      for (const auto& field : grammar.fields)
        text += fmt::format("  {:22} {:12} {}, {}; default {}\n", grammar.word, field.name, field.doc,
                            field.expected, field.print({}));
    });
    return text;
  }

 private:
  /// Calls f(grammar) for each kind.
  template <class F>
  void for_each_kind(const F& f) const {
    std::apply([&](const auto&... grammar) { (f(grammar), ...); }, grammars_);
  }

  std::vector<std::string_view> words() const {
    std::vector<std::string_view> all;
    for_each_kind([&](const auto& grammar) { all.push_back(grammar.word); });
    return all;
  }

  template <class Owner>
  void read_field(const Yaml& name, const Yaml& value, const std::string& where,
                  const std::vector<Key<Owner>>& fields, Owner& owner) const {
    std::vector<std::string_view> known;
    for (const Key<Owner>& field : fields) {
      if (field.name == name.text) return field.read(value, owner);
      known.push_back(field.name);
    }
    fail(name, where,
         fmt::format("unknown field '{}', expected {}{}", name.text, fmt::join(known, ", "),
                     did_you_mean(name.text, known)));
  }

  template <class Owner>
  void read_fields(const Yaml& node, const std::string& where, const std::vector<Key<Owner>>& fields,
                   Owner& owner) const {
    if (node.kind != Yaml::Kind::map)
      fail(node, where,
           fmt::format("expected fields in braces, as in {}", example_.substr(example_.find('{'))));
    for (std::size_t i = 0; i < node.keys.size(); ++i)
      read_field(node.keys[i], node.items[i], where, fields, owner);
  }

  template <class Kind>
  Item read_kind(const Yaml& node, const std::string& where, const Grammar<Kind>& grammar) const {
    Kind item;
    if constexpr (std::is_same_v<Kind, typename Entry<Kind>::Type>) {
      read_fields(node, where, grammar.fields, item);
    } else {
      if (node.kind != Yaml::Kind::list || node.items.empty())
        fail(
            node, where,
            fmt::format("expected a list of {}, as in [{}]", grammar.word, print_fields(grammar.fields, {})));
      for (const Yaml& entry : node.items)
        read_fields(entry, where, grammar.fields, item.list.emplace_back());
    }
    if constexpr (requires { item.problem(); })
      if (!item.problem().empty()) fail(node, where, item.problem());
    return item;
  }

  Item read_item(const Yaml& node, std::string_view key) const {
    if (node.kind != Yaml::Kind::map || node.keys.size() != 1)
      fail(node, key,
           fmt::format("expected {}, each one of {}, as in - {}", expected(), fmt::join(words(), ", "),
                       example_));
    const Yaml& word = node.keys[0];
    std::optional<Item> item;
    for_each_kind([&](const auto& grammar) {
      if (grammar.word == word.text)
        item = read_kind(node.items[0], fmt::format("{}: {}", key, word.text), grammar);
    });
    if (!item)
      fail(word, key,
           fmt::format("unknown {} '{}', expected one of {}{}", noun_, word.text, fmt::join(words(), ", "),
                       did_you_mean(word.text, words())));
    return *item;
  }

  template <class Owner>
  std::string print_fields(const std::vector<Key<Owner>>& fields, const Owner& owner) const {
    std::vector<std::string> all;
    for (const auto& field : fields) all.push_back(fmt::format("{}: {}", field.name, field.print(owner)));
    return fmt::format("{{{}}}", fmt::join(all, ", "));
  }

  template <class Kind>
  std::string print_kind(const Grammar<Kind>& grammar, const Kind& item) const {
    if constexpr (std::is_same_v<Kind, typename Entry<Kind>::Type>) {
      return print_fields(grammar.fields, item);
    } else {
      std::vector<std::string> entries;
      for (const auto& entry : item.list) entries.push_back(print_fields(grammar.fields, entry));
      return fmt::format("[{}]", fmt::join(entries, ", "));
    }
  }

  std::string print_item(const Item& item) const {
    const auto written = [this]<class Kind>(const Kind& kind) {
      const auto& grammar = std::get<Grammar<Kind>>(grammars_);
      return fmt::format("{{{}: {}}}", grammar.word, print_kind(grammar, kind));
    };
    if constexpr (requires { item.index(); }) {
      return std::visit(written, item);
    } else {
      return written(item);
    }
  }

  std::string noun_, example_;
  std::size_t least_;
  typename Grammars<Item>::Type grammars_;
};

}  // namespace sim::scenario
