#include "sim/physics/adapted.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace sim::physics {
namespace {

using model_file::Element, model_file::Fate, model_file::text_of;

constexpr std::array kFootSides{"right", "left"};  // as walking::Side
// Contact bits: with the floor, with the other foot, and for shapes that only give their body its mass.
constexpr unsigned kFloorBit = 1, kFeetBit = 2, kMassBit = 4;
constexpr std::size_t kAdded = 4;  // most parts added to one body: sites and camera
constexpr int kHidden = 3;         // first group that is not drawn

unsigned bits_of(const Element& geom, const char* attribute) {
  const auto value = numbers(geom, attribute, 1, 1);
  return value.empty() ? 1 : unsigned(std::clamp(value[0], 0.0, 1e9));
}
void set_bits(Element& geom, unsigned type, unsigned affinity) {
  geom.set("contype", std::to_string(type));
  geom.set("conaffinity", std::to_string(affinity));
}
bool can_touch(const Element& geom) { return (bits_of(geom, "contype") | bits_of(geom, "conaffinity")) != 0; }
bool touches_floor(const Element& geom) {
  return ((bits_of(geom, "contype") | bits_of(geom, "conaffinity")) & kFloorBit) != 0;
}

class Adapter {
 public:
  explicit Adapter(const RobotFile& robot) : robot_(robot) {
    std::optional<std::vector<std::string>> contacts;
    for (const RobotFile::Foot& foot : robot.feet) {
      if (!contacts) contacts.emplace();
      contacts->insert(contacts->end(), foot.contacts.begin(), foot.contacts.end());
    }
    model_ = read_model(robot.folder / robot.model, schema(), {robot.base, contacts});
    base_ = &std::ranges::find(model_.root.children, "worldbody", &Element::name)->children.front();
    collect(*base_, robot.feet.end());
  }

  model_file::ModelFile adapt() {
    for (auto& [name, body] : bodies_) adapt_shapes(*body.first, body.second);
    for (std::size_t side = 0; side < 2; ++side) require_sole(side);
    add_servos();
    for (std::size_t side = 0; side < 2; ++side) {
      const RobotFile::Foot& foot = robot_.feet[side];
      const Eigen::Isometry3d X_BS = Eigen::Translation3d(foot.sole_m) *
                                     Eigen::AngleAxisd(foot.sole_yaw_rad, Eigen::Vector3d::UnitZ()) *
                                     Eigen::AngleAxisd(foot.sole_pitch_rad, Eigen::Vector3d::UnitY()) *
                                     Eigen::AngleAxisd(foot.sole_roll_rad, Eigen::Vector3d::UnitX());
      add_at("site", fmt::format("{}_sole", kFootSides[side]),
             body(fmt::format("feet.{}", kFootSides[side]), foot.body), X_BS);
    }
    add_at("site", "imu", body("imu", robot_.imu.link), rig::pose(robot_.imu));
    Eigen::Matrix3d R_LM;  // MuJoCo's camera: x right, y up, looking along -z
    R_LM << 0, 0, -1, -1, 0, 0, 0, 1, 0;
    add_at("camera", "head_camera", body("head_camera", robot_.head_camera.link),
           rig::pose(robot_.head_camera) * Eigen::Isometry3d(Eigen::Quaterniond(R_LM)));
    Element& sensors = model_.root.add("sensor");
    for (const char* side : kFootSides)
      for (const char* kind : {"force", "torque"})
        sensors.add(kind,
                    {{"name", fmt::format("{}_{}", side, kind)}, {"site", fmt::format("{}_sole", side)}});
    model_.root.add("option", {{"timestep", "0.001"},
                               {"gravity", "0 0 -9.81"},
                               {"cone", "elliptic"},
                               {"impratio", "10"},
                               {"solver", "Newton"},
                               {"jacobian", "sparse"}});
    make_rigid(*base_);
    drop_couplings_of_rigid();
    return std::move(model_);
  }

 private:
  [[noreturn]] void fail(const std::string& key, const std::string& message) const {
    const auto place = robot_.places.find(key);
    throw std::invalid_argument(fmt::format(
        "{}: {}: {}", place == robot_.places.end() ? (robot_.folder / "robot.yaml").string() : place->second,
        key, message));
  }

