#include "sim/physics/adapted.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mujoco/mujoco.h>

#include <algorithm>

#include "sim/physics/compiled.h"

namespace sim::physics {
namespace {

using model_file::Element, model_file::Fate, model_file::text_of;

constexpr std::array kFootSides{"right", "left"};  // as walking::Side
// Contact bits: with the floor and with the other foot.
constexpr int kFloorBit = 1, kFeetBit = 2;
constexpr int kHidden = 3;  // first group that is not drawn

class Adapter {
 public:
  explicit Adapter(const RobotFile& robot)
      : robot_(robot),
        mine_(compile_robot(robot.folder / robot.model, robot.base, robot.packages)),
        m_(*mine_.model),
        writer_(m_, mine_.file, "robot/"),
        foot_of_(std::size_t(m_.nbody), robot.feet.end()) {}

  AdaptedRobot adapt() {
    find_feet();
    head_ = m_.body_weldid[upper_body("head_camera", robot_.head_camera.link)];
    require_contacts_named();
    for (int body = mine_.base; body < m_.nbody; ++body) adapt_shapes(body);
    for (std::size_t side = 0; side < 2; ++side) require_sole(side);
    std::vector<Element> servos = this->servos();
    for (std::size_t side = 0; side < 2; ++side) {
      const RobotFile::Foot& foot = robot_.feet[side];
      const Eigen::Isometry3d X_BS = Eigen::Translation3d(foot.sole_m) *
                                     Eigen::AngleAxisd(foot.sole_yaw_rad, Eigen::Vector3d::UnitZ()) *
                                     Eigen::AngleAxisd(foot.sole_pitch_rad, Eigen::Vector3d::UnitY()) *
                                     Eigen::AngleAxisd(foot.sole_roll_rad, Eigen::Vector3d::UnitX());
      add_at("site", fmt::format("{}_sole", kFootSides[side]),
             body(fmt::format("feet.{}", kFootSides[side]), foot.body), X_BS);
    }
    add_at("site", "imu", upper_body("imu", robot_.imu.link), rig::pose(robot_.imu));
    Eigen::Matrix3d R_LM;  // MuJoCo's camera: x right, y up, looking along -z
    R_LM << 0, 0, -1, -1, 0, 0, 0, 1, 0;
    add_at("camera", "head_camera", upper_body("head_camera", robot_.head_camera.link),
           rig::pose(robot_.head_camera) * Eigen::Isometry3d(Eigen::Quaterniond(R_LM)));
    make_rigid();
    Element root{"mujoco",
                 {{"model", mine_.file.root.get(mine_.file.root.name == "robot" ? "name" : "model")}}};
    root.add("compiler", {{"angle", "radian"}});
    root.add("option", {{"timestep", "0.001"},
                        {"gravity", "0 0 -9.81"},
                        {"cone", "elliptic"},
                        {"impratio", "10"},
                        {"solver", "Newton"},
                        {"jacobian", "sparse"}});
    root.add("worldbody").children.push_back(written_base(mine_, writer_));
    writer_.add_sections(root);
    root.add("actuator").children = std::move(servos);
    Element& sensors = root.add("sensor");
    for (const char* side : kFootSides)
      for (const char* kind : {"force", "torque"})
        sensors.add(kind,
                    {{"name", fmt::format("{}_{}", side, kind)}, {"site", fmt::format("{}_sole", side)}});
    return {std::move(root), std::move(mine_.file.notes)};
  }

 private:
  using Foot = std::array<RobotFile::Foot, 2>::const_iterator;

  std::string name(int type, int id) const { return writer_.name(type, id); }
  int bits(int geom) const { return m_.geom_contype[geom] | m_.geom_conaffinity[geom]; }
  void set_bits(int geom, int type, int affinity) {
    m_.geom_contype[geom] = type, m_.geom_conaffinity[geom] = affinity;
  }

