#include "sim/physics/compiled.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace sim::physics {
namespace {

using model_file::Element, model_file::Fate;

// Mass (kg) and size (m) above which the file's units must be grams or millimeters.
constexpr double kHeaviest_kg = 1000, kLargest_m = 20;
// A link's moment of inertia has wrong units if it exceeds this fraction of the robot's mass times its
// size squared and the radius of gyration exceeds that size.
constexpr double kMomentShare = 1e-3;
// A link with a radius of gyration below this fraction of its size counts as a point.
constexpr double kPointShare = 0.03;

Effort ordered(double factor, const mjtNum* range) {
  const auto [lowest, highest] = std::minmax(factor * range[0], factor * range[1]);
  return {lowest, highest};
}
Effort common(const Effort& a, const Effort& b) {
  return {std::max(a.lowest, b.lowest), std::min(a.highest, b.highest)};
}

/// Returns the torques of an actuator on its joint.
Effort effort_of(const mjModel& m, int actuator) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  Effort force{-kNone, kNone};
  if (m.actuator_forcelimited[actuator]) force = ordered(1, m.actuator_forcerange + 2 * actuator);
  const int dynamics = m.actuator_dyntype[actuator];
  if (m.actuator_ctrllimited[actuator] && m.actuator_gaintype[actuator] == mjGAIN_FIXED &&
      m.actuator_biastype[actuator] == mjBIAS_NONE && (dynamics == mjDYN_NONE || dynamics == mjDYN_FILTER))
    force =
        common(force, ordered(m.actuator_gainprm[mjNGAIN * actuator], m.actuator_ctrlrange + 2 * actuator));
  const double gear = m.actuator_gear[6 * actuator];
  if (gear == 0) return {};
  const mjtNum range[2] = {force.lowest, force.highest};
  return ordered(gear, range);
}

void read_efforts(CompiledRobot& robot) {
  const mjModel& m = *robot.model;
  constexpr double kNone = std::numeric_limits<double>::infinity();
  std::map<int, Effort> sums;
  for (int actuator = 0; actuator < m.nu; ++actuator) {
    const int kind = m.actuator_trntype[actuator];
    const Element& element = robot.file.named("actuator", "");
    if (kind != mjTRN_JOINT && kind != mjTRN_JOINTINPARENT) {
      add_note(robot.file.notes, Fate::dropped, "actuator that does not act on a joint", element);
      continue;
    }
    const Effort effort = effort_of(m, actuator);
    Effort& sum = sums[m.actuator_trnid[2 * actuator]];
    sum = {sum.lowest + effort.lowest, sum.highest + effort.highest};
  }
  for (int joint = 0; joint < m.njnt; ++joint) {
    const std::string name = name_of(m, mjOBJ_JOINT, joint);
    Effort effort{-kNone, kNone};
    if (const auto sum = sums.find(joint); sum != sums.end()) effort = sum->second;
    const mjtNum* const range = m.jnt_user + m.nuser_jnt * joint;
    if (m.nuser_jnt >= 2 && (range[0] != 0 || range[1] != 0) &&
        m.jnt_group[joint] != model_file::kForceUnlimited)
      effort = common(effort, ordered(1, range));
    if (const auto known = robot.file.efforts.find(name); known != robot.file.efforts.end())
      effort = {-known->second, known->second};
    if (std::isinf(effort.lowest) && std::isinf(effort.highest)) continue;
    const Element& element = robot.file.named("joint", name);
    if (!(effort.lowest < effort.highest))
      reject(element, "", "'{}' has torques from {:g} to {:g} N m, expected a range", name, effort.lowest,
             effort.highest);
    robot.efforts[name] = effort;
    add_note(robot.file.notes, Fate::kept_aside, "effort limits of joints", element);
  }
}

bool is_below(const mjModel& m, int body, int above) {
  while (body > above) body = m.body_parentid[body];
  return body == above;
}

/// The base is the first body that has mass or several bodies with mass below it.
void find_base(CompiledRobot& robot, const std::string& wanted) {
  const mjModel& m = *robot.model;
  int base = 0;
  for (int body = m.nbody - 1; body > 0; --body)
    if (m.body_parentid[body] == 0 && name_of(m, mjOBJ_BODY, body) != model_file::kMeshes) base = body;
  const int root = base;
  while (m.body_mass[base] == 0) {
    std::vector<int> heavy;
    for (int body = base + 1; body < m.nbody; ++body)
      if (m.body_parentid[body] == base && m.body_subtreemass[body] > 0) heavy.push_back(body);
    if (heavy.size() != 1 || m.body_jntnum[heavy[0]] > 0) break;
    base = heavy[0];
  }
  const std::string name = name_of(m, mjOBJ_BODY, base);
  const Element& element = robot.file.named("body", wanted.empty() ? name : wanted);
  if (!wanted.empty() && wanted != name)
    reject(element, "", "'{}' cannot be the base, expected '{}', the first body with mass", wanted, name);
  const int* const types = m.jnt_type + m.body_jntadr[root];
  constexpr std::array kFour{mjJNT_SLIDE, mjJNT_SLIDE, mjJNT_SLIDE, mjJNT_BALL};
  const bool is_free = m.body_jntnum[root] == 1 && types[0] == mjJNT_FREE,
             is_four = m.body_jntnum[root] == 4 && std::equal(kFour.begin(), kFour.end(), types);
  if (!is_free && !is_four)
    reject(element, "", "'{}' is the base but has no free joint, expected <freejoint/>", name);
  if (is_four) add_note(robot.file.notes, Fate::converted, "three slides and a ball: a freejoint", element);
  if (base != root)
    add_note(robot.file.notes, Fate::dropped, fmt::format("bodies without mass above '{}', the base", name),
             element);
  robot.base = base;
}

