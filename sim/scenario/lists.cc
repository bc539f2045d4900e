#include "sim/scenario/lists.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <variant>

namespace sim::scenario {
namespace {

template <class List>
inline constexpr ListAccess kListAccess{
    [](const void* list) { return static_cast<const List*>(list)->size(); },
    [](const void* list, std::size_t i) -> const void* { return &(*static_cast<const List*>(list))[i]; },
    [](void* list) -> void* { return &static_cast<List*>(list)->emplace_back(); }};

/// The owner of a kind's fields: itself; or, if its value in the file is a list, an entry of it.
template <class Kind>
struct Entry {
  using Type = Kind;
  static constexpr const ListAccess* kList = nullptr;
  static void* of(Kind& kind) { return &kind; }
};
template <class Kind>
requires requires(Kind kind) { kind.list; }
struct Entry<Kind> {
  using Type = typename decltype(Kind::list)::value_type;
  static constexpr const ListAccess* kList = &kListAccess<decltype(Kind::list)>;
  static void* of(Kind& kind) { return &kind.list; }
};

template <class Kind>
std::string_view problem_of(const void* value) {
  if constexpr (requires(const Kind& kind) { kind.problem(); })
    return static_cast<const Kind*>(value)->problem();
  return "";
}

template <class Kind>
ItemKind kind_of(void* (*start)(void*), const void* (*find)(const void*)) {
  using Fields = typename Entry<Kind>::Type;
  static const Fields defaults{};
  return {Kind::kName, keys_of<Fields>(), &defaults, start, find, problem_of<Kind>, Entry<Kind>::kList};
}

/// The kinds of an item: those of a variant's alternatives, or the item itself.
template <class Kind>
struct Kinds {
  static std::vector<ItemKind> all() {
    return {kind_of<Kind>([](void* item) { return item; }, [](const void* item) { return item; })};
  }
};
template <class... Alternatives>
struct Kinds<std::variant<Alternatives...>> {
  using Item = std::variant<Alternatives...>;
  static std::vector<ItemKind> all() { return {alternative<Alternatives>()...}; }
  template <class Kind>
  static ItemKind alternative() {
    return kind_of<Kind>(
        [](void* item) { return Entry<Kind>::of(static_cast<Item*>(item)->template emplace<Kind>()); },
        [](const void* item) -> const void* {
          auto* kind = std::get_if<Kind>(const_cast<Item*>(static_cast<const Item*>(item)));  // NOLINT
          return kind == nullptr ? nullptr : Entry<Kind>::of(*kind);
        });
  }
};

template <class Item>
KindList list_of(std::string noun, std::string example, std::size_t least = 0) {
  return {std::move(noun), std::move(example), least, Kinds<Item>::all(), kListAccess<std::vector<Item>>};
}

std::string print_fields(const std::vector<Key>& fields, const void* owner) {
  std::vector<std::string> all;
  for (const Key& field : fields) all.push_back(fmt::format("{}: {}", field.name, field.print_in(owner)));
  return fmt::format("{{{}}}", fmt::join(all, ", "));
}

void read_field(const Yaml& name, const Yaml& value, const std::string& where, const std::vector<Key>& fields,
                void* owner) {
  std::vector<std::string_view> known;
  for (const Key& field : fields) {
    if (field.name == name.text) return field.read_in(value, owner);
    known.push_back(field.name);
  }
  fail(name, where,
       fmt::format("unknown field '{}', expected {}{}", name.text, fmt::join(known, ", "),
                   did_you_mean(name.text, known)));
}

std::string print_kind(const ItemKind& kind, const void* value) {
  if (kind.entries == nullptr) return print_fields(kind.fields, value);
  std::vector<std::string> entries;
  for (std::size_t i = 0; i < kind.entries->size(value); ++i)
    entries.push_back(print_fields(kind.fields, kind.entries->at(value, i)));
  return fmt::format("[{}]", fmt::join(entries, ", "));
}

}  // namespace

KindList::KindList(std::string noun, std::string example, std::size_t least, std::vector<ItemKind> kinds,
                   const ListAccess& items)
    : noun_(std::move(noun)),
      example_(std::move(example)),
      least_(least),
      kinds_(std::move(kinds)),
      items_(items) {
  for (const ItemKind& kind : kinds_) words_.push_back(kind.word);
}

std::string KindList::expected() const { return fmt::format("a list of {}s", noun_); }

void KindList::read(const Yaml& node, std::string_view key, void* items) const {
  if (node.kind != Yaml::Kind::list || node.items.size() < least_)
    fail(node, key, fmt::format("expected {}, as in [{{{}}}]", expected(), example_));
  for (const Yaml& item : node.items) read_item(item, key, items_.append(items));
}

void KindList::read_item(const Yaml& node, std::string_view key, void* item) const {
  if (node.kind != Yaml::Kind::map || node.keys.size() != 1)
    fail(node, key,
         fmt::format("expected {}, each one of {}, as in - {}", expected(), fmt::join(words_, ", "),
                     example_));
  const Yaml& word = node.keys[0];
  const auto kind =
      std::find_if(kinds_.begin(), kinds_.end(), [&](const ItemKind& k) { return k.word == word.text; });
  if (kind == kinds_.end())
    fail(word, key,
         fmt::format("unknown {} '{}', expected one of {}{}", noun_, word.text, fmt::join(words_, ", "),
                     did_you_mean(word.text, words_)));
  read_kind(node.items[0], fmt::format("{}: {}", key, word.text), *kind, kind->start(item));
}

void KindList::read_kind(const Yaml& node, const std::string& where, const ItemKind& kind,
                         void* value) const {
  if (kind.entries == nullptr) {
    read_fields(node, where, kind, value);
  } else {
    if (node.kind != Yaml::Kind::list || node.items.empty())
      fail(node, where,
           fmt::format("expected a list of {}, as in [{}]", kind.word,
                       print_fields(kind.fields, kind.defaults)));
    for (const Yaml& entry : node.items) read_fields(entry, where, kind, kind.entries->append(value));
  }
  if (const std::string_view problem = kind.problem(value); !problem.empty()) fail(node, where, problem);
}

void KindList::read_fields(const Yaml& node, const std::string& where, const ItemKind& kind,
                           void* owner) const {
  if (node.kind != Yaml::Kind::map)
    fail(node, where,
         fmt::format("expected fields in braces, as in {}", example_.substr(example_.find('{'))));
  for (std::size_t i = 0; i < node.keys.size(); ++i)
    read_field(node.keys[i], node.items[i], where, kind.fields, owner);
}

std::string KindList::print(const void* items) const {
  if (items_.size(items) == 0) return "[]";
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < items_.size(items); ++i) lines.push_back(print_item(items_.at(items, i)));
  return fmt::format("[\n    {}]", fmt::join(lines, ",\n    "));
}