  /// A foot consists of its body and everything fixed to it.
  void find_feet() {
    for (int body = mine_.base; body < m_.nbody; ++body) {
      const Foot own = std::ranges::find(robot_.feet, name(mjOBJ_BODY, body), &RobotFile::Foot::body);
      const bool moves = own != robot_.feet.end() || m_.body_jntnum[body] > 0;
      foot_of_[std::size_t(body)] = moves ? own : foot_of_[std::size_t(m_.body_parentid[body])];
      if (foot_of_[std::size_t(body)] == robot_.feet.end()) continue;
      for (int geom = 0; geom < m_.ngeom; ++geom)
        feet_touch_floor_ |= m_.geom_bodyid[geom] == body && (bits(geom) & kFloorBit) != 0;
    }
  }

  void require_contacts_named() const {
    if (!mine_.paired_with_floor.empty() && robot_.feet[0].contacts.empty() &&
        robot_.feet[1].contacts.empty())
      reject(mine_.file.pairs.front(), "",
             "of '{}' names a geom that is not of the robot: expected the contacts of each foot in "
             "robot.yaml",
             mine_.paired_with_floor[0]);
  }

  int body(const std::string& key, const std::string& wanted) const {
    std::vector<std::string> names;
    for (int body = mine_.base; body < m_.nbody; ++body) {
      const std::string own = name(mjOBJ_BODY, body);
      if (own.empty() || own == model_file::kMeshes || writer_.owner(body) != body) continue;
      if (own == wanted) return body;
      names.push_back(own);
    }
    std::ranges::sort(names);
    robot_.fail(key, "the model has no body '{}', expected one of {}", wanted, fmt::join(names, ", "));
  }

  /// Returns a body that no joint of a leg moves.
  int upper_body(const std::string& key, const std::string& wanted) const {
    const int found = body(key, wanted);
    for (int above = found; above > mine_.base; above = m_.body_parentid[above])
      for (const auto& leg : robot_.legs)
        for (int k = 0; k < m_.body_jntnum[above]; ++k)
          if (std::ranges::count(leg, name(mjOBJ_JOINT, m_.body_jntadr[above] + k)) > 0)
            robot_.fail(key, "link '{}' is moved by a leg, expected an upper-body link", wanted);
    return found;
  }

  void add_at(const char* kind, const std::string& name, int body, const Eigen::Isometry3d& X) {
    const Eigen::Quaterniond q(X.linear());
    writer_.additions[body].push_back({kind,
                                       {{"name", name},
                                        {"pos", text_of(X.translation())},
                                        {"quat", text_of(std::array{q.w(), q.x(), q.y(), q.z()})}}});
  }

  void adapt_shapes(int body) {
    const Foot foot = foot_of_[std::size_t(body)];
    const bool in_foot = foot != robot_.feet.end(), is_head = m_.body_weldid[body] == head_;
    bool has_looks = false, has_others = false;
    std::vector<int> geoms, soles;
    for (int geom = 0; geom < m_.ngeom; ++geom) {
      if (writer_.owner(m_.geom_bodyid[geom]) != body) continue;
      geoms.push_back(geom);
      if (in_foot && is_sole(geom, *foot)) {
        soles.push_back(geom);
        continue;
      }
      has_looks |= bits(geom) == 0;
      has_others |= bits(geom) != 0;
    }
    for (const int geom : geoms) {
      const bool hidden = m_.geom_group[geom] >= kHidden || (bits(geom) != 0 && has_looks);
      m_.geom_group[geom] = hidden ? kHidden : is_head ? 2 : 1;
      if (std::ranges::count(soles, geom) > 0) {
        has_others ? set_bits(geom, kFloorBit, 0) : set_bits(geom, kFloorBit | kFeetBit, kFeetBit);
        m_.geom_priority[geom] = 1;  // this geom's friction counts
      } else {
        const int touches = in_foot && bits(geom) != 0 ? kFeetBit : 0;
        set_bits(geom, touches, touches);
      }
    }
    if (in_foot) soles_[std::size_t(foot - robot_.feet.begin())] += soles.size();
  }

