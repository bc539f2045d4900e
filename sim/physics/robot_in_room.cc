#include "sim/physics/robot_in_room.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>

#include "sim/physics/adapted.h"
#include "sim/physics/compiled.h"
#include "sim/physics/options.h"

namespace sim::physics {
namespace {

using model_file::Element;

constexpr double kNotLevel = 0.001;  // m

bool is_floor(const Element& geom) { return geom.get("contype") == std::to_string(model_file::kSteppedBits); }

/// Removes everything but shapes of class floor. Returns whether a plane or a height field is left.
bool keep_floors(Element& parent) {
  bool wide = false;
  std::erase_if(parent.children, [&](Element& child) {
    if (child.name == "body") wide |= keep_floors(child);
    const bool kept =
        child.name == "body" ? !child.children.empty() : child.name == "geom" && is_floor(child);
    wide |= kept && (child.get("type") == "plane" || child.get("type") == "hfield");
    return !kept;
  });
  return wide;
}

/// Returns a room's lights and shapes. Geoms of class floor have the contact bits kSteppedBits.
Element adapted_room(const std::filesystem::path& file) {
  const model_file::ModelFile room = read_room(file, schema());
  const Model compiled = load_mjcf(room.root, file.string());
  mjModel& m = *compiled;
  const Writer writer(m, room, "");
  const auto name = [&](int type, int id) { return writer.name(type, id); };
  if (m.njnt > 0)
    reject(room.named("joint", name(mjOBJ_JOINT, 0)), "", "is in a room, expected shapes that do not move");
  for (int light = 0; light < m.nlight; ++light)
    if (m.light_active[light] && !m.light_directional[light])
      reject(room.named("light", name(mjOBJ_LIGHT, light)), "directional",
             "is false, expected true: brightness must not depend on position");
  const Data data(mj_makeData(&m));
  mj_kinematics(&m, data.get());
  bool has_floor = false, is_wide = false;
  int plain = -1;
  for (int geom = 0; geom < m.ngeom; ++geom) {
    const bool is_plane = m.geom_type[geom] == mjGEOM_PLANE;
    if (is_plane && std::min(m.geom_size[3 * geom], m.geom_size[3 * geom + 1]) <= 0)
      reject(room.named("geom", name(mjOBJ_GEOM, geom)), "size", "is 0, expected positive half lengths");
    if (m.nuser_geom > 0 && m.geom_user[m.nuser_geom * geom] == 1) {
      m.geom_contype[geom] = m.geom_conaffinity[geom] = model_file::kSteppedBits;
      has_floor = true;
      is_wide |= is_plane || m.geom_type[geom] == mjGEOM_HFIELD;
    } else if (is_plane && name(mjOBJ_GEOM, geom) == "floor") {
      plain = geom;
    }
  }
  if (plain >= 0) {
    const Eigen::Isometry3d X = geom_pose(*data, plain);
    const Element& element = room.named("geom", "floor");
    if (is_wide)
      reject(element, "",
             "the plane 'floor' is not of class floor, but other planes or height fields are: "
             "expected the class floor for it, too, or no such plane");
    if (std::abs(X.translation().z()) > kNotLevel || X.linear()(2, 2) < 1 - kNotLevel * kNotLevel)
      reject(element, "",
             fmt::format("the plane 'floor' is at z = {:.4g} m or tilted, expected z = 0, or class "
                         "floor",
                         X.translation().z()));
  } else if (!has_floor) {
    reject(room.named("worldbody", ""), "",
           "has no plane named 'floor' and no shape of class floor, expected a floor to walk on");
  }
  Element root{"mujoco"};
  for (const Element& section : room.root.children)
    if (section.name == "visual") root.children.push_back(section);
  Element world{"worldbody"};
  writer.add_content(0, world);
  root.children.push_back(std::move(world));
  writer.add_sections(root);
  return root;
}

/// Renames parts of a room that have the same name as a part of the robot.
void rename_clashes(Element& room, const Element& robot) {
  std::set<std::pair<std::string, std::string>> taken;
  robot.visit([&](const Element& each) { taken.emplace(each.name, each.get("name")); });
  room.visit([&](Element& each) {
    if (each.find("name") && taken.contains({each.name, each.get("name")}))
      each.set("name", each.get("name") + " of the room");
  });
}

/// Gives bodies the quaternions of the file to the last bit: the library normalizes them again.
void keep_quaternions(const Element& element, mjModel& m) {
  for (const Element& child : element.children) {
    if (child.name == "body") {
      keep_quaternions(child, m);
      const int body = mj_name2id(&m, mjOBJ_BODY, child.get("name").c_str());
      if (body < 0) continue;
      std::ranges::copy(numbers(child, "quat", 4, 4), m.body_quat + 4 * body);
      std::ranges::copy(numbers(*child.child("inertial"), "quat", 4, 4), m.body_iquat + 4 * body);
    }
  }
}

}  // namespace

Model join(const Element& robot, const std::string& room, const std::filesystem::path& models,
           Shapes shapes) {
  const auto file_of = [&](const std::string& name) {
    return NameOrPath(name).is_path() ? std::filesystem::path(name) : models / (name + ".xml");
  };
  std::vector<Element> parts{robot, adapted_room(file_of(room))};
  Element whole{"mujoco", robot.attributes};
  if (shapes == Shapes::floor) {
    whole.add("compiler", {{"discardvisual", "true"}});
    Element& world = *std::ranges::find(parts[1].children, "worldbody", &Element::name);
    const bool wide = keep_floors(world);
    const bool none = world.children.empty();
    if (!wide) parts.insert(parts.begin() + 1, adapted_room(file_of(kPhysicalRoom)));
    if (none) parts.pop_back();
  }
  for (Element& part : parts) {
    if (&part != &parts[0]) rename_clashes(part, robot);
    std::ranges::move(part.children, std::back_inserter(whole.children));
  }
  Model model = load_mjcf(whole, fmt::format("the robot in {}", room));
  keep_quaternions(*robot.child("worldbody"), *model);
  mj_setConst(model.get(), Data(mj_makeData(model.get())).get());
  return model;
}

Model load_model(const RobotFile& robot, const std::string& room, const std::filesystem::path& models,
                 Shapes shapes) {
  return join(adapt(robot).root, room, models, shapes);
}

}  // namespace sim::physics
