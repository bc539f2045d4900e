// The lists of a scenario: walk commands, sensor faults, pushes and floor patches. Each item is of one kind
// of a closed set: `- stand: {duration_s: 1}`, `- frames_lost: {from_s: 20, duration_s: 2}`.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/physics/options.h"
#include "sim/scenario/key.h"
#include "sim/sensor_errors/faults.h"
#include "walking/plan.h"

namespace sim::scenario {

/// A std::vector of any type.
struct ListAccess {
  std::size_t (*size)(const void* list);
  const void* (*at)(const void* list, std::size_t i);
  void* (*append)(void* list);
};
/// A kind of item: its word in the file and its fields; if its value is a list, those of an entry.
struct ItemKind {
  std::string_view word;
  std::vector<Key> fields;
  const void* defaults;        ///< of the fields
  void* (*start)(void* item);  ///< makes the item one of this kind; returns the owner of its fields
  const void* (*find)(const void* item);  ///< the owner of its fields; nullptr if the item is of another kind
  std::string_view (*problem)(const void* owner);  ///< what is wrong with it as a whole
  const ListAccess* entries;                       ///< nullptr if its value is not a list
};

/// How a list of items is written. A kind has kName and keys, and may have problem(), which returns what is
/// wrong with an item as a whole. If its value is a list, it has `list`.
class KindList {
 public:
  /// noun: what an item is called in messages; example: a whole item as YAML, without the dash; least: how
  /// many items there must be.
  KindList(std::string noun, std::string example, std::size_t least, std::vector<ItemKind> kinds,
           const ListAccess& items);

  /// "a list of commands"
  std::string expected() const;

  /// Appends the whole list to items. Throws ConfigError at the item or field that is wrong.
  void read(const Yaml& node, std::string_view key, void* items) const;

  /// As YAML, one item to a line.
  std::string print(const void* items) const;

  /// One line for each kind and each of its fields, for help.
  std::string describe() const;

 private:
  void read_item(const Yaml& node, std::string_view key, void* item) const;
  void read_kind(const Yaml& node, const std::string& where, const ItemKind& kind, void* owner) const;
  void read_fields(const Yaml& node, const std::string& where, const ItemKind& kind, void* owner) const;
  std::string print_item(const void* item) const;

  std::string noun_, example_;
  std::size_t least_;
  std::vector<ItemKind> kinds_;
  std::vector<std::string_view> words_;
  const ListAccess& items_;
};

/// How the items of each list are written.
const KindList& grammar_of(const std::vector<walking::Command>&);
const KindList& grammar_of(const std::vector<sensor_errors::Fault>&);
const KindList& grammar_of(const std::vector<physics::Push>&);
const KindList& grammar_of(const std::vector<physics::FloorPatch>&);

/// expected, read and print of value.h, for these lists.
template <class Item>
std::string expected(const Domain&, const std::vector<Item>& items) {
  return grammar_of(items).expected();
}
template <class Item>
void read(const Yaml& node, std::string_view key, const Domain&, std::vector<Item>& items) {
  std::vector<Item> all;
  grammar_of(items).read(node, key, &all);
  items = std::move(all);
}
template <class Item>
std::string print(const Domain&, const std::vector<Item>& items) {
  return grammar_of(items).print(&items);
}

/// One line for each kind of item and each of its fields, for help.
std::string describe_commands();
std::string describe_faults();
std::string describe_disturbances();

}  // namespace sim::scenario
