#include <fmt/format.h>

#include <Eigen/Geometry>

#include "sim/model_file/model_file.h"

namespace sim::model_file {
namespace {

constexpr std::string_view kPackage = "package://", kFile = "file://";
constexpr int kMostDeep = 100;

std::string required(const Element& element, std::string_view attribute) {
  if (!element.find(attribute)) reject(element, attribute, "is missing");
  return element.get(attribute);
}

// Three numbers, zeros if absent.
Eigen::Vector3d vector(const Element* element, std::string_view attribute) {
  if (!element || !element->find(attribute)) return Eigen::Vector3d::Zero();
  return Eigen::Vector3d(numbers(*element, attribute, 3, 3).data());
}

Eigen::Isometry3d origin_of(const Element& element) {
  const Element* const origin = element.child("origin");
  const Eigen::Vector3d rpy = vector(origin, "rpy");
  using Turn = Eigen::AngleAxisd;
  const Eigen::Quaterniond q = Turn(rpy.z(), Eigen::Vector3d::UnitZ()) *
                               Turn(rpy.y(), Eigen::Vector3d::UnitY()) *
                               Turn(rpy.x(), Eigen::Vector3d::UnitX());
  return Eigen::Translation3d(vector(origin, "xyz")) * q;
}

/// A package's folder, whatever its name, is the URDF's folder, one above it, or one beside any of these.
std::filesystem::path package_file(const Element& mesh, std::string_view rest) {
  rest.remove_prefix(std::min(rest.size(), rest.find_first_not_of('/')));  // package:///
  const std::string package(rest.substr(0, rest.find('/'))), inside(rest.substr(package.size()));
  const std::filesystem::path urdf = std::filesystem::absolute(*mesh.file).lexically_normal();
  for (auto folder = urdf.parent_path(); folder.has_relative_path(); folder = folder.parent_path())
    for (const std::filesystem::path& root : {folder, folder / package})
      if (std::filesystem::exists(root.string() + inside)) return root.string() + inside;
  reject(
      mesh, "filename",
      fmt::format("no folder above this file, or beside one, has {} of the package '{}'", inside, package));
}

class Urdf {
 public:
  Urdf(const Element& robot, std::vector<Note>& notes) : robot_(robot), notes_(notes) {
    for (const Element& each : robot.children) {
      if (each.name == "link") {
        if (!links_.emplace(required(each, "name"), &each).second) reject(each, "name", "is given twice");
      } else if (each.name == "material") {
        if (const Element* const color = each.child("color")) colors_[each.get("name")] = color->get("rgba");
      } else if (each.name == "mujoco") {
        if (const Element* const compiler = each.child("compiler")) meshdir_ = compiler->get("meshdir");
      } else if (each.name != "joint") {
        add_note(notes_, Fate::dropped, each.name, each);
      }
    }
    for (const Element& each : robot.children)
      if (each.name == "joint") add_joint(each);
    for (const auto& [name, link] : links_)
      if (!joint_above_.contains(name)) roots_.push_back(link);
    if (roots_.size() != 1)
      reject(robot, "",
             roots_.empty() ? "has no root link: its joints are a closed loop"
                            : fmt::format("has {} root links, such as '{}' and '{}', expected one",
                                          roots_.size(), roots_[0]->get("name"), roots_[1]->get("name")));
    drop_world();
  }

  Element mjcf() {
    Element root{"mujoco", {{"model", robot_.get("name")}}, {}, robot_.file, robot_.line};
    root.add("compiler", {{"angle", "radian"}, {"autolimits", "true"}});
    root.children.reserve(3);
    Element& assets = root.add("asset");
    assets_ = &assets;
    Element base = body(*roots_[0], nullptr, 0);
    if (made_ < links_.size())
      reject(robot_, "",
             fmt::format("has {} in a closed loop, expected a tree",
                         files::counted(links_.size() - made_, "link")));
    base.children.insert(base.children.begin(), {"freejoint", {}, {}, base.file, base.line});
    add_note(notes_, Fate::converted, "the root link is free to move, not welded to the world", *roots_[0]);
    root.add("worldbody").children.push_back(std::move(base));
    return root;
  }

