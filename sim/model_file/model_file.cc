#include "sim/model_file/model_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>

namespace sim::model_file {
namespace {

using std::string_view;

/// Attributes of newer library versions that the bench does not need; "": for any element.
constexpr std::pair<string_view, string_view> kDropped[]{{"joint", "actuatorgravcomp"},
                                                         {"freejoint", "align"},
                                                         {"mesh", "content_type"},
                                                         {"mesh", "inertia"},
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
                                                         {"compiler", "alignfree"},
                                                         {"compiler", "saveinertial"},
                                                         {"position", "kv"},
                                                         {"position", "dampratio"},
                                                         {"position", "inheritrange"},
                                                         {"position", "timeconst"},
                                                         {"intvelocity", "kv"},
                                                         {"intvelocity", "dampratio"},
                                                         {"intvelocity", "inheritrange"},
                                                         {"", "actearly"},
                                                         {"", "actuatorfrcrange"},
                                                         {"", "actuatorfrclimited"}};
/// Sections that are dropped, with what replaces them.
constexpr std::pair<string_view, string_view> kReplaced[]{{"option", "the bench's options of the physics"},
                                                          {"size", ""},
                                                          {"visual", "the room's light"},
                                                          {"statistic", ""},
                                                          {"custom", ""},
                                                          {"sensor", "the bench's sensors"},
                                                          {"keyframe", "robot.yaml's posture"}};
/// Sections that a room does not need either.
constexpr string_view kOfRobots[]{"contact", "tendon", "equality", "actuator"};
/// Keys of `compiler` that are applied here.
constexpr string_view kPathKeys[]{"assetdir", "meshdir", "texturedir", "strippath"};
/// Attributes that name an asset.
constexpr string_view kAssetNames[]{"mesh", "material", "texture", "hfield"};

bool is_one_of(const auto& word, const auto& words) {
  return std::find(std::begin(words), std::end(words), word) != std::end(words);
}

/// Returns the file of an asset, whose folder the model's `compiler` element may set.
fs::path asset_file(const fs::path& model, const Element& compiler, const Element& asset,
                    const fs::path& given) {
  const fs::path name = compiler.get("strippath") == "true" ? given.filename() : given;
  const std::string kind = asset.name == "texture" ? "texturedir" : "meshdir";
  const std::string folder = compiler.get(compiler.find(kind) ? kind : "assetdir");
  std::error_code fault;
  fs::path file = model.parent_path() / folder / name;
  if (!fs::exists(file, fault)) file = asset.file->parent_path() / folder / name;  // in an included file
  return fs::absolute(file).lexically_normal();
}

/// Returns the keys of all `compiler` elements.
Element compiler_of(const Element& root) {
  Element compiler;
  for (const Element& section : root.children)
    if (section.name == "compiler")
      for (const auto& [name, value] : section.attributes) compiler.set(name, value);
  return compiler;
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
      reject(child, "file", "{} does not exist", file.string());
    if (!read.insert(fs::weakly_canonical(file, fault)).second)
      reject(child, "file", "{} is included twice", file.string());
    Element included = read_xml(file);
    expand(included, main_folder, read);
    std::ranges::move(included.children, std::back_inserter(expanded));
  }
  element.children = std::move(expanded);
}

/// Returns the mesh `scale` set by a default class or the classes above it, or nullptr.
const std::string* class_scale(const Element& parent, string_view wanted, const std::string* above) {
  for (const Element& child : parent.children)
    if (child.name == "mesh" && child.find("scale")) above = child.find("scale");
  if (parent.get("class") == wanted) return above;
  for (const Element& child : parent.children)
    if (const std::string* found = nullptr; child.name == "default")
      if (found = class_scale(child, wanted, above); found) return found;
  return nullptr;
}

class Reader {
 public:
  Reader(ModelFile& model, const Schema& schema, bool room)
      : model_(model), root_(model.root), known_(schema.root().children.at("mujoco")), room_(room) {}

  void read(string_view base) {
    if (!room_) keep_robot(base);
    std::erase_if(root_.children, [this](const Element& section) { return is_replaced(section); });
    take_assets();
    for (Element& section : root_.children) prepare(section);
    if (room_) mark_floors();
    write_compiler();
    check(root_, known_);
    keep_assets();
    show_meshes();
  }

 private:
  void note(Fate fate, string_view what, const Element& where) { add_note(model_.notes, fate, what, where); }

  bool is_replaced(const Element& section) {
    for (const auto& [name, instead] : kReplaced) {
      if (section.name != name || (room_ && name == "visual")) continue;
      note(Fate::dropped, instead.empty() ? section.name : fmt::format("{}: {}", name, instead), section);
      return true;
    }
    if (section.name == "contact" && !room_)
      for (const Element& each : section.children) {
        note(Fate::dropped, fmt::format("contact {}: the bench decides what touches what", each.name), each);
        if (each.name == "pair") model_.pairs.push_back(each);
      }
    return room_ ? is_one_of(section.name, kOfRobots) : section.name == "contact";
  }

