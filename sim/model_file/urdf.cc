#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/model_file/model_file.h"

namespace sim::model_file {
namespace {

constexpr std::string_view kPackage = "package://", kFile = "file://";
constexpr char kWorld[] = "world";  // the link that the library treats as the world
constexpr double kPoint = 1e-12;    // kg m^2: smaller moments of inertia are rounding errors of a point mass

std::string required(const Element& element, std::string_view attribute) {
  if (!element.find(attribute)) reject(element, attribute, "is missing");
  return element.get(attribute);
}

Element& part(Element& element, std::string_view name) {
  const auto found = std::ranges::find(element.children, name, &Element::name);
  return found == element.children.end() ? element.add(name) : *found;
}

class Urdf {
 public:
  Urdf(ModelFile& model, const Packages& packages) : model_(model), robot_(model.root), packages_(packages) {}

  void prepare() {
    std::erase_if(robot_.children, [this](const Element& each) {
      const bool known =
          each.name == "link" || each.name == "joint" || each.name == "material" || each.name == "mujoco";
      if (!known) note(Fate::dropped, each.name, each);
      return !known;
    });
    robot_.visit([this](const Element& each) {
      if (const auto name = package_in(each.get("filename")); !name.empty()) named_.insert(name);
    });
    read_compiler();
    find_root();
    free_root();
    robot_.visit([this](Element& each) { prepare(each); });
    show_meshes();
  }

 private:
  void note(Fate fate, std::string_view what, const Element& where) {
    add_note(model_.notes, fate, what, where);
  }

  void read_compiler() {
    Element& compiler = part(part(robot_, "mujoco"), "compiler");
    meshdir_ = compiler.get("meshdir");
    for (const char* key : {"fusestatic", "discardvisual", "strippath"}) compiler.set(key, "false");
    compiler.erase("meshdir");
  }

  static std::string link_at(const Element& joint, std::string_view end) {
    const Element* const found = joint.child(end);
    return found ? found->get("link") : "";
  }

  /// The library reports other errors in the tree.
  void find_root() {
    std::set<std::string> below;
    std::vector<Element*> roots;
    for (const Element& each : robot_.children)
      if (each.name == "joint") below.insert(link_at(each, "child"));
    for (Element& each : robot_.children)
      if (each.name == "link" && !below.contains(required(each, "name"))) roots.push_back(&each);
    if (roots.size() != 1)
      reject(robot_, "", "{}",
             roots.empty() ? "has no root link: its joints are a closed loop"
                           : fmt::format("has {} root links, such as '{}' and '{}', expected one",
                                         roots.size(), roots[0]->get("name"), roots[1]->get("name")));
    root_ = roots[0];
  }

  /// Makes the robot float below the library's world. A link without mass that has only one joint, floating,
  /// stands for the world, as does a link of that name.
  void free_root() {
    const std::string name = root_->get("name");
    std::vector<Element*> below;
    for (Element& each : robot_.children)
      if (each.name == "joint" && link_at(each, "parent") == name) below.push_back(&each);
    const bool floats = below.size() == 1 && below[0]->get("type") == "floating" && !root_->child("inertial");
    if (name == kWorld && below.size() != 1)
      reject(*root_, "", "'world' has {}, expected one, to the robot", files::counted(below.size(), "joint"));
    if (floats || name == kWorld) {
      note(Fate::converted,
           fmt::format("{} joint: the link below it is the free root", below[0]->get("type")), *below[0]);
      below[0]->set("type", "floating");
      part(*below[0], "parent").set("link", kWorld);
      root_->set("name", kWorld);
      return;
    }
    note(Fate::converted, "the root link is free to move, not welded to the world", *root_);
    add_joint("floating", name);
    robot_.children.push_back({"link", {{"name", kWorld}}, {}, robot_.file, robot_.line});
  }

  void add_joint(const char* type, const std::string& link) {
    Element joint{"joint", {{"name", "gaitslam/" + link}, {"type", type}}, {}, robot_.file, robot_.line};
    joint.add("parent", {{"link", kWorld}});
    joint.add("child", {{"link", link}});
    robot_.children.push_back(std::move(joint));
  }

  void prepare(Element& element) {
    if (element.name == "link" && element.get("name") != kWorld) prepare_inertial(element);
    if (element.name == "joint" && element.child("child")) prepare_joint(element);
    if (element.name == "mesh") prepare_mesh(element);
    if (element.name == "capsule") {
      note(Fate::converted, "capsule: a cylinder, without round ends", element);
      element.name = "cylinder";
    }
    if (element.name == "material")
      std::erase_if(element.children, [this](const Element& child) {
        if (child.name == "texture") note(Fate::dropped, "material texture", child);
        return child.name == "texture";
      });
  }

