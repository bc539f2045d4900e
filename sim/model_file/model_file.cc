#include "sim/model_file/model_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace sim::model_file {
namespace {

namespace fs = std::filesystem;
using std::string_view;

constexpr const char* kPrefix = "robot/";

/// Attributes of newer library versions that the bench can do without.
constexpr std::pair<string_view, string_view> kDropped[]{{"joint", "actuatorfrclimited"},
                                                         {"joint", "actuatorgravcomp"},
                                                         {"freejoint", "align"},
                                                         {"mesh", "content_type"},
                                                         {"mesh", "maxhullvert"},
                                                         {"mesh", "octree_maxdepth"},
                                                         {"mesh", "material"},
                                                         {"material", "metallic"},
                                                         {"material", "roughness"},
                                                         {"texture", "content_type"},
                                                         {"texture", "colorspace"},
                                                         {"texture", "nchannel"},
                                                         {"hfield", "content_type"},
                                                         {"body", "sleep"},
                                                         {"pair", "solreffriction"}};
/// Sections that are dropped, with what replaces them.
constexpr std::pair<string_view, string_view> kReplaced[]{{"option", "the bench's options of the physics"},
                                                          {"size", ""},
                                                          {"visual", "the room's light"},
                                                          {"statistic", ""},
                                                          {"custom", ""},
                                                          {"sensor", "the bench's sensors"},
                                                          {"keyframe", "robot.yaml's posture"},
                                                          {"actuator", "the bench's servos"}};
constexpr string_view kSections[]{"compiler", "default", "asset",   "worldbody",
                                  "contact",  "tendon",  "equality"};
/// Keys of `compiler` that affect masses. All others are applied here or do not matter.
constexpr string_view kMassKeys[]{"boundmass",       "boundinertia",      "settotalmass",    "balanceinertia",
                                  "inertiafromgeom", "inertiagrouprange", "exactmeshinertia"};
constexpr string_view kTurns[]{"quat", "axisangle", "euler", "xyaxes", "zaxis"};
/// Lists that may be shorter than the default, which then supplies the remaining numbers.
constexpr string_view kLists[]{"friction", "solref", "solimp", "solreflimit", "solimplimit", "size", "gear"};
/// Attributes that name an asset.
constexpr string_view kAssetNames[]{"mesh", "material", "texture", "hfield"};

bool is_one_of(const auto& word, const auto& words) {
  return std::find(std::begin(words), std::end(words), word) != std::end(words);
}

std::size_t words_in(const std::string& text) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < text.size(); ++i) count += text[i] != ' ' && (i == 0 || text[i - 1] == ' ');
  return count;
}

/// The default classes of a file.
class Classes {
 public:
  void add(const Element& element, const std::string& parent) {
    const std::string own = element.get("class"), name = parent.empty() && own.empty() ? "main" : own;
    if (name.empty()) reject(element, "class", "is missing");
    if (parent.empty()) main_ = name;
    if (!all_.emplace(name, std::pair(parent, &element)).second)
      reject(element, "class", fmt::format("'{}' is given twice", name));
    for (const Element& child : element.children)
      if (child.name == "default") add(child, name);
  }

  /// A class that a file may name without declaring it.
  void declare(const std::string& name) { all_.emplace(name, all_.at(main_)); }

  /// Copies the attributes of the element's class, and of the classes above it, into the element. kind: what
  /// its elements are called among the defaults.
  void apply(Element& element, string_view kind, const std::string& childclass = "") const {
    const std::string own = element.get("class");
    const std::string name = !own.empty() ? own : childclass.empty() ? main_ : childclass;
    auto at = all_.find(name);
    if (at == all_.end()) reject(element, "class", fmt::format("'{}' is not a default class", name));
    element.erase("class");
    for (; at != all_.end(); at = all_.find(at->second.first)) {
      const bool is_turned =
          std::ranges::any_of(kTurns, [&](string_view turn) { return element.find(turn); });
      const Element* const standard = at->second.second->child(kind);
      if (!standard) continue;
      for (const auto& [attribute, value] : standard->attributes) {
        const std::string* const given = element.find(attribute);
        if (!given && !(is_turned && is_one_of(attribute, kTurns)) &&
            !(attribute == "fromto" && element.find("pos")))
          element.set(attribute, value);
        else if (given && is_one_of(attribute, kLists))
          element.set(attribute, completed(*given, value));
      }
    }
  }