  static std::size_t joints_in(const Element& body) {
    std::size_t count = 0;
    body.visit([&](const Element& each) { count += each.name == "joint"; });
    return count;
  }
  static bool has_body(const Element& body, string_view name) {
    bool found = false;
    body.visit([&](const Element& each) { found |= each.name == "body" && each.get("name") == name; });
    return found;
  }

  /// Drops everything in the world except the robot.
  void keep_robot(string_view base) {
    const Element* robot = nullptr;
    for (const Element& world : root_.children)
      for (const Element& each : world.children)
        if (world.name == "worldbody" && (each.name == "body" || each.name == "frame") &&
            (base.empty() || has_body(each, base)) && (!robot || joints_in(each) > joints_in(*robot)))
          robot = &each;
    if (!robot)
      reject(
          root_, "", "{}",
          base.empty() ? "has no body, expected a robot" : fmt::format("has no body '{}', the base", base));
    for (Element& world : root_.children)
      if (world.name == "worldbody") {
        std::vector<Element> kept;
        for (Element& each : world.children)
          if (&each == robot)
            kept.push_back(std::move(each));
          else
            drop_of_world(each);
        world.children = std::move(kept);
      }
  }

  void drop_of_world(const Element& part) {
    note(Fate::dropped, fmt::format("{} of the world", part.name), part);
    part.visit([this](const Element& each) {
      if (each.name == "joint" && each.find("name")) gone_.insert(each.get("name"));
    });
  }

  /// Keeps the assets that something names, with names and absolute paths.
  void take_assets() {
    std::set<std::string> used;
    const auto use = [&](const Element& user) {
      for (const string_view kind : kAssetNames)
        if (const std::string* const name = user.find(kind)) used.insert(fmt::format("{} {}", kind, *name));
    };
    for (const Element& section : root_.children)
      if (section.name != "asset") section.visit(use);
    const Element compiler = compiler_of(root_);
    for (const bool textures : {false, true})
      for (Element& section : root_.children)
        if (section.name == "asset")
          std::erase_if(section.children, [&](Element& asset) {
            if ((asset.name == "texture") != textures) return false;
            if (!asset.find("name") && asset.find("file"))
              asset.set("name", fs::path(asset.get("file")).stem().string());
            if (!used.contains(fmt::format("{} {}", asset.name, asset.get("name")))) {
              if (!room_)
                note(Fate::dropped, fmt::format("{} that the robot does not use", asset.name), asset);
              return true;
            }
            use(asset);
            take_asset(asset, compiler);
            return false;
          });
  }

  void take_asset(Element& asset, const Element& compiler) {
    for (auto& [name, value] : asset.attributes)
      if (name.starts_with("file") && !value.empty()) {
        const fs::path file = asset_file(*root_.file, compiler, asset, value);
        require_readable(asset, name, file);
        value = file.string();
      }
    if (asset.name == "mesh" && asset.find("inertia")) inertia_by_mesh_.insert(asset.get("name"));
  }

  /// Copies the assets for other files: without classes.
  void keep_assets() {
    const std::string* main = nullptr;  // scale of meshes
    for (const Element& section : root_.children)
      for (const Element& child : section.children)
        if (section.name == "default" && child.name == "mesh" && child.find("scale"))
          main = child.find("scale");
    for (const Element& section : root_.children)
      for (const Element& asset : section.children) {
        if (section.name != "asset" || asset.name == "material") continue;
        Element& kept = model_.assets.emplace_back(asset);
        kept.erase("class");
        if (asset.name != "mesh" || asset.find("scale")) continue;
        const std::string* scale = main;
        for (const Element& classes : root_.children)
          if (const std::string* found = nullptr; classes.name == "default")
            if (found = class_scale(classes, asset.get("class"), main); found) scale = found;
        if (scale) kept.set("scale", *scale);
      }
  }

  /// Drops, marks or rejects parts that the library does not know or the bench does not use.
  void prepare(Element& parent) {
    std::erase_if(parent.children, [&](const Element& child) {
      const bool fixed = parent.name == "body" && !child.get("mode").starts_with("target");
      const bool is_look = child.name == (room_ ? "camera" : "light") || (child.name == "camera" && !fixed);
      if (is_look) note(Fate::dropped, child.name, child);
      return is_look;
    });
    for (Element& child : parent.children) {
      if (child.name == "frame") make_body(child, parent);
      if (child.name == "body") require_gravity(child);
      if (child.name == "joint" && parent.name != "equality" && parent.name != "fixed") mark_limits(child);
      if (child.name == "geom") require_known_inertia(child, parent);
      if (child.name == "composite") reject(child, "", "is not read, expected bodies");
      if (room_ && child.get("type") == "directional") child.erase("type"), child.set("directional", "true");
      prepare(child);
    }
    if (parent.name == "equality")
      std::erase_if(parent.children, [](const Element& each) { return !is_coupling(each); });
    if (parent.name == "equality" || parent.name == "actuator")
      std::erase_if(parent.children, [this](const Element& each) {
        return gone_.contains(each.get("joint")) || gone_.contains(each.get("joint1"));
      });
  }

