#include <fmt/ranges.h>

#include "sim/scenario/keys.h"

namespace sim::scenario {
namespace {

/// The name of an item in messages, an example of an item as YAML without the dash, and how many items there
/// must be.
struct Grammar {
  std::string_view noun, example;
  std::size_t least = 0;
};
template <ListItem Item>
constexpr Grammar kGrammar{};
template <>
constexpr Grammar kGrammar<walking::Command>{"command", "stand: {duration_s: 1}", 1};
template <>
constexpr Grammar kGrammar<sensor_errors::Fault>{"fault", "frames_lost: {from_s: 20, duration_s: 2}"};
template <>
constexpr Grammar kGrammar<physics::Push>{"disturbance",
                                          "push: {time_s: 4, impulse_ns: 10, direction_deg: 90}"};
template <>
constexpr Grammar kGrammar<physics::FloorPatch>{
    "disturbance", "patch: {x_min_m: 1, x_max_m: 2, y_min_m: -1, y_max_m: 1, friction: 0.1}"};

template <>
constexpr Grammar kGrammar<physics::Actor>{"actor", "person: {path: [[0, 3, 1], [4, 3, -1]]}"};
template <>
constexpr Grammar kGrammar<Session>{"session", "session: {set: [world.light.level=0.3]}"};
template <>
constexpr Grammar kGrammar<rig::Item>{"sensor", "lidar: {name: lidar0, tilt_deg: 5}"};

/// Calls f<Kind>() for each kind of an item: a variant's alternatives, or the item itself.
template <class Item>
struct Kinds {
  static void each(const auto& f) { f.template operator()<Item>(); }
};
template <class... Kind>
struct Kinds<std::variant<Kind...>> {
  static void each(const auto& f) { (f.template operator()<Kind>(), ...); }
};

/// The owner of a kind's fields: the kind itself or, if its value in the file is a list, an entry of that
/// list.
template <class Kind>
struct Fields {
  using Owner = Kind;
};
template <class Kind>
requires requires(Kind kind) { kind.list; }
struct Fields<Kind> {
  using Owner = typename decltype(Kind::list)::value_type;
};

template <class Owner>
const std::vector<Key>& fields() {
  static const std::vector<Key> all = keys_of<Owner>();
  return all;
}

std::string print_fields(const std::vector<Key>& fields, const void* owner) {
  std::vector<std::string> all;
  for (const Key& field : fields) all.push_back(fmt::format("{}: {}", field.name, field.print_in(owner)));
  return fmt::format("{{{}}}", fmt::join(all, ", "));
}
template <class Owner>
std::string print_fields(const Owner& owner) {
  return print_fields(fields<Owner>(), &owner);
}

void read_fields(const Yaml& node, const std::string& where, std::string_view example,
                 const std::vector<Key>& fields, void* owner) {
  if (!node.is_map())
    fail(node, where, "expected fields in braces, as in {}", example.substr(example.find('{')));
  std::vector<std::string_view> known;
  for (const Key& field : fields) known.push_back(field.name);
  for (const auto& [key, value] : node.entries()) {
    const std::string& name = key.text;
    const auto field = std::ranges::find(known, name);
    if (field == known.end())
      fail(key, where, "unknown field '{}', expected {}{}", name, fmt::join(known, ", "),
           did_you_mean(name, known));
    fields[std::size_t(field - known.begin())].read_in(owner, value);
  }
}
template <class Owner>
void read_fields(const Yaml& node, const std::string& where, std::string_view example, Owner& owner) {
  read_fields(node, where, example, fields<Owner>(), &owner);
}

template <class Kind>
void read_kind(const Yaml& node, const std::string& where, std::string_view example, Kind& kind) {
  if constexpr (requires { kind.list; }) {
    if (!node.is_list() || node.items.empty())
      fail(node, where, "expected a list of {}, as in [{}]", Kind::kName,
           print_fields(typename Fields<Kind>::Owner{}));
    for (const Yaml& entry : node.items) read_fields(entry, where, example, kind.list.emplace_back());
  } else {
    read_fields(node, where, example, kind);
  }
  if constexpr (requires { kind.problem(); })
    if (const std::optional<std::string> problem = kind.problem()) fail(node, where, *problem);
}

template <ListItem Item>
void read_item(const Yaml& node, std::string_view key, Item& item) {
  constexpr Grammar grammar = kGrammar<Item>;
  std::vector<std::string_view> words;
  Kinds<Item>::each([&]<class Kind>() { words.emplace_back(Kind::kName); });
  if (!node.is_map() || node.keys.size() != 1)
    fail(node, key, "expected a list of {}s, each one of {}, as in - {}", grammar.noun,
         fmt::join(words, ", "), grammar.example);
  const std::string& word = node.keys[0].text;
  if (std::ranges::find(words, word) == words.end())
    fail(node.keys[0], key, "unknown {} '{}', expected one of {}{}", grammar.noun, word,
         fmt::join(words, ", "), did_you_mean(word, words));
  Kinds<Item>::each([&]<class Kind>() {
    if (word != Kind::kName) return;
    Kind kind;
    read_kind(node.items[0], fmt::format("{}: {}", key, word), grammar.example, kind);
    item = std::move(kind);
  });
}

template <class Kind>
std::string print_kind(const Kind& kind) {
  if constexpr (requires { kind.list; }) {
    std::vector<std::string> entries;
    for (const auto& entry : kind.list) entries.push_back(print_fields(entry));
    return fmt::format("{{{}: [{}]}}", Kind::kName, fmt::join(entries, ", "));
  } else {
    return fmt::format("{{{}: {}}}", Kind::kName, print_fields(kind));
  }
}
template <class... Kind>
std::string print_kind(const std::variant<Kind...>& item) {
  return std::visit([](const auto& kind) { return print_kind(kind); }, item);
}

std::string describe_fields(std::string_view kind, const std::vector<Key>& fields, const void* owner) {
  std::string text;
  for (const Key& field : fields)
    text += fmt::format("  {:22} {:12} {}, {}; default {}\n", kind, field.name, field.doc, field.expected,
                        field.print_in(owner));
  return text;
}

}  // namespace

template <ListItem Item>
std::string ListOperations<Item>::expected(const Domain&) {
  return fmt::format("a list of {}s", kGrammar<Item>.noun);
}

template <>
std::string ListOperations<rig::Item>::expected(const Domain&) {
  return fmt::format("a preset ({}) or a list of sensors and presets", fmt::join(rig::preset_names(), ", "));
}

template <>
void ListOperations<rig::Item>::read(const Yaml& node, std::string_view key, const Domain& domain,
                                     void* items) {
  if (node.is_map() || node.kind == Yaml::Kind::empty)
    fail(node, key, "expected {}, as in [d435i, {{{}}}]", expected(domain), kGrammar<rig::Item>.example);
  std::vector<rig::Item> all;
  std::vector<const Yaml*> places;
  const auto read_entry = [&](const Yaml& entry) {
    if (!entry.is_scalar()) {
      read_item(entry, key, all.emplace_back());
    } else if (const auto preset = rig::preset(entry.text)) {
      all.insert(all.end(), preset->begin(), preset->end());
    } else {
      fail(entry, key, "no preset '{}', expected one of {}{}", entry.text,
           fmt::join(rig::preset_names(), ", "), did_you_mean(entry.text, rig::preset_names()));
    }
    places.resize(all.size(), &entry);
  };
  if (node.is_scalar()) read_entry(node);
  for (const Yaml& entry : node.items) read_entry(entry);
  if (const auto problem = rig::problem(all)) fail(*places[problem->item], key, problem->what);
  *static_cast<std::vector<rig::Item>*>(items) = std::move(all);
}

template <ListItem Item>
void ListOperations<Item>::read(const Yaml& node, std::string_view key, const Domain& domain, void* items) {
  if (!node.is_list() || node.items.size() < kGrammar<Item>.least)
    fail(node, key, "expected {}, as in [{{{}}}]", expected(domain), kGrammar<Item>.example);
  std::vector<Item> all(node.items.size());
  for (std::size_t i = 0; i < all.size(); ++i) read_item(node.items[i], key, all[i]);
  *static_cast<std::vector<Item>*>(items) = std::move(all);
}

template <ListItem Item>
std::string ListOperations<Item>::print(const Domain&, const void* items) {
  std::vector<std::string> lines;
  for (const Item& item : *static_cast<const std::vector<Item>*>(items)) lines.push_back(print_kind(item));
  return lines.empty() ? "[]" : fmt::format("[\n    {}]", fmt::join(lines, ",\n    "));
}

template <ListItem Item>
std::string describe() {
  std::string text;
  Kinds<Item>::each([&]<class Kind>() {
    using Owner = typename Fields<Kind>::Owner;
    const Owner owner{};
    text += describe_fields(Kind::kName, fields<Owner>(), &owner);
  });
  return text;
}

template struct ListOperations<walking::Command>;
template std::string describe<walking::Command>();
template struct ListOperations<sensor_errors::Fault>;
template std::string describe<sensor_errors::Fault>();
template struct ListOperations<physics::Push>;
template std::string describe<physics::Push>();
template struct ListOperations<physics::FloorPatch>;
template std::string describe<physics::FloorPatch>();
template struct ListOperations<physics::Actor>;
template std::string describe<physics::Actor>();
template struct ListOperations<rig::Item>;
template std::string describe<rig::Item>();

template struct ListOperations<Session>;
template std::string describe<Session>();

}  // namespace sim::scenario