 private:
  static std::string completed(const std::string& given, const std::string& standard) {
    std::size_t from = 0;
    for (std::size_t skipped = words_in(given); skipped > 0 && from < standard.size(); --skipped) {
      from = standard.find_first_not_of(' ', from);
      from = std::min(standard.size(), standard.find(' ', from));
    }
    return given + standard.substr(from);
  }

  std::map<std::string, std::pair<std::string, const Element*>> all_;  // each class with its parent
  std::string main_;
};

/// Returns the file of an asset, whose folder the model's `compiler` element may set.
fs::path asset_file(const fs::path& model, const Element& compiler, const Element& asset) {
  const fs::path given = asset.get("file"),
                 name = compiler.get("strippath") == "true" ? given.filename() : given;
  const std::string kind = asset.name == "texture" ? "texturedir" : "meshdir";
  const std::string folder = compiler.get(compiler.find(kind) ? kind : "assetdir");
  std::error_code fault;
  fs::path file = model.parent_path() / folder / name;
  if (!fs::exists(file, fault) && asset.file)
    file = asset.file->parent_path() / folder / name;  // of an included file
  return fs::absolute(file).lexically_normal();
}

/// Replaces each include by the content of its file. read: the files so far.
void expand(Element& element, const fs::path& main_folder, std::set<fs::path>& read) {
  std::vector<Element> expanded;
  for (Element& child : element.children) {
    if (child.name != "include") {
      expand(child, main_folder, read);
      expanded.push_back(std::move(child));
      continue;
    }
    const std::string name = child.get("file");
    std::error_code fault;
    fs::path file = main_folder / name;
    if (!fs::exists(file, fault)) file = child.file->parent_path() / name;
    if (name.empty() || !fs::is_regular_file(file, fault))
      reject(child, "file", fmt::format("{} does not exist", file.string()));
    if (!read.insert(fs::weakly_canonical(file, fault)).second)
      reject(child, "file", fmt::format("{} is included twice", file.string()));
    Element included = read_xml(file);
    expand(included, main_folder, read);
    std::ranges::move(included.children, std::back_inserter(expanded));
  }
  element.children = std::move(expanded);
}

class Reader {
 public:
  Reader(Element file, const Schema& schema, std::vector<Note> notes, bool room)
      : schema_(schema.root().children.at("mujoco")), notes_(std::move(notes)), room_(room) {
    model_.root = {"mujoco", {{"model", file.get("model")}}, {}, file.file, file.line};
    for (const string_view section : kSections) model_.root.add(section);
    if (room) model_.root.add("visual");
    for (Element& section : file.children) take(std::move(section));
    read_compiler();
  }

  ModelFile read(const Parts& parts) {
    Element& world = apply_all_classes();
    Element robot = the_robot(world, parts.base);
    flatten(robot);
    free_the_base(robot);
    clean(robot);
    for (const Element& actuator : actuators_) keep_effort(actuator);
    require_mass(robot);
    model_.mass_kg = sum_;
    scale_mass(section("compiler"));
    world.children.assign(1, std::move(robot));
    for (const Element& each : section("equality").children) require_tree(each);
    for (const Element& each : section("contact").children) drop_contact(each, parts);
    section("contact").children.clear();
    return finished();
  }