  /// A link without mass is just a frame; the library would take its mass from its shapes.
  void prepare_inertial(Element& link) {
    if (!link.child("inertial") && link.get("name") != kMeshes)
      note(Fate::converted, "link without inertial: without mass", link);
    Element& inertial = part(link, "inertial");
    inertial.children.reserve(inertial.children.size() + 2);  // the references below stay valid
    Element &mass = part(inertial, "mass"), &inertia = part(inertial, "inertia");
    if (!mass.find("value")) mass.set("value", "0");
    const bool is_frame = numbers(mass, "value", 1, 1)[0] == 0;
    bool is_point = true;
    constexpr std::array kMoments{"ixx", "iyy", "izz", "ixy", "ixz", "iyz"};
    for (const char* key : kMoments) {
      const auto moment = numbers(inertia, key, 1, 1);
      is_point &= moment.empty() || std::abs(moment[0]) <= kPoint;
    }
    for (const char* key : kMoments)
      if (is_point || is_frame || !inertia.find(key)) inertia.set(key, "0");
  }

  void prepare_joint(Element& joint) {
    const std::string name = required(joint, "name");
    if (const Element* const limit = joint.child("limit")) {
      if (limit->find("velocity")) note(Fate::dropped, "limit velocity", *limit);
      const auto effort = numbers(*limit, "effort", 1, 1);
      if (!effort.empty() && effort[0] > 0) model_.efforts[name] = effort[0];
      if (!effort.empty() && effort[0] <= 0 && joint.get("type") != "fixed")
        note(Fate::doubtful, "limit effort 0: treated as no limit, expected the largest torque", *limit);
    }
    if (const Element* const mimic = joint.child("mimic"))
      note(Fate::dropped, "joint mimic: each joint has a servo", *mimic);
  }

  /// Gives each file, at each scale, its own name, because the library distinguishes meshes only by file
  /// name.
  void prepare_mesh(Element& mesh) {
    const fs::path file = file_of(mesh, required(mesh, "filename"));
    require_readable(mesh, "filename", file);
    const std::string scale = mesh.get("scale");
    const auto [known, is_new] =
        meshes_.emplace(std::pair(file, scale), fmt::format("mesh_{}", meshes_.size()));
    const std::string in_root = known->second + file.extension().string();
    mesh.set("filename", in_root);
    if (!is_new) return;
    model_.files.emplace_back(in_root, file);
    model_.assets.push_back(
        {"mesh", {{"name", known->second}, {"file", file.string()}}, {}, mesh.file, mesh.line});
    if (!scale.empty()) model_.assets.back().set("scale", scale);
  }

  static std::string package_in(const std::string& name) {
    if (!name.starts_with(kPackage)) return "";
    const auto from = name.find_first_not_of('/', kPackage.size());  // package:///
    return from == name.npos ? "" : name.substr(from, name.find('/', from) - from);
  }

  fs::path file_of(const Element& mesh, std::string name) const {
    if (const std::string package = package_in(name); !package.empty())
      return package_file(mesh, package, name.substr(name.find(package, kPackage.size()) + package.size()));
    if (name.starts_with(kFile)) name.erase(0, kFile.size());
    const fs::path folder = fs::absolute(*mesh.file).parent_path();
    // As in MuJoCo, a meshdir in a URDF replaces the folders of the names.
    if (!meshdir_.empty() && !fs::exists(folder / name))
      name = fs::path(meshdir_) / fs::path(name).filename();
    return (folder / name).lexically_normal();
  }

  /// Returns a file of a package, whose folder is given in robot.yaml or has the package's name and
  /// is, or is in, a folder above the URDF. If all meshes belong to one package, its folder may have a
  /// different name.
  fs::path package_file(const Element& mesh, const std::string& package, const std::string& inside) const {
    if (const auto known = packages_.find(package); known != packages_.end())
      return known->second.string() + inside;
    const fs::path urdf = fs::absolute(*mesh.file).lexically_normal();
    for (const bool renamed : {false, true})
      for (auto folder = urdf.parent_path(); folder.has_relative_path(); folder = folder.parent_path()) {
        const fs::path root = renamed || folder.filename() == package ? folder : folder / package;
        if ((!renamed || named_.size() == 1) && fs::exists(root.string() + inside)) {
          if (renamed)
            add_note(model_.notes, Fate::converted,
                     fmt::format("package '{}': assumed to be {}", package, root.string()), mesh);
          return root.string() + inside;
        }
      }
    reject(mesh, "filename",
           "no folder above this file, or inside one, is the package '{0}' with {1}, expected its "
           "folder in robot.yaml: packages: {{{0}: FOLDER}}",
           package, inside);
  }

  void show_meshes() {
    Element link{"link", {{"name", kMeshes}}, {}, robot_.file, robot_.line};
    prepare_inertial(link);
    for (std::size_t i = 0; i < model_.files.size(); ++i) {
      Element& mesh = link.add("visual").add("geometry").add("mesh", {{"filename", model_.files[i].first}});
      if (const std::string* const scale = model_.assets[i].find("scale")) mesh.set("scale", *scale);
    }
    robot_.children.push_back(std::move(link));
    add_joint("fixed", kMeshes);
  }

  ModelFile& model_;
  Element& robot_;
  const Packages& packages_;
  std::set<std::string> named_;  // packages
  std::map<std::pair<fs::path, std::string>, std::string> meshes_;
  std::string meshdir_;
  Element* root_ = nullptr;
};

}  // namespace

void prepare_urdf(ModelFile& model, const Packages& packages) { Urdf(model, packages).prepare(); }

}  // namespace sim::model_file