/// Returns the box around the body's shapes, the points of the bodies below, and its own point, in W.
Eigen::AlignedBox3d body_box(const mjModel& m, const mjData& data, int body) {
  Eigen::AlignedBox3d box{Eigen::Vector3d(data.xpos + 3 * body)};
  for (int below = body + 1; below < m.nbody; ++below)
    if (m.body_parentid[below] == body) box.extend(Eigen::Vector3d(data.xpos + 3 * below));
  for (int geom = 0; geom < m.ngeom; ++geom)
    if (m.geom_bodyid[geom] == body)
      for (const Eigen::Vector3d& p : corners(m, data, geom, Eigen::Isometry3d::Identity())) box.extend(p);
  return box;
}

void require_units(CompiledRobot& robot) {
  const mjModel& m = *robot.model;
  const Data data(mj_makeData(&m));
  mj_kinematics(&m, data.get());
  mj_comPos(&m, data.get());
  Eigen::AlignedBox3d whole;
  for (int body = robot.base; body < m.nbody; ++body)
    if (is_below(m, body, robot.base)) whole.extend(body_box(m, *data, body));
  const Element& base = robot.file.named("body", name_of(m, mjOBJ_BODY, robot.base));
  const double mass = m.body_subtreemass[robot.base], size = whole.diagonal().norm();
  if (mass > kHeaviest_kg)
    reject(base, "", "the robot weighs {:.4g} kg, expected kilograms: are the masses in grams?", mass);
  if (size > kLargest_m)
    reject(base, "",
           "the robot is {:.4g} m large, expected meters: are lengths or meshes in "
           "millimeters (scale)?",
           size);
  for (int body = robot.base; body < m.nbody; ++body) {
    if (!is_below(m, body, robot.base) || !(m.body_mass[body] > 0)) continue;
    const mjtNum* const moments = m.body_inertia + 3 * body;
    const double most = *std::max_element(moments, moments + 3), radius = std::sqrt(most / m.body_mass[body]);
    const std::string name = name_of(m, mjOBJ_BODY, body);
    const Element& element = robot.file.named("body", name);
    if (size > 0 && radius > size && most > kMomentShare * mass * size * size)
      reject(element, "",
             "'{}' has {:.4g} kg and a moment of inertia of {:.4g} kg m^2, as if its mass were "
             "{:.3g} m from its center: expected kg m^2",
             name, m.body_mass[body], most, radius);
    const double length = body_box(m, *data, body).diagonal().norm();
    if (m.body_jntnum[body] > 0 && radius < kPointShare * length)
      add_note(robot.file.notes, Fate::doubtful, "moments of inertia as small as a point's, expected kg m^2",
               element);
  }
}

}  // namespace

const model_file::Schema& schema() {
  static const model_file::Schema known = [] {
    std::vector<char> printed(1 << 20);
    mj_printSchema(nullptr, printed.data(), int(printed.size()), 0, 0);
    return model_file::Schema(printed.data());
  }();
  return known;
}

CompiledRobot compile_robot(const fs::path& file, const std::string& base,
                            const model_file::Packages& packages) {
  CompiledRobot robot;
  robot.file = read_model(file, schema(), base, packages);
  robot.model = load_mjcf(robot.file.root, file.string(), robot.file.files);
  find_base(robot, base);
  read_efforts(robot);
  require_units(robot);
  for (const Element& pair : robot.file.pairs)
    for (const auto& [mine, other] : {std::pair("geom1", "geom2"), {"geom2", "geom1"}})
      if (mj_name2id(robot.model.get(), mjOBJ_GEOM, pair.get(other).c_str()) < 0)
        robot.paired_with_floor.push_back(pair.get(mine));
  return robot;
}

Element written_base(const CompiledRobot& robot, const Writer& writer) {
  const mjModel& m = *robot.model;
  std::optional<Eigen::Isometry3d> X;  // pose of the body above the base
  int root = robot.base;
  while (m.body_parentid[root] != 0) {
    root = m.body_parentid[root];
    X = turned_pose_in(m.body_pos + 3 * root, m.body_quat + 4 * root) *
        X.value_or(Eigen::Isometry3d::Identity());
  }
  Element base = writer.body(robot.base, X ? &*X : nullptr);
  std::erase_if(base.children, [](const Element& child) { return child.name.ends_with("joint"); });
  Element free{"freejoint"};
  if (m.jnt_type[0] == mjJNT_FREE)
    if (const std::string name = name_of(m, mjOBJ_JOINT, 0); !name.empty()) free.set("name", name);
  base.children.insert(base.children.begin(), std::move(free));
  return base;
}

}  // namespace sim::physics