  ModelFile read_room() {
    mark_floors(section("worldbody"), "");
    Element& world = apply_all_classes();
    flatten(world);
    const bool has_floor = check_room(world);
    clean(world);
    for (const char* unused : {"contact", "tendon", "equality"}) section(unused).children.clear();
    if (!has_floor)
      reject(Element{"worldbody", {}, {}, world.file, world.line}, "",
             "has no plane named 'floor' and no shape of class floor, expected a floor to walk on");
    return finished();
  }

 private:
  Element& section(string_view name) {
    return *std::ranges::find(model_.root.children, name, &Element::name);
  }
  std::string prefix() const { return room_ ? "" : kPrefix; }
  void note(Fate fate, string_view what, const Element& where) { add_note(notes_, fate, what, where); }

  /// Rejects lights and planes that cannot be drawn. Returns whether there is a floor.
  static bool check_room(Element& parent) {
    bool has_floor = false;
    for (Element& child : parent.children) {
      const bool is_plane = child.name == "geom" && child.get("type") == "plane";
      if (child.get("type") == "directional") child.erase("type"), child.set("directional", "true");
      if (child.name == "light" && child.get("active") != "false" && child.get("directional") != "true")
        reject(child, "directional", "is false, expected true: brightness must not depend on position");
      const std::vector<double> size = is_plane ? numbers(child, "size", 1, 3) : std::vector<double>{};
      if (size.size() > 1 && std::min(size[0], size[1]) <= 0)
        reject(child, "size", fmt::format("is '{}', expected positive half lengths", child.get("size")));
      has_floor |= check_room(child) || is_floor(child) || (is_plane && child.get("name") == "floor");
    }
    return has_floor;
  }

  /// Marks geoms of class floor by the contact bits that is_floor() reads.
  static void mark_floors(Element& parent, const std::string& childclass) {
    for (Element& child : parent.children) {
      const std::string own = child.get(child.name == "geom" ? "class" : "childclass");
      if (child.name == "body" || child.name == "frame") mark_floors(child, own.empty() ? childclass : own);
      if (child.name != "geom" || (own.empty() ? childclass : own) != "floor") continue;
      for (const char* bits : {"contype", "conaffinity"}) child.set(bits, std::to_string(kSteppedBits));
    }
  }

  Element& apply_all_classes() {
    classes_.add(section("default"), "");
    if (room_) classes_.declare("floor");
    Element& world = section("worldbody");
    apply_classes(world, "");
    for (Element& each : actuators_) classes_.apply(each, each.name);
    for (Element& each : section("asset").children) classes_.apply(each, each.name);
    for (const char* kind : {"equality", "tendon"})
      for (Element& each : section(kind).children) classes_.apply(each, kind);
    section("default").children.clear();
    return world;
  }

  ModelFile finished() {
    clean_assets();
    write_compiler();
    std::erase_if(model_.root.children,
                  [](const Element& each) { return each.children.empty() && each.name != "compiler"; });
    for (Element& each : model_.root.children) check(each, schema_.children.at(each.name));
    model_.notes = std::move(notes_);
    return std::move(model_);
  }

  void take(Element from) {
    if (is_one_of(from.name, kSections) || (room_ && from.name == "visual")) {
      Element& to = section(from.name);
      for (auto& [name, value] : from.attributes) to.set(name, value);
      if (to.children.empty()) to.file = from.file, to.line = from.line;
      std::ranges::move(from.children, std::back_inserter(to.children));
      return;
    }
    for (const auto& [name, instead] : kReplaced) {
      if (from.name != name) continue;
      note(Fate::dropped, instead.empty() ? from.name : fmt::format("{}: {}", name, instead), from);
      if (name == "actuator") std::ranges::move(from.children, std::back_inserter(actuators_));
      return;
    }
    reject(from, "",
           fmt::format("is not read, expected one of {}, actuator, sensor, keyframe, option",
                       fmt::join(kSections, ", ")));
  }