  using Foot = std::array<RobotFile::Foot, 2>::const_iterator;

  // Frees the bench's own names for its own parts. foot: the foot that the body above is part of.
  void collect(Element& body, Foot foot) {
    if (const Foot own = std::ranges::find(robot_.feet, body.get("name"), &RobotFile::Foot::body);
        own != robot_.feet.end() || body.child("joint"))
      foot = own;
    std::erase_if(body.children, [](const Element& child) {
      const std::string name = child.name == "site" ? child.get("name") : "";
      return name == "imu" || name == "left_sole" || name == "right_sole";
    });
    bodies_[body.get("name")] = {&body, foot};
    body.children.reserve(body.children.size() + kAdded);  // pointers to bodies stay valid
    for (Element& child : body.children) {
      if (child.name == "body") collect(child, foot);
      if (child.name == "geom" && foot != robot_.feet.end()) feet_touch_floor_ |= touches_floor(child);
      if (child.name != "joint") continue;
      joints_.push_back(&child);
      if (const std::string name = child.get("name");
          !joint_places_.emplace(name, joints_.size()).second && !name.empty())
        reject(child, "name", fmt::format("'{}' is given twice, expected a unique name", name));
    }
  }

  Element& body(const std::string& key, const std::string& name) {
    const auto found = bodies_.find(name);
    if (found != bodies_.end()) return *found->second.first;
    std::vector<std::string> names;
    for (const auto& [known, element] : bodies_) names.push_back(known);
    fail(key, fmt::format("the model has no body '{}', expected one of {}", name, fmt::join(names, ", ")));
  }

  static void add_at(const char* kind, const std::string& name, Element& body, const Eigen::Isometry3d& X) {
    const Eigen::Quaterniond q(X.linear());
    body.add(kind, {{"name", name},
                    {"pos", text_of(X.translation())},
                    {"quat", text_of(std::array{q.w(), q.x(), q.y(), q.z()})}});
  }

  void adapt_shapes(Element& body, Foot foot) {
    const bool is_head = body.get("name") == robot_.head_camera.link,
               has_mass = body.child("inertial") != nullptr;
    bool has_looks = false, has_others = false;
    std::vector<Element*> soles;
    for (Element& geom : body.children) {
      if (geom.name != "geom") continue;
      if (foot != robot_.feet.end() && is_sole(geom, *foot)) {
        soles.push_back(&geom);
        continue;
      }
      has_looks |= !can_touch(geom);
      has_others |= can_touch(geom);
    }
    for (Element& geom : body.children) {
      if (geom.name != "geom") continue;
      const auto group = numbers(geom, "group", 1, 1);
      const bool hidden = (!group.empty() && group[0] >= kHidden) || (can_touch(geom) && has_looks);
      geom.set("group", hidden ? "3" : is_head ? "2" : "1");
      if (std::ranges::count(soles, &geom) > 0) {
        has_others ? set_bits(geom, kFloorBit, 0) : set_bits(geom, kFloorBit | kFeetBit, kFeetBit);
        geom.set("priority", "1");  // this geom's friction counts
      } else if (foot != robot_.feet.end() && can_touch(geom)) {
        set_bits(geom, kFeetBit, kFeetBit);
      } else {
        set_bits(geom, has_mass ? 0 : kMassBit, 0);
      }
    }
    if (foot != robot_.feet.end()) soles_[std::size_t(foot - robot_.feet.begin())] += soles.size();
  }

  // `contacts` may name geoms that touch the floor only through a contact pair. Without names: the geoms that
  // touch the floor, or all that touch anything if the model's floor has other bits.
  bool is_sole(const Element& geom, const RobotFile::Foot& foot) const {
    if (!foot.contacts.empty()) return std::ranges::count(foot.contacts, geom.get("name")) > 0;
    return can_touch(geom) && (touches_floor(geom) || !feet_touch_floor_);
  }