 private:
  static const Element& part(const Element& element, std::string_view name) {
    const Element* const found = element.child(name);
    if (!found) reject(element, "", fmt::format("has no {}, expected one", name));
    return *found;
  }

  void add_joint(const Element& joint) {
    const std::string parent = required(part(joint, "parent"), "link"),
                      child = required(part(joint, "child"), "link");
    for (const std::string& link : {parent, child})
      if (!links_.contains(link))
        reject(joint, "", fmt::format("joins '{}', expected the name of a link", link));
    const auto [above, is_new] = joint_above_.emplace(child, &joint);
    if (!is_new)
      reject(joint, "",
             fmt::format("'{}' also hangs on '{}': a closed loop, expected a tree", child,
                         above->second->get("name")));
    below_[parent].push_back(&joint);
  }

  // A link without mass that has the robot floating below it stands for the world.
  void drop_world() {
    const auto& joints = below_[roots_[0]->get("name")];
    if (joints.size() != 1 || joints[0]->get("type") != "floating" || roots_[0]->child("inertial")) return;
    ++made_;
    add_note(notes_, Fate::converted, "floating joint: the link below it is the free root", *joints[0]);
    roots_[0] = links_.at(joints[0]->child("child")->get("link"));
  }

  Element body(const Element& link, const Element* joint, int depth) {
    if (depth > kMostDeep) reject(link, "", fmt::format("has more than {} links above it", kMostDeep));
    ++made_;
    Element body{"body", {{"name", link.get("name")}}, {}, link.file, link.line};
    if (joint) set_place(body, origin_of(*joint));
    if (joint) add_joint_to(body, *joint);
    const Element* const inertial = link.child("inertial");
    if (!inertial || !add_inertial(body, *inertial))  // just a frame
      body.add("inertial", {{"pos", "0 0 0"}, {"mass", "0"}, {"diaginertia", "0 0 0"}});
    for (const Element& each : link.children) {
      if (each.name == "visual" || each.name == "collision")
        add_geom(body, each);
      else if (each.name != "inertial")
        add_note(notes_, Fate::dropped, "link " + each.name, each);
    }
    for (const Element* each : below_[link.get("name")])
      body.children.push_back(this->body(*links_.at(each->child("child")->get("link")), each, depth + 1));
    return body;
  }

  void add_joint_to(Element& body, const Element& joint) {
    const std::string type = required(joint, "type");
    if (type == "fixed") return;
    if (type == "floating") reject(joint, "type", "is floating, expected only the whole robot to float");
    const bool slides = type == "prismatic";
    if (type != "revolute" && type != "continuous" && !slides)
      reject(joint, "type", fmt::format("is {}, expected revolute, continuous, prismatic or fixed", type));
    Element& made =
        body.add("joint", {{"name", required(joint, "name")}, {"type", slides ? "slide" : "hinge"}});
    made.line = joint.line;
    const Element* const axis = joint.child("axis");
    const Eigen::Vector3d along = axis ? vector(axis, "xyz") : Eigen::Vector3d(1, 0, 0);
    if (along.norm() < 1e-6) reject(*axis, "xyz", "is zero, expected a direction");
    made.set("axis", text_of(along));
    const Element* const limit = joint.child("limit");
    if (type != "continuous") {
      if (!limit || !limit->find("lower") || !limit->find("upper"))
        reject(joint, "limit", "is missing, expected lower and upper");
      made.set("range", limit->get("lower") + " " + limit->get("upper"));
    }
    if (limit && limit->find("effort") && numbers(*limit, "effort", 1, 1)[0] > 0)
      made.set("actuatorfrcrange", "-" + limit->get("effort") + " " + limit->get("effort"));
    if (limit && limit->find("velocity")) add_note(notes_, Fate::dropped, "limit velocity", *limit);
    if (const Element* const dynamics = joint.child("dynamics")) {
      if (dynamics->find("damping")) made.set("damping", dynamics->get("damping"));
      if (dynamics->find("friction")) made.set("frictionloss", dynamics->get("friction"));
    }
    if (const Element* const mimic = joint.child("mimic"))
      add_note(notes_, Fate::dropped, "joint mimic: each joint has a servo", *mimic);
  }