  void read_compiler() {
    const Element& compiler = section("compiler");
    const std::string angle = compiler.get("angle"), sequence = compiler.get("eulerseq");
    angles_.degrees = angle != "radian";
    if (!angle.empty() && angles_.degrees && angle != "degree")
      reject(compiler, "angle", fmt::format("is '{}', expected radian or degree", angle));
    if (!sequence.empty()) angles_.sequence = sequence;
    if (angles_.sequence.size() != 3 || sequence.find_first_not_of("xyzXYZ") != sequence.npos)
      reject(compiler, "eulerseq", fmt::format("is '{}', expected three of x, y, z, X, Y and Z", sequence));
    if (compiler.get("coordinate") == "global")
      reject(compiler, "coordinate", "is global, expected poses in the parent's frame");
    if (angles_.degrees) note(Fate::converted, "degrees: to radians", compiler);
  }

  /// If the file sets a total mass, the library scales all masses to it.
  void scale_mass(const Element& compiler) {
    const std::vector<double> total_kg = numbers(compiler, "settotalmass", 1, 1);
    if (total_kg.empty() || total_kg[0] <= 0) return;  // none or -1: no scaling
    const std::string sum = sum_ ? fmt::format(" of {:.4g} kg", *sum_) : "";
    note(Fate::converted, fmt::format("settotalmass: masses{} scaled to {} kg", sum, total_kg[0]), compiler);
    model_.mass_kg = total_kg[0];
  }

  // Keeps only the keys that affect the robot's masses; the others would also apply to the room.
  void write_compiler() {
    Element& compiler = section("compiler");
    std::erase_if(compiler.attributes, [&](const auto& each) { return !is_one_of(each.first, kMassKeys); });
    compiler.children.clear();
    compiler.set("angle", "radian");
    compiler.set("autolimits", "true");
  }

  void apply_classes(Element& parent, const std::string& childclass) const {
    for (Element& child : parent.children) {
      const std::string own = child.get("childclass");
      if (child.name == "body" || child.name == "frame") {
        child.erase("childclass");
        apply_classes(child, own.empty() ? childclass : own);
      } else if (child.name != "freejoint" && child.name != "inertial") {
        classes_.apply(child, child.name, childclass);
      }
    }
  }

  /// Replaces frames, including those in bodies below, by their contents with composed poses.
  void flatten(Element& parent) {
    std::vector<Element> flat;
    for (Element& child : parent.children) {
      if (child.name == "body" || child.name == "frame") flatten(child);
      if (child.name != "frame") {
        flat.push_back(std::move(child));
        continue;
      }
      note(Fate::converted, "frame: its contents are moved into the body", child);
      const Eigen::Isometry3d X = place_of(child, angles_);
      for (Element& each : child.children) {
        if (each.name.ends_with("joint") || each.name == "inertial")
          reject(each, "", "is in a frame, expected it directly in the body");
        if (const auto ends = numbers(each, "fromto", 6, 6); !ends.empty())
          each.set("fromto", text_of((X * Eigen::Vector3d(ends.data())).eval()) + " " +
                                 text_of((X * Eigen::Vector3d(ends.data() + 3)).eval()));
        else
          set_place(each, X * place_of(each, angles_));
        flat.push_back(std::move(each));
      }
    }
    parent.children = std::move(flat);
  }

  static std::size_t joints_in(const Element& body) {
    std::size_t count = 0;
    for (const Element& child : body.children)
      count += child.name == "joint"                           ? 1
               : child.name == "body" || child.name == "frame" ? joints_in(child)
                                                               : 0;
    return count;
  }

  Element the_robot(const Element& world, string_view base) {
    const Element* robot = nullptr;
    for (const Element& each : world.children)
      if (each.name == "body" &&
          (base.empty() ? !robot || joints_in(each) > joints_in(*robot) : each.get("name") == base))
        robot = &each;
    if (!robot)
      reject(
          world, "",
          base.empty() ? "has no body, expected a robot" : fmt::format("has no body '{}', the base", base));
    for (const Element& each : world.children)
      if (&each != robot) note(Fate::dropped, fmt::format("{} of the world", each.name), each);
    return *robot;
  }