std::string KindList::print_item(const void* item) const {
  for (const ItemKind& kind : kinds_)
    if (const void* const value = kind.find(item))
      return fmt::format("{{{}: {}}}", kind.word, print_kind(kind, value));
  return "";
}

std::string KindList::describe() const {
  std::string text;
  for (const ItemKind& kind : kinds_)
    for (const Key& field : kind.fields)
      text += fmt::format("  {:22} {:12} {}, {}; default {}\n", kind.word, field.name, field.doc,
                          field.expected, field.print_in(kind.defaults));
  return text;
}

const KindList& grammar_of(const std::vector<walking::Command>&) {
  static const KindList list = list_of<walking::Command>("command", "stand: {duration_s: 1}", 1);
  return list;
}
const KindList& grammar_of(const std::vector<sensor_errors::Fault>&) {
  static const KindList list =
      list_of<sensor_errors::Fault>("fault", "frames_lost: {from_s: 20, duration_s: 2}");
  return list;
}
const KindList& grammar_of(const std::vector<physics::Push>&) {
  static const KindList list =
      list_of<physics::Push>("disturbance", "push: {time_s: 4, impulse_ns: 10, direction_deg: 90}");
  return list;
}
const KindList& grammar_of(const std::vector<physics::FloorPatch>&) {
  static const KindList list = list_of<physics::FloorPatch>(
      "disturbance", "patch: {x_min_m: 1, x_max_m: 2, y_min_m: -1, y_max_m: 1, friction: 0.1}");
  return list;
}

std::string describe_commands() { return grammar_of(std::vector<walking::Command>()).describe(); }
std::string describe_faults() { return grammar_of(std::vector<sensor_errors::Fault>()).describe(); }
std::string describe_disturbances() {
  return grammar_of(std::vector<physics::Push>()).describe() +
         grammar_of(std::vector<physics::FloorPatch>()).describe();
}

}  // namespace sim::scenario