  static bool is_coupling(const Element& equality) {
    if (equality.name == "joint" || equality.name == "tendon") return true;
    if (equality.get("active") != "false")
      reject(equality, "", "closes a loop of bodies, expected a robot that is a tree");
    return false;
  }

  void make_body(Element& frame, const Element& parent) {
    note(Fate::converted, "frame: its contents are moved into the body", frame);
    for (const Element& each : frame.children)
      if (each.name.ends_with("joint") || each.name == "inertial")
        reject(each, "", "is in a frame, expected it directly in the body");
    frame.name = "body";
    frame.set("name", fmt::format("{}{}", kFrame, ++frames_));
    if (parent.child("inertial"))
      frame.add("inertial", {{"pos", "0 0 0"}, {"mass", "0"}, {"diaginertia", "0 0 0"}});
  }

  void require_gravity(Element& body) {
    const auto gravcomp = numbers(body, "gravcomp", 1, 1);
    if (gravcomp.empty()) return;
    if (gravcomp[0] != 0) reject(body, "gravcomp", "is not 0, expected gravity to act on the whole robot");
    note(Fate::converted, "body gravcomp 0: left out", body);
    body.erase("gravcomp");
  }

  void mark_limits(Element& joint) {
    joint.erase("user");
    joint.erase("group");
    if (!numbers(joint, "actuatorfrcrange", 2, 2).empty()) joint.set("user", joint.get("actuatorfrcrange"));
    if (const std::string limited = joint.get("actuatorfrclimited"); !limited.empty())
      joint.set("group", limited == "false" ? std::to_string(kForceUnlimited) : "1");
    joint.erase("actuatorfrcrange");
    joint.erase("actuatorfrclimited");
  }

  void require_known_inertia(Element& geom, const Element& body) {
    geom.erase("user");
    if (inertia_by_mesh_.contains(geom.get("mesh")) && body.name == "body" && !body.child("inertial") &&
        geom.get("mass") != "0" && geom.get("density") != "0")
      reject(geom, "mesh",
             "gives its body an inertia of a kind that this MuJoCo does not know (mesh inertia), expected an "
             "inertial in the body");
  }

  /// The class floor needs no declaration.
  void mark_floors() {
    bool found = false;
    Element* classes = nullptr;
    root_.visit([&](Element& each) {
      if (each.name != "default" || each.get("class") != "floor") return;
      found = true;
      const auto geom = std::ranges::find(each.children, "geom", &Element::name);
      (geom == each.children.end() ? each.add("geom") : *geom).set("user", "1");
    });
    if (found) return;
    for (Element& section : root_.children)
      if (section.name == "default") classes = &section;
    if (!classes) {
      root_.children.insert(root_.children.begin(), Element{"default", {}, {}, root_.file, root_.line});
      classes = &root_.children.front();
    }
    classes->add("default", {{"class", "floor"}}).add("geom", {{"user", "1"}});
  }

  void show_meshes() {
    Element world{"worldbody", {}, {}, root_.file, root_.line};
    Element& body = world.add("body", {{"name", kMeshes}});
    body.add("inertial", {{"pos", "0 0 0"}, {"mass", "0"}, {"diaginertia", "0 0 0"}});
    for (const Element& asset : model_.assets)
      if (asset.name == "mesh")
        body.add("geom", {{"type", "mesh"},
                          {"mesh", asset.get("name")},
                          {"pos", "0 0 0"},
                          {"quat", "1 0 0 0"},
                          {"mass", "0"}});
    root_.children.push_back(std::move(world));
  }

  void write_compiler() {
    for (Element& section : root_.children)
      if (section.name == "compiler") {
        for (const string_view key : kPathKeys) section.erase(key);
        for (const char* key : {"fusestatic", "discardvisual"}) section.erase(key);
        if (const auto total = numbers(section, "settotalmass", 1, 1); !total.empty() && total[0] > 0)
          note(Fate::converted, fmt::format("settotalmass: masses scaled to {} kg", total[0]), section);
      }
    Element first{"compiler", {{"autolimits", "true"}}, {}, root_.file, root_.line};
    root_.children.insert(root_.children.begin(), std::move(first));
    if (room_)
      root_.add("option").add("flag", {{"contact", "disable"}});  // too many for the library's buffer
  }