  void free_the_base(Element& robot) {
    std::vector<const Element*> joints;
    for (const Element& child : robot.children) {
      if (child.name == "freejoint") return;
      if (child.name == "joint") joints.push_back(&child);
    }
    const auto is = [&](std::size_t i, string_view type, string_view axis) {
      const std::string own = joints[i]->get("axis");
      return joints[i]->get("type") == type && (axis.empty() || own == axis);
    };
    const bool is_free = joints.size() == 1 && is(0, "free", ""),
               is_four = joints.size() == 4 && is(0, "slide", "1 0 0") && is(1, "slide", "0 1 0") &&
                         is(2, "slide", "0 0 1") && is(3, "ball", "");
    if (!is_free && !is_four)
      reject(robot, "",
             fmt::format("'{}' is the base but has no free joint, expected <freejoint/>", robot.get("name")));
    note(
        Fate::converted,
        is_free ? "joint of type free: a freejoint, without damping" : "three slides and a ball: a freejoint",
        *joints[0]);
    Element free{"freejoint", {}, {}, joints[0]->file, joints[0]->line};
    if (is_free && joints[0]->find("name")) free.set("name", joints[0]->get("name"));
    std::erase_if(robot.children, [](const Element& child) { return child.name == "joint"; });
    robot.children.insert(robot.children.begin(), std::move(free));
  }

  // The torque limit: the actuator's force range, or else a motor's command range, times the gear.
  void keep_effort(const Element& actuator) {
    const std::string joint = actuator.get("joint");
    const auto gear = numbers(actuator, "gear", 1, 6);
    for (const auto& [attribute, limited] :
         {std::pair("forcerange", "forcelimited"), {"ctrlrange", "ctrllimited"}}) {
      const auto range = numbers(actuator, attribute, 2, 2);
      const bool is_torque = attribute[0] == 'f' || actuator.name == "motor";
      if (joint.empty() || range.empty() || !is_torque || actuator.get(limited) == "false") continue;
      const double most = std::max(std::abs(range[0]), std::abs(range[1]));
      if (model_.efforts.emplace(joint, most * (gear.empty() ? 1 : std::abs(gear[0]))).second)
        note(Fate::kept_aside, fmt::format("effort limits ({} {})", actuator.name, attribute), actuator);
    }
  }

  void clean(Element& body) {
    if (const auto gravcomp = numbers(body, "gravcomp", 1, 1); !gravcomp.empty()) {
      if (gravcomp[0] != 0) reject(body, "gravcomp", "is not 0, expected gravity to act on the whole robot");
      note(Fate::converted, "body gravcomp 0: left out", body);
      body.erase("gravcomp");
    }
    std::erase_if(body.children, [&](const Element& child) {
      const bool is_look = child.name == "camera" || (child.name == "light" && !room_);
      if (is_look) note(Fate::dropped, child.name, child);
      return is_look;
    });
    turn_by_quaternion(body);
    for (Element& child : body.children) {
      if (child.name == "body") {
        clean(child);
        continue;
      }
      turn_by_quaternion(child);
      if (room_ && child.name.ends_with("joint"))
        reject(child, "", "is in a room, expected shapes that do not move");
      if (child.name == "joint") clean_joint(child);
      for (const string_view attribute : kAssetNames)
        if (const std::string name = child.get(attribute); !name.empty())
          child.set(attribute, prefix() + name);
        else
          child.erase(attribute);
      if (child.name == "geom" && child.find("name")) geoms_.insert(child.get("name"));
    }
  }

  /// Converts Euler angles and axis angles to quaternions: their convention is the same for all parts of a
  /// model.
  void turn_by_quaternion(Element& element) const {
    if (!angles_.degrees && angles_.sequence == "xyz") return;
    if (element.find("euler") || element.find("axisangle")) set_place(element, place_of(element, angles_));
  }