  static bool add_inertial(Element& body, const Element& inertial) {
    const Eigen::Isometry3d X = origin_of(inertial);
    const Element &mass = part(inertial, "mass"), &inertia = part(inertial, "inertia");
    required(mass, "value");
    if (numbers(mass, "value", 1, 1)[0] == 0) return false;
    const auto of = [&](const char* attribute) {
      const auto value = numbers(inertia, attribute, 1, 1);
      return value.empty() ? 0 : value[0];
    };
    Eigen::Matrix3d I;
    I << of("ixx"), of("ixy"), of("ixz"), of("ixy"), of("iyy"), of("iyz"), of("ixz"), of("iyz"), of("izz");
    I = (X.linear() * I * X.linear().transpose()).eval();
    Element& made = body.add("inertial", {{"pos", text_of(X.translation())}, {"mass", mass.get("value")}});
    made.line = inertial.line;
    I.isZero(1e-12)  // a point, up to rounding errors
        ? made.set("diaginertia", "0 0 0")
        : made.set("fullinertia", text_of(std::array{I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)}));
    return true;
  }

  void add_geom(Element& body, const Element& shape) {
    const Element& geometry = part(shape, "geometry");
    if (geometry.children.empty()) reject(geometry, "", "is empty, expected a shape");
    const Element& kind = geometry.children.front();
    Element geom{"geom", {{"type", kind.name}, {"mass", "0"}}, {}, shape.file, shape.line};
    if (shape.name == "visual")
      for (const char* bits : {"contype", "conaffinity"}) geom.set(bits, "0");
    set_place(geom, origin_of(shape));
    const auto number = [&](const char* attribute) {
      required(kind, attribute);
      return numbers(kind, attribute, 1, 1)[0];
    };
    if (kind.name == "box") {
      required(kind, "size");
      geom.set("size", text_of((vector(&kind, "size") / 2).eval()));
    } else if (kind.name == "sphere") {
      geom.set("size", text_of(std::array{number("radius")}));
    } else if (kind.name == "cylinder" || kind.name == "capsule") {
      geom.set("size", text_of(std::array{number("radius"), number("length") / 2}));
    } else if (kind.name == "mesh") {
      geom.set("mesh", mesh(kind));
    } else {
      reject(kind, "", "expected a box, cylinder, capsule, sphere or mesh");
    }
    if (const Element* const material = shape.child("material")) {
      const Element* const color = material->child("color");
      const std::string rgba = color ? color->get("rgba") : colors_[material->get("name")];
      if (!rgba.empty()) geom.set("rgba", rgba);
    }
    body.children.push_back(std::move(geom));
  }

  // Returns the name of the asset.
  std::string mesh(const Element& mesh) {
    std::string file = required(mesh, "filename"), scale = mesh.get("scale");
    if (file.starts_with(kPackage)) file = package_file(mesh, std::string_view(file).substr(kPackage.size()));
    if (file.starts_with(kFile)) file.erase(0, kFile.size());
    const std::filesystem::path folder = mesh.file->parent_path();
    // As in MuJoCo, a meshdir in a URDF replaces the folders of the names.
    if (!meshdir_.empty() && !std::filesystem::exists(folder / file))
      file = (std::filesystem::path(meshdir_) / std::filesystem::path(file).filename()).string();
    const auto [known, is_new] =
        meshes_.emplace(std::pair(file, scale), fmt::format("mesh_{}", meshes_.size()));
    if (is_new) {
      Element& asset = assets_->add("mesh", {{"name", known->second}, {"file", file}});
      asset.line = mesh.line;
      if (!scale.empty()) asset.set("scale", scale);
    }
    return known->second;
  }

  const Element& robot_;
  std::vector<Note>& notes_;
  std::map<std::string, const Element*> links_, joint_above_;
  std::map<std::string, std::vector<const Element*>> below_;
  std::map<std::string, std::string> colors_;
  std::map<std::pair<std::string, std::string>, std::string> meshes_;
  std::vector<const Element*> roots_;
  std::string meshdir_;
  Element* assets_ = nullptr;
  std::size_t made_ = 0;  // number of bodies
};

}  // namespace

Element mjcf_of_urdf(const Element& robot, std::vector<Note>& notes) { return Urdf(robot, notes).mjcf(); }

}  // namespace sim::model_file