  /// Drops parts that only newer library versions know and the bench does not need. Rejects anything else
  /// unknown.
  void check(Element& element, const Schema::Known& known) {
    std::erase_if(element.attributes, [&](const auto& attribute) {
      if (known.attributes.contains(attribute.first)) return false;
      const string_view name = attribute.first;
      if (!is_one_of(std::pair<string_view, string_view>(element.name, name), kDropped) &&
          !is_one_of(std::pair<string_view, string_view>("", name), kDropped))
        reject(element, name, "is not known to this MuJoCo, expected one of {}",
               fmt::join(known.attributes, ", "));
      note(Fate::dropped, fmt::format("{} {}", element.name, name), element);
      return true;
    });
    for (Element& child : element.children) {
      const auto found = known.children.find(child.name);
      const bool same = known.recursive && child.name == element.name;
      if (!same && found == known.children.end())
        reject(child, "", "is not known to this MuJoCo in {}", element.name);
      check(child, same ? known : found->second);
    }
  }

  ModelFile& model_;
  Element& root_;
  const Schema::Known& known_;
  bool room_;
  int frames_ = 0;
  std::set<std::string> inertia_by_mesh_;  // meshes
  std::set<std::string> gone_;             // joints that are not the robot's
};

/// The library misreads such numbers without an error.
void require_finite(const Element& element) {
  for (const auto& [name, value] : element.attributes) {
    std::istringstream words(value);
    for (std::string word; words >> word;)
      if (word == "nan" || word == "-nan" || word == "inf" || word == "-inf")
        reject(element, name, "is '{}', expected a finite number", word);
  }
}

/// read: receives the files.
ModelFile whole_file(const fs::path& file, std::set<fs::path>& read) {
  std::error_code fault;
  read.insert(fs::weakly_canonical(file, fault));
  ModelFile model{.root = read_xml(file)};
  if (model.root.name != "robot") expand(model.root, file.parent_path(), read);
  std::as_const(model.root).visit(require_finite);
  return model;
}

}  // namespace

void add_note(std::vector<Note>& notes, Fate fate, string_view what, const Element& where) {
  for (Note& note : notes)
    if (note.fate == fate && note.what == what) {
      ++note.count;
      return;
    }
  notes.push_back({fate, std::string(what), fmt::format("{}:{}", where.file->string(), where.line)});
}

const Element& ModelFile::named(string_view kind, string_view name) const {
  const Element* found = &root;
  root.visit([&](const Element& each) {
    const bool is_kind = each.name == kind || (kind == "body" && each.name == "link");
    if (found == &root && is_kind && each.get("name") == name) found = &each;
  });
  return *found;
}

void require_readable(const Element& asset, string_view attribute, const fs::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? char(c | 0x20) : c; });
  const bool is_texture = asset.name == "texture";
  const bool is_read = is_texture ? ending == ".png" : is_one_of(ending, std::array{".stl", ".obj", ".msh"});
  if (!is_read && asset.name != "hfield")
    reject(asset, attribute, "is '{}', expected a {} file", file.filename().string(),
           is_texture ? ".png" : ".stl or .obj");
  std::error_code fault;
  if (!fs::is_regular_file(file, fault)) reject(asset, attribute, "{} does not exist", file.string());
}

ModelFile read_model(const fs::path& file, const Schema& schema, string_view base, const Packages& packages) {
  std::set<fs::path> read;
  ModelFile model = whole_file(file, read);
  if (model.root.name == "robot") {
    prepare_urdf(model, packages);
  } else {
    if (model.root.name != "mujoco")
      reject(model.root, "", "is not a model, expected mujoco (MJCF) or robot (URDF)");
    Reader(model, schema, false).read(base);
  }
  return model;
}

ModelFile read_room(const fs::path& file, const Schema& schema) {
  std::set<fs::path> read;
  ModelFile model = whole_file(file, read);
  if (model.root.name != "mujoco") reject(model.root, "", "is not a room, expected mujoco (MJCF)");
  Reader(model, schema, true).read("");
  return model;
}

std::vector<fs::path> files_of(const fs::path& file, const Packages& packages) {
  std::set<fs::path> read;
  ModelFile model = whole_file(file, read);
  if (model.root.name == "robot") prepare_urdf(model, packages);
  for (const auto& [name, mesh] : model.files) read.insert(mesh);
  const Element compiler = compiler_of(model.root);
  std::error_code fault;
  for (const Element& section : model.root.children)
    for (const Element& asset : section.children)
      for (const auto& [name, value] : asset.attributes)
        if (section.name == "asset" && name.starts_with("file"))
          if (const fs::path path = asset_file(file, compiler, asset, value);
              fs::is_regular_file(path, fault))
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
