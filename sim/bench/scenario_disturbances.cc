#include "sim/bench/scenario_disturbances.h"

#include "sim/bench/kind_list.h"

namespace sim::bench {
namespace {

using world::FloorPatch, world::Push;

constexpr Domain kTime{0, 1e6}, kImpulse{-1e4, 1e4}, kDuration{0.001, 100}, kPlace{-1e4, 1e4},
    kFriction{0.01, 5};

const KindList<Push>& push_list() {
  static const KindList<Push> list(
      "disturbance", "push: {time_s: 4, impulse_ns: 10, direction_deg: 90}",
      {"push",
       {make_key<Push>(GAITSLAM_FIELD(time_s), kTime, "when it begins"),
        make_key<Push>(GAITSLAM_FIELD(impulse_ns), kImpulse, "of an even horizontal force on the waist"),
        make_angle_key<Push>(
            "direction_deg", [](auto&& push) -> auto& { return push.direction_rad; },
            "in which it goes, by the waist's heading: 0 ahead, 90 to the left"),
        make_key<Push>(GAITSLAM_FIELD(duration_s), kDuration, "of the force")}});
  return list;
}

const KindList<FloorPatch>& patch_list() {
  static const KindList<FloorPatch> list(
      "disturbance", "patch: {x_min_m: 1, x_max_m: 2, y_min_m: -1, y_max_m: 1, friction: 0.1}",
      {"patch",
       {make_key<FloorPatch>(GAITSLAM_FIELD(x_min_m), kPlace, "of a rectangle of the floor"),
        make_key<FloorPatch>(GAITSLAM_FIELD(x_max_m), kPlace, "likewise"),
        make_key<FloorPatch>(GAITSLAM_FIELD(y_min_m), kPlace, "likewise"),
        make_key<FloorPatch>(GAITSLAM_FIELD(y_max_m), kPlace, "likewise"),
        make_key<FloorPatch>(GAITSLAM_FIELD(friction), kFriction, "of sole on floor there")}});
  return list;
}

void check(const Yaml&, std::string_view, const Push&) {}
void check(const Yaml& node, std::string_view key, const FloorPatch& patch) {
  if (patch.x_min_m >= patch.x_max_m) fail(node, key, "is empty, expected x_min_m below x_max_m");
  if (patch.y_min_m >= patch.y_max_m) fail(node, key, "is empty, expected y_min_m below y_max_m");
}

template <class Item>
void read_list(const KindList<Item>& list, const Yaml& node, std::string_view key, std::vector<Item>& items) {
  std::vector<std::variant<Item>> all;
  list.read(node, key, all);
  items.clear();
  for (const auto& item : all) {
    items.push_back(std::get<Item>(item));
    check(node.items[items.size() - 1], key, items.back());
  }
}

template <class Item>
std::string print_list(const KindList<Item>& list, const std::vector<Item>& items) {
  return list.print({items.begin(), items.end()});
}

}  // namespace

void read_disturbances(const Yaml& node, std::string_view key, std::vector<Push>& pushes) {
  read_list(push_list(), node, key, pushes);
}
void read_disturbances(const Yaml& node, std::string_view key, std::vector<FloorPatch>& patches) {
  read_list(patch_list(), node, key, patches);
}

std::string print_disturbances(const std::vector<Push>& pushes) { return print_list(push_list(), pushes); }
std::string print_disturbances(const std::vector<FloorPatch>& patches) {
  return print_list(patch_list(), patches);
}

std::string describe_disturbances() { return push_list().describe() + patch_list().describe(); }

}  // namespace sim::bench