  // `contacts` may name geoms that touch the floor only through a contact pair. Without names: the geoms that
  // touch the floor, or all geoms that touch anything if the model's floor has different contact bits.
  bool is_sole(int geom, const RobotFile::Foot& foot) const {
    if (!foot.contacts.empty()) return std::ranges::count(foot.contacts, name(mjOBJ_GEOM, geom)) > 0;
    return bits(geom) != 0 && ((bits(geom) & kFloorBit) != 0 || !feet_touch_floor_);
  }

  void require_sole(std::size_t side) const {
    const RobotFile::Foot& foot = robot_.feet[side];
    const std::string key = fmt::format("feet.{}", kFootSides[side]);
    body(key, foot.body);
    if (soles_[side] == 0 && foot.contacts.empty())
      robot_.fail(key,
                  "body '{}' has no colliding geom, expected the sole; if a scene.xml beside the "
                  "model has contact pairs, name it as the model",
                  foot.body);
    if (soles_[side] < foot.contacts.size())
      robot_.fail(key, "of the contacts {} body '{}' has {}, expected colliding geoms with these names in it",
                  fmt::join(foot.contacts, ", "), foot.body, soles_[side]);
  }

  /// Returns the servos in the order of their joints.
  std::vector<Element> servos() {
    std::map<int, Element> servos;
    for (const RobotFile::Servo& servo : robot_.servos)
      for (const std::string& name : servo.joints) {
        const int joint = mj_name2id(&m_, mjOBJ_JOINT, name.c_str());
        if (joint < 0) robot_.fail("servos", "the model has no joint '{}'", name);
        const Element& element = mine_.file.named("joint", name);
        if (m_.jnt_type[joint] != mjJNT_HINGE)
          reject(element, "type", "of '{}' is not hinge, expected a hinge for a servo", name);
        if (!m_.jnt_limited[joint])
          reject(element, "range", "'{}' has none, expected its smallest and largest angle", name);
        const int dof = m_.jnt_dofadr[joint];
        m_.dof_damping[dof] = servo.kd_nms_rad;
        if (servo.armature_kg_m2) m_.dof_armature[dof] = *servo.armature_kg_m2;
        Element made{"position",
                     {{"name", name}, {"joint", name}, {"kp", text_of(std::array{servo.kp_nm_rad})}}};
        std::optional<Effort> effort;
        if (servo.effort_nm)
          effort = {-*servo.effort_nm, *servo.effort_nm};
        else if (const auto known = mine_.efforts.find(name); known != mine_.efforts.end())
          effort = known->second;
        made.set("forcelimited", effort ? "true" : "false");
        if (effort) made.set("forcerange", text_of(std::array{effort->lowest, effort->highest}));
        if (!servos.emplace(joint, std::move(made)).second)
          robot_.fail("servos", "joint '{}' has two servos", name);
        moving_.insert(joint);
      }
    std::vector<Element> all;
    for (auto& [joint, servo] : servos) all.push_back(std::move(servo));
    return all;
  }

  void make_rigid() {
    for (int joint = 0; joint < m_.njnt; ++joint) {
      const bool of_base = m_.body_parentid[m_.jnt_bodyid[joint]] == 0;
      if (of_base || moving_.contains(joint) || m_.jnt_stiffness[joint] > 0) continue;
      writer_.rigid.insert(joint);
      add_note(mine_.file.notes, Fate::converted, "joint without servo and stiffness: rigid",
               mine_.file.named("joint", name(mjOBJ_JOINT, joint)));
    }
  }

  const RobotFile& robot_;
  CompiledRobot mine_;
  mjModel& m_;
  Writer writer_;
  int head_ = 0;               // to what the head camera is fixed
  std::vector<Foot> foot_of_;  // the foot that each body is part of
  bool feet_touch_floor_ = false;
  std::array<std::size_t, 2> soles_{};  // number of geoms, by side
  std::set<int> moving_;                // joints
};

}  // namespace

AdaptedRobot adapt(const RobotFile& robot) { return Adapter(robot).adapt(); }

}  // namespace sim::physics