  void require_sole(std::size_t side) {
    const RobotFile::Foot& foot = robot_.feet[side];
    const std::string key = fmt::format("feet.{}", kFootSides[side]);
    body(key, foot.body);
    if (soles_[side] == 0 && foot.contacts.empty())
      fail(key, fmt::format("body '{}' has no colliding geom, expected the sole", foot.body));
    if (soles_[side] < foot.contacts.size())
      fail(key,
           fmt::format("of the contacts {} body '{}' has {}, expected colliding geoms with these names in it",
                       fmt::join(foot.contacts, ", "), foot.body, soles_[side]));
  }

  void add_servos() {
    std::map<std::size_t, Element> servos;  // by position among the joints
    for (const RobotFile::Servo& servo : robot_.servos)
      for (const std::string& name : servo.joints) {
        const auto place = joint_places_.find(name);
        if (place == joint_places_.end()) fail("servos", fmt::format("the model has no joint '{}'", name));
        Element& joint = *joints_[place->second - 1];
        if (const std::string type = joint.get("type"); !type.empty() && type != "hinge")
          reject(joint, "type", fmt::format("of '{}' is {}, expected a hinge for a servo", name, type));
        if (!joint.find("range") || joint.get("limited") == "false")
          reject(joint, "range", fmt::format("'{}' has none, expected its smallest and largest angle", name));
        joint.set("damping", text_of(std::array{servo.kd_nms_rad}));
        if (servo.armature_kg_m2) joint.set("armature", text_of(std::array{*servo.armature_kg_m2}));
        Element made{"position",
                     {{"name", name}, {"joint", name}, {"kp", text_of(std::array{servo.kp_nm_rad})}},
                     {},
                     joint.file,
                     joint.line};
        std::optional<double> effort = servo.effort_nm;
        if (const auto known = model_.efforts.find(name); !effort && known != model_.efforts.end())
          effort = known->second;
        if (effort) made.set("forcerange", text_of(std::array{-*effort, *effort}));
        if (!servos.emplace(place->second, std::move(made)).second)
          fail("servos", fmt::format("joint '{}' has two servos", name));
      }
    Element& actuators = model_.root.add("actuator");
    for (auto& [place, servo] : servos) {
      moving_.insert(servo.get("joint"));
      actuators.children.push_back(std::move(servo));
    }
  }

  // Moves elements, so pointers to bodies become invalid.
  void make_rigid(Element& body) {
    std::erase_if(body.children, [&](const Element& child) {
      if (child.name != "joint" || moving_.contains(child.get("name"))) return false;
      const auto stiffness = numbers(child, "stiffness", 1, 1);
      if (!stiffness.empty() && stiffness[0] > 0) return false;
      add_note(model_.notes, Fate::converted, "joint without servo and stiffness: rigid", child);
      rigid_.insert(child.get("name"));
      return true;
    });
    for (Element& child : body.children)
      if (child.name == "body") make_rigid(child);
  }

  bool names_rigid(const Element& coupling) const {
    return std::ranges::any_of(std::array{"joint", "joint1", "joint2"},
                               [&](const char* joint) { return rigid_.contains(coupling.get(joint)); }) ||
           std::ranges::any_of(coupling.children, [&](const Element& child) { return names_rigid(child); });
  }
  void drop_couplings_of_rigid() {
    for (Element& section : model_.root.children)
      if (section.name == "equality" || section.name == "tendon")
        std::erase_if(section.children, [&](const Element& each) { return names_rigid(each); });
  }

  const RobotFile& robot_;
  model_file::ModelFile model_;
  Element* base_ = nullptr;
  std::map<std::string, std::pair<Element*, Foot>> bodies_;  // each with the foot that it is part of
  bool feet_touch_floor_ = false;
  std::array<std::size_t, 2> soles_{};               // number of geoms, by side
  std::vector<Element*> joints_;                     // in the order of the file, which the library keeps
  std::map<std::string, std::size_t> joint_places_;  // from 1
  std::set<std::string> moving_, rigid_;             // joints
};

}  // namespace

const model_file::Schema& schema() {
  static const model_file::Schema known = [] {
    std::vector<char> printed(1 << 20);
    mj_printSchema(nullptr, printed.data(), int(printed.size()), 0, 0);
    return model_file::Schema(printed.data());
  }();
  return known;
}

model_file::ModelFile adapt(const RobotFile& robot) { return Adapter(robot).adapt(); }

}  // namespace sim::physics
