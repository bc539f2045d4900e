// The lists of a scenario: walk commands, sensor faults, pushes and floor patches, each item of one kind:
// `- stand: {duration_s: 1}`, `- frames_lost: {from_s: 20, duration_s: 2}`.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/physics/options.h"
#include "sim/scenario/kind_list.h"
#include "sim/sensor_errors/faults.h"
#include "walking/plan.h"

namespace sim::scenario {

/// How the items of each list are written.
const KindList<walking::Command>& grammar_of(const std::vector<walking::Command>&);
const KindList<sensor_errors::Fault>& grammar_of(const std::vector<sensor_errors::Fault>&);
const KindList<physics::Push>& grammar_of(const std::vector<physics::Push>&);
const KindList<physics::FloorPatch>& grammar_of(const std::vector<physics::FloorPatch>&);

/// expected, read and print of value.h, for these lists.
template <class Item>
std::string expected(const Domain&, const std::vector<Item>& items) {
  return grammar_of(items).expected();
}
template <class Item>
void read(const Yaml& node, std::string_view key, const Domain&, std::vector<Item>& items) {
  grammar_of(items).read(node, key, items);
}
template <class Item>
std::string print(const Domain&, const std::vector<Item>& items) {
  return grammar_of(items).print(items);
}

/// One line for each kind of item and each of its fields, for help.
std::string describe_commands();
std::string describe_faults();
std::string describe_disturbances();

}  // namespace sim::scenario
