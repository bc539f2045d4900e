// The lists of a scenario: walk commands, sensor faults, pushes, floor patches and sensors of the rig. Each
// item is of one kind of a closed set: `- stand: {duration_s: 1}`. A kind has kName and keys, and may have
// problem(), which returns what is wrong with an item as a whole, and `list`, if its value in the file is a
// list.
#pragma once

#include <concepts>
#include <string>
#include <string_view>
#include <vector>

#include "sim/physics/options.h"
#include "sim/rig/options.h"
#include "sim/scenario/value.h"
#include "sim/sensor_errors/faults.h"
#include "walking/plan.h"

namespace sim::scenario {

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

}  // namespace sim::scenario