  void clean_joint(Element& joint) {
    if (joint.get("type") == "free") reject(joint, "type", "is free, expected a free joint only on the base");
    if (const auto range = numbers(joint, "actuatorfrcrange", 2, 2); !range.empty()) {
      model_.efforts[joint.get("name")] = std::max(std::abs(range[0]), std::abs(range[1]));
      note(Fate::kept_aside, "effort limits (joint actuatorfrcrange)", joint);
      joint.erase("actuatorfrcrange");
    }
    if (!angles_.degrees || joint.get("type") == "slide") return;
    for (const char* attribute : {"range", "ref", "springref"})
      if (auto values = numbers(joint, attribute, 1, 2); !values.empty()) {
        for (double& value : values) value *= std::numbers::pi / 180;
        joint.set(attribute, text_of(values));
      }
  }

  /// Returns the mass of the body and of everything fixed to it, or 0 if it moves.
  double require_mass(const Element& body) {
    double mass = 0;
    bool moves = false;
    for (const Element& child : body.children) {
      if (child.name == "body") mass += require_mass(child);
      if (child.name.ends_with("joint")) moves = true;
      if (child.name == "inertial") mass += mass_of(child, body.child("joint") || body.child("freejoint"));
      if (child.name == "geom" && !body.child("inertial")) mass += mass_by_geom(child, body);
    }
    if (moves && !(mass > 0))
      reject(body, "", fmt::format("'{}' moves but has no mass, expected an inertial", body.get("name")));
    return moves ? 0 : mass;
  }

  // A body fixed to another one may be a point, with moments of 0.
  double mass_of(const Element& inertial, bool moves) {
    const auto mass = numbers(inertial, "mass", 1, 1);
    if (mass.empty() || mass[0] < 0) reject(inertial, "mass", "is missing or negative, expected kg");
    std::vector<double> moments = numbers(inertial, "diaginertia", 3, 3);
    const char* attribute = "diaginertia";
    if (const auto full = numbers(inertial, "fullinertia", 6, 6); !full.empty()) {
      Eigen::Matrix3d I;
      I << full[0], full[3], full[4], full[3], full[1], full[5], full[4], full[5], full[2];
      const Eigen::Vector3d values = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(I).eigenvalues();
      moments.assign(values.begin(), values.end()), attribute = "fullinertia";
    }
    std::ranges::sort(moments);
    const bool balanced = section("compiler").get("balanceinertia") == "true";
    const bool is_point = !moves && std::ranges::all_of(moments, [](double moment) { return moment == 0; });
    if (mass[0] > 0 && moments.size() == 3 && !is_point &&
        (moments[0] <= 0 || (!balanced && moments[0] + moments[1] < moments[2] * (1 - 1e-6))))
      reject(
          inertial, attribute,
          fmt::format("has principal moments {:.3g}, {:.3g} and {:.3g}, expected positive moments, with the "
                      "largest at most the sum of the others",
                      moments[0], moments[1], moments[2]));
    if (sum_) *sum_ += mass[0];
    return mass[0];
  }

  // Returns a nonzero value for a geom with mass. The actual mass is computed by the library.
  double mass_by_geom(const Element& geom, const Element& body) {
    const auto mass = numbers(geom, "mass", 1, 1), density = numbers(geom, "density", 1, 1);
    if (mass.empty() ? !density.empty() && density[0] == 0 : mass[0] == 0) return 0;
    if (geom.find("mesh"))
      reject(geom, "mesh",
             fmt::format("would define the inertia of '{}', which libraries compute differently: expected an "
                         "inertial in the body, or density 0",
                         body.get("name")));
    sum_.reset();
    return 1;
  }

  void require_tree(const Element& equality) const {
    if (equality.get("active") == "false" || equality.name == "joint" || equality.name == "tendon") return;
    reject(equality, "", "closes a loop of bodies, expected a robot that is a tree");
  }

  // The bench decides what touches what: soles and floor, the two feet, the robot and its room.
  void drop_contact(const Element& contact, const Parts& parts) {
    for (const auto& [attribute, other] : {std::pair("geom1", "geom2"), {"geom2", "geom1"}}) {
      const std::string* const geom = contact.find(attribute);
      if (!geom || geoms_.contains(*geom)) continue;
      model_.paired_with_floor.push_back(contact.get(other));
      if (parts.contacts && parts.contacts->empty())
        reject(contact, attribute,
               fmt::format("is '{}', which is not a geom of the robot: expected the contacts of each foot in "
                           "robot.yaml",
                           *geom));
    }
    note(Fate::dropped, fmt::format("contact {}: the bench decides what touches what", contact.name),
         contact);
  }

  /// Keeps the assets that the robot uses, with prefixed names and absolute paths.
  void clean_assets() {
    Element& assets = section("asset");
    std::set<std::string> used;
    const auto use = [&](const Element& user) {
      for (const string_view kind : kAssetNames)
        if (const std::string* const name = user.find(kind)) used.insert(fmt::format("{} {}", kind, *name));
    };
    const auto use_all = [&](const auto& self, const Element& body) -> void {
      for (const Element& child : body.children) use(child), self(self, child);
    };
    use_all(use_all, section("worldbody"));
    for (const Element& tendon : section("tendon").children) use(tendon);
    for (const bool textures : {false, true})
      std::erase_if(assets.children, [&](Element& asset) {
        if ((asset.name == "texture") != textures) return false;
        const std::string own = asset.get("name");
        const std::string name = own.empty() ? fs::path(asset.get("file")).stem().string() : own;
        asset.set("name", prefix() + name);
        if (asset.name == "material" && asset.find("texture"))
          asset.set("texture", prefix() + asset.get("texture"));
        if (!room_ && !used.contains(fmt::format("{} {}{}", asset.name, prefix(), name))) {
          note(Fate::dropped, fmt::format("{} that the robot does not use", asset.name), asset);
          return true;
        }
        use(asset);
        if (asset.find("file")) asset.set("file", file_of(asset).string());
        if (asset.name == "mesh") asset.erase("inertia");  // no mass comes from meshes
        return false;
      });
  }

  fs::path file_of(const Element& asset) {
    const fs::path given = asset.get("file"),
                   file = asset_file(*model_.root.file, section("compiler"), asset);
    std::string ending = file.extension().string();
    std::ranges::transform(ending, ending.begin(),
                           [](char c) { return c >= 'A' && c <= 'Z' ? char(c | 0x20) : c; });
    const bool is_read =
        asset.name == "texture" ? ending == ".png" : is_one_of(ending, std::array{".stl", ".obj", ".msh"});
    if (!is_read && asset.name != "hfield")
      reject(asset, "file",
             fmt::format("is '{}', expected a {} file", given.string(),
                         asset.name == "texture" ? ".png" : ".stl or .obj"));
    std::error_code fault;
    if (!fs::is_regular_file(file, fault))
      reject(asset, "file", fmt::format("{} does not exist", file.string()));
    return file;
  }

  /// Drops what only newer library versions know and the bench can do without. Rejects anything else unknown.
  void check(Element& element, const Schema::Known& known) {
    std::erase_if(element.attributes, [&](const auto& attribute) {
      if (known.attributes.contains(attribute.first)) return false;
      if (!is_one_of(std::pair<string_view, string_view>(element.name, attribute.first), kDropped))
        reject(element, attribute.first,
               fmt::format("is not known to this MuJoCo, expected one of {}",
                           fmt::join(known.attributes, ", ")));
      note(Fate::dropped, fmt::format("{} {}", element.name, attribute.first), element);
      return true;
    });
    for (Element& child : element.children) {
      const auto found = known.children.find(child.name);
      const bool same = known.recursive && child.name == element.name;
      if (!same && found == known.children.end())
        reject(child, "", fmt::format("is not known to this MuJoCo in {}", element.name));
      check(child, same ? known : found->second);
    }
  }

  const Schema::Known& schema_;
  ModelFile model_;
  std::vector<Note> notes_;
  bool room_;
  Angles angles_;
  Classes classes_;
  std::vector<Element> actuators_;
  std::set<std::string> geoms_;    // named geoms of the robot
  std::optional<double> sum_ = 0;  // sum of all masses; nothing if the library computes some of them
};

}  // namespace

void add_note(std::vector<Note>& notes, Fate fate, string_view what, const Element& where) {
  for (Note& note : notes)
    if (note.fate == fate && note.what == what) {
      ++note.count;
      return;
    }
  notes.push_back({fate, std::string(what), fmt::format("{}:{}", where.file->string(), where.line)});
}

namespace {

/// read: receives the files.
Element whole_file(const fs::path& file, std::vector<Note>& notes, std::set<fs::path>& read) {
  Element root = read_xml(file);
  if (root.name == "robot") root = mjcf_of_urdf(root, notes);
  std::error_code fault;
  read.insert(fs::weakly_canonical(file, fault));
  expand(root, file.parent_path(), read);
  return root;
}

Reader reader_of(const fs::path& file, const Schema& schema, bool room) {
  std::vector<Note> notes;
  std::set<fs::path> read;
  Element root = whole_file(file, notes, read);
  if (root.name != "mujoco")
    reject(root, "", fmt::format("is not a model, expected mujoco{}", room ? "" : " (MJCF) or robot (URDF)"));
  return {std::move(root), schema, std::move(notes), room};
}

}  // namespace

ModelFile read_model(const fs::path& file, const Schema& schema, const Parts& parts) {
  return reader_of(file, schema, false).read(parts);
}

bool is_floor(const Element& geom) { return geom.get("contype") == std::to_string(kSteppedBits); }

ModelFile read_room(const fs::path& file, const Schema& schema) {
  return reader_of(file, schema, true).read_room();
}

std::vector<fs::path> files_of(const fs::path& file) {
  std::vector<Note> notes;
  std::set<fs::path> read;
  const Element root = whole_file(file, notes, read);
  Element compiler;
  for (const Element& section : root.children)
    if (section.name == "compiler")
      for (const auto& [name, value] : section.attributes) compiler.set(name, value);
  std::error_code fault;
  for (const Element& section : root.children)
    if (section.name == "asset")
      for (const Element& asset : section.children)
        if (const fs::path path = asset_file(file, compiler, asset);
            asset.find("file") && fs::is_regular_file(path, fault))
          read.insert(path);
  return {read.begin(), read.end()};
}

// An element's line is indented by three more than its parent's and has "name (type)" and attributes, which
// may continue on the following lines.
Schema::Schema(std::string_view printed) {
  std::vector<Known*> open{&root_};
  for (const std::string& line : files::lines_of(printed)) {
    const std::size_t indent = line.find_first_not_of(' ');
    if (indent == line.npos) continue;
    std::istringstream words(line);
    std::string word;
    if (const std::size_t type = line.find(" (", indent); type != line.npos && indent % 3 == 0) {
      const std::size_t depth = indent / 3;
      std::string name = line.substr(indent, type - indent);
      if (name == "(world)body") name = "body";
      if (depth + 1 > open.size()) throw std::invalid_argument("the schema skips a level");
      open.resize(depth + 1);
      Known& known = open.back()->children[name];
      known.recursive = line.substr(type + 2, 1) == "R";
      open.push_back(&known);
      words.seekg(std::streamoff(type + 4));
    }
    while (words >> word) open.back()->attributes.insert(word);
  }
  if (!root_.children.contains("mujoco")) throw std::invalid_argument("the schema has no mujoco");
  Known& file = root_.children["mujoco"];
  file.children["worldbody"] = file.children["body"];
  file.children["worldbody"].recursive = false;
  file.children["worldbody"].children["body"] = file.children["body"];
}

}  // namespace sim::model_file
