#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <span>

#include "sim/files/yaml.h"
#include "sim/physics/adapted.h"
#include "sim/physics/found_sensors.h"

namespace sim::physics {
namespace {

using Eigen::Vector3d;

// Gains that work for walking robots of 33 and 57 kg, per kg of mass (N m/rad, N m s/rad and kg m^2 per kg).
// The armature is typical of geared motors in such robots; without any, stiff light links swing. With three
// times the damping, ankles chatter on the floor, because MuJoCo computes contact forces without the implicit
// damping of its step.
struct Gains {
  double kp, kd, armature;
};
constexpr Gains kLeg{120, 1.8, 4e-4}, kAnkle{40, 0.2, 4e-4}, kOther{12, 0.2, 1e-4};
// The ankle admittance times mass and height of the center of mass, because torques grow with both. Tried on
// robots of 18 to 95 kg. The height is assumed to be at least 0.45 m.
constexpr double kAdmittance = 1.0, kLeastHeight_m = 0.45;
constexpr const char* kGuessedGait =
    "guess: slower, lower, shorter steps than those of robots with rubber bushes at their ankles";
// The longest step ahead: a fraction of the height of the center of mass, up to a limit.
constexpr double kStepShare = 0.22, kLongestStep_m = 0.12;
// The fraction of the ankle's torque limit that standing on one foot may need.
constexpr double kAnkleShare = 0.65;
// Hips count as weak if the torque limit of their roll joints is below this multiple of the torque for
// standing on one foot, which is the weight times half the distance between the feet. Faster steps with the
// zero moment point closer to the middle then help.
constexpr double kWeakHips = 1.3;
constexpr const char* kWalk =
    R"(# {}
walk: {{single_support_s: {:.3g}, double_support_s: {:.3g}, step_height_m: {:.3g}, step_length_m: {:.3g}, zmp_inwards_m: {:.3g}, steering: {{by: legs}}}}
stabilizer: {{ankle_admittance: {{gain_rad_s_per_nm: {:.2g}}}, landing_adjustment: {{enabled: true}}}}
)";
constexpr const char* kNoises = R"(# guess: leg odometry of a robot that nobody has measured
slam:
  height: {sigma_m: 0.001}
  leg_odometry: {sigma_position_m: 0.0001, sigma_m_s: 0.008, sigma_stride: 0.006, sigma_sway_m_s: 0.003, sigma_sway_scale: 0.003}
)";
constexpr const char* kRig =
    "# Further sensors of the model, for any scenario: gaitslam run SCENARIO --with rig.yaml\nrig:\n";
constexpr double kDegrees = 180 / std::numbers::pi, kBend_deg = 20, kLeastDamping = 1e-6;
constexpr int kLevelingSteps = 20;
constexpr double kLevel = 0.02;  // m and rad
// A face of a foot is its sole if it points down within 30 degrees. Faces are the same if their normals agree
// within one degree. Anything this close to the floor touches it.
const double kDown = std::cos(std::numbers::pi / 6), kSameFace = std::numbers::pi / 180;
constexpr double kTouch = 0.001;  // m
// Ends of chains at this fraction of the depth of the lowest one, below the base, are feet, too.
constexpr double kFourLegs = 0.8;
// Toes are this much longer than heels, both measured from the ankle.
constexpr double kToes = 1.5;

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? char(c | 0x20) : c; });
  return text;
}
std::string quoted(const std::string& name) { return files::quote_if_needed(name); }
std::string list(const auto& names) {
  std::vector<std::string> all;
  for (const std::string& name : names) all.push_back(quoted(name));
  return fmt::format("{}", fmt::join(all, ", "));
}
std::string rounded(const Vector3d& v) {
  return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", v.x() + 0.0, v.y() + 0.0, v.z() + 0.0);
}

/// Returns only the robot, with all its joints.
model_file::Element written(const CompiledRobot& robot) {
  model_file::Element root{"mujoco"};
  root.add("compiler", {{"angle", "radian"}});
  const Writer writer(*robot.model, robot.file, "");
  root.add("worldbody").children.push_back(written_base(robot, writer));
  writer.add_sections(root);
  return root;
}

}  // namespace

class Guess {
 public:
  explicit Guess(const fs::path& file)
      : path_(file),
        file_(compile_robot(file, "", {})),
        model_(load_mjcf(written(file_), file.string())),
        m_(*model_) {
    data_.reset(mj_makeData(&m_));
    base_ = m_.jnt_bodyid[0];
    Eigen::Map<Eigen::Matrix<double, 7, 1>>(data_->qpos) << 0, 0, 0, 1, 0, 0, 0;
    mj_kinematics(&m_, data_.get());
    find_feet();
    find_upper_body();
    bend();
  }

  Gait gait() const {
    Gait gait{.step_length_m = std::min(kLongestStep_m, kStepShare * height_m_)};
    if (has_weak_hips()) gait.single_support_s = 0.5, gait.zmp_inwards_m = 0.03;
    return gait;
  }

  std::string rig() const {
    std::string text;
    if (!sensors_.lidars.empty()) text += fmt::format("  - lidar: {{{}}}\n", text_of(sensors_.lidars[0]));
    for (std::size_t i = 1; i < sensors_.imus.size(); ++i)
      text += fmt::format("  - imu: {{name: imu{}, {}}}\n", i, text_of(sensors_.imus[i]));
    return text.empty() ? text : kRig + text;
  }

  std::string yaml(const std::string& model, const Gait& gait, const std::string& comment,
                   const std::string& noises, bool arms_move = true) const {
    std::string text = fmt::format(
        "# Guessed from the tree of {0}: look at each line that is marked as a guess, then run\n"
        "# gaitslam robot check. models/README.md explains each key.\n"
        "model: {0}\nbase: {1}\n"
        "head_camera: {{{2}}}  # guess: {3}\n"
        "imu: {{{4}}}  # guess: {5}\nlegs:  # guess: the last joints above each "
        "foot\n",
        quoted(model), quoted(name(base_)),
        text_of(sensors_.cameras.empty() ? mount_on(name(head_), front_of(head_)) : sensors_.cameras[0]),
        sensors_.cameras.empty() ? "in front of the head, or of the chest" : "as in the model",
        text_of(sensors_.imus.empty() ? rig::Mount{name(chest_)} : sensors_.imus[0]),
        sensors_.imus.empty() ? "the body that carries the arms" : "as in the model");
    for (const Foot& foot : feet_) text += fmt::format("  {}: [{}]\n", side(foot), list(names(foot.joints)));
    text += "feet:  # guess: the lowest links, the left one where y is positive\n";
    for (const Foot& foot : feet_) text += foot_line(foot);
    text +=
        "posture_deg:  # guess: bent knees, the center of mass above the middle of the soles, or nearer to "
        "ankles that are weak\n  {" +
        posture() + "}\n";
    text += fmt::format(
        "servos:  # guess: gains in proportion to the mass, {:.1f} kg; effort limits are the model's\n",
        mass());
    std::vector<std::string> legs, ankles, others, rigid, endless;
    for (const Foot& foot : feet_)
      for (std::size_t i = 0; i < foot.joints.size(); ++i)
        (i + 2 < foot.joints.size() ? legs : ankles).push_back(joint_name(foot.joints[i]));
    for (int joint = 1; joint < m_.njnt; ++joint)
      if (has_servo(joint) && !std::ranges::count(legs, joint_name(joint)) &&
          !std::ranges::count(ankles, joint_name(joint)))
        (carries_both(joint) ? rigid
         : !has_range(joint) ? endless
         : carries(joint)    ? legs
                             : others)
            .push_back(joint_name(joint));
    if (!arms_move) others.clear();
    if (!rigid.empty())
      text += fmt::format("  # guess: rigid, since the plan moves legs on the base: {}\n",
                          fmt::join(rigid, ", "));
    if (!endless.empty())
      text += fmt::format("  # guess: rigid, since the model gives no range: {}\n", fmt::join(endless, ", "));
    const Gains ankle{gait.ankle_kp * kAnkle.kp, gait.ankle_kd * kAnkle.kd, kAnkle.armature};
    for (const auto& [joints, gains] : {std::pair(&legs, kLeg), {&ankles, ankle}, {&others, kOther}}) {
      const auto bare = std::stable_partition(joints->begin(), joints->end(),
                                              [&](const std::string& joint) { return has_armature(joint); });
      for (const std::span some : {std::span(joints->begin(), bare), std::span(bare, joints->end())})
        if (!some.empty())
          text += fmt::format(
              "  - {{joints: [{}],\n     kp_nm_rad: {:.0f}, kd_nms_rad: {:.1f}{}}}\n", list(some),
              gains.kp * mass(), gains.kd * mass(),
              has_armature(some[0]) ? "" : fmt::format(", armature_kg_m2: {:.2g}", gains.armature * mass()));
    }
    return text + "floor_friction: 0.7  # guess: rubber on a clean floor\n" +
           fmt::format(kWalk, comment, gait.single_support_s, gait.double_support_s, gait.step_height_m,
                       gait.step_length_m, gait.zmp_inwards_m,
                       kAdmittance / (mass() * std::max(kLeastHeight_m, height_m_))) +
           (noises.empty() ? kNoises : "# measured in the same walks\n" + noises);
  }

 private:
  struct Foot {
    int body, sole_body;
    std::vector<int> joints;                                   // hip to ankle
    Eigen::Isometry3d X_laid = Eigen::Isometry3d::Identity();  // flattens the sole at zero angles
  };

  std::string name(int body) const { return name_of(m_, mjOBJ_BODY, body); }
  std::string joint_name(int joint) const { return name_of(m_, mjOBJ_JOINT, joint); }
  bool is_paired(int geom) const {
    const std::string own = name_of(m_, mjOBJ_GEOM, geom);
    return !own.empty() && std::ranges::count(file_.paired_with_floor, own) > 0;
  }
  std::vector<std::string> names(const std::vector<int>& joints) const {
    std::vector<std::string> all;
    for (const int joint : joints) all.push_back(joint_name(joint));
    return all;
  }
  Vector3d place(int body) const { return Vector3d(data_->xpos + 3 * body); }
  const char* side(const Foot& foot) const { return place(foot.body).y() > 0 ? "left" : "right"; }
  double mass() const { return m_.body_subtreemass[base_]; }
  double weight() const { return mass() * -m_.opt.gravity[2]; }  // N

  bool has_armature(const std::string& joint) const {
    return m_.dof_armature[m_.jnt_dofadr[mj_name2id(&m_, mjOBJ_JOINT, joint.c_str())]] > 0;
  }

  bool has_range(int joint) const { return m_.jnt_range[2 * joint] < m_.jnt_range[2 * joint + 1]; }

  // Joints with a spring have no servo, unless an actuator of the model moves them.
  bool has_servo(int joint) const {
    const std::string name = joint_name(joint);
    return m_.jnt_type[joint] == mjJNT_HINGE && !name.empty() &&
           (m_.jnt_stiffness[joint] == 0 || file_.efforts.contains(name));
  }
  std::vector<int> joints_above(int body) const {
    std::vector<int> joints;
    for (; body > base_; body = m_.body_parentid[body])
      for (int k = m_.body_jntnum[body]; k-- > 0;)
        if (has_servo(m_.body_jntadr[body] + k)) joints.insert(joints.begin(), m_.body_jntadr[body] + k);
    return joints;
  }
  bool is_below(int body, int above) const {
    while (body > above) body = m_.body_parentid[body];
    return body == above;
  }
  bool carries_both(int joint) const {
    return std::ranges::all_of(feet_,
                               [&](const Foot& foot) { return is_below(foot.body, m_.jnt_bodyid[joint]); });
  }
  // Returns whether the joint carries one of the base's legs or its chest.
  bool carries(int joint) const {
    const int body = m_.jnt_bodyid[joint];
    return is_below(chest_, body) || is_below(feet_[0].body, body);
  }

  void find_feet() {
    std::vector<int> ends;
    for (int body = base_ + 1; body < m_.nbody; ++body) {
      bool last = !joints_above(body).empty() && m_.jnt_bodyid[joints_above(body).back()] == body;
      for (int joint = 1; joint < m_.njnt; ++joint)
        last &= !has_servo(joint) || m_.jnt_bodyid[joint] == body || !is_below(m_.jnt_bodyid[joint], body);
      if (last) ends.push_back(body);
    }
    std::ranges::sort(ends, {}, [&](int body) { return place(body).z(); });
    if (ends.size() < 2 || place(ends[0]).y() * place(ends[1]).y() >= 0)
      throw files::FileError(path_,
                             "lacks two feet: the lowest ends of chains are {}, expected one on each side of "
                             "the base (x ahead, y to "
                             "the left)",
                             ends.size() < 2 ? "fewer than two" : name(ends[0]) + " and " + name(ends[1]));
    if (ends.size() >= 4 && place(ends[3]).z() < kFourLegs * place(ends[0]).z())
      throw files::FileError(path_, "has four legs, {}, {}, {} and {}: expected a robot with two",
                             name(ends[0]), name(ends[1]), name(ends[2]), name(ends[3]));
    for (const int body : {ends[0], ends[1]}) {
      int sole = body;
      for (int below = body; below < m_.nbody; ++below)
        if (is_below(below, body) && !soles(below).empty()) sole = m_.body_weldid[below];
      feet_.push_back({body, sole, joints_above(body)});
      feet_.back().X_laid = laid(feet_.back());
    }
    for (Foot& foot : feet_) {
      std::erase_if(foot.joints, [&](int joint) { return carries_both(joint); });
      if (foot.joints.size() > 6) foot.joints.erase(foot.joints.begin(), foot.joints.end() - 6);
    }
    std::ranges::sort(feet_, {}, [&](const Foot& foot) { return place(foot.body).y(); });  // right, left
    for (const Foot& foot : feet_)
      if (const Eigen::AlignedBox3d sole = box(soles(foot.sole_body), foot.X_laid); !sole.isEmpty()) {
        const double ankle = data_->xanchor[3 * foot.joints.back()];
        if (ankle - sole.min().x() > kToes * (sole.max().x() - ankle))
          fail_backward("the toes point backward", foot);
      }
  }

  [[noreturn]] void fail_backward(const std::string& what, const Foot& foot) const {
    throw files::FileError(path_, "{} at {}: expected the x axis of the base '{}' ahead and y to the left",
                           what, name(foot.body), name(base_));
  }

  std::vector<int> soles(int body) const {
    std::vector<int> geoms;
    for (int geom = 0; geom < m_.ngeom; ++geom)
      if (m_.body_weldid[m_.geom_bodyid[geom]] == m_.body_weldid[body] &&
          ((m_.geom_contype[geom] | m_.geom_conaffinity[geom]) != 0 || is_paired(geom)))
        geoms.push_back(geom);
    return geoms;
  }

  // The corners of shapes, moved by X.
  std::vector<Vector3d> all_corners(const std::vector<int>& geoms, const Eigen::Isometry3d& X) const {
    std::vector<Vector3d> all;
    for (const int geom : geoms) std::ranges::copy(corners(m_, *data_, geom, X), std::back_inserter(all));
    return all;
  }

  // The area of the rectangle around the corners that touch the floor, m^2.
  static double touching_area(const std::vector<Vector3d>& corners) {
    const double floor = std::ranges::min(corners, {}, [](const Vector3d& p) { return p.z(); }).z();
    Eigen::AlignedBox2d touching;
    for (const Vector3d& p : corners)
      if (p.z() < floor + kTouch) touching.extend(p.head<2>());
    return touching.volume();
  }

  // Turns the foot about its body's origin until its largest face lies flat, if that doubles the area that
  // touches.
  Eigen::Isometry3d laid(const Foot& foot) const {
    const std::vector<int> geoms = soles(foot.sole_body);
    std::map<std::pair<long, long>, Vector3d> faces;  // areas times normals, by direction
    const auto add = [&](const Vector3d& face) {
      const Vector3d normal = face.normalized();
      if (-normal.z() > kDown)
        faces
            .try_emplace({std::lround(normal.x() / kSameFace), std::lround(normal.y() / kSameFace)},
                         Vector3d::Zero())
            .first->second += face;
    };
    const Eigen::Isometry3d as_is = Eigen::Isometry3d::Identity();
    for (const int geom : geoms) {
      const std::vector<Vector3d> points = corners(m_, *data_, geom, as_is);
      if (const int mesh = m_.geom_dataid[geom]; m_.geom_type[geom] == mjGEOM_MESH)
        for (int face = m_.mesh_faceadr[mesh]; face < m_.mesh_faceadr[mesh] + m_.mesh_facenum[mesh]; ++face) {
          const auto point = [&](int k) { return points[std::size_t(m_.mesh_face[3 * face + k])]; };
          add((point(1) - point(0)).cross(point(2) - point(0)) / 2);
        }
      if (m_.geom_type[geom] == mjGEOM_BOX)
        for (const int first : {1, 2, 4})  // neighboring corners differ in one bit
          for (const int sign : {-1, 1}) {
            const int second = first == 4 ? 1 : 2 * first;
            add(sign * (points[first] - points[0]).cross(points[second] - points[0]));
          }
    }
    if (faces.empty()) return as_is;
    const auto largest =
        std::ranges::max_element(faces, {}, [](const auto& face) { return face.second.norm(); });
    const Eigen::Isometry3d turned = Eigen::Translation3d(place(foot.body)) *
                                     Eigen::Quaterniond::FromTwoVectors(largest->second, -Vector3d::UnitZ()) *
                                     Eigen::Translation3d(-place(foot.body));
    return touching_area(all_corners(geoms, turned)) > 2 * touching_area(all_corners(geoms, as_is)) ? turned
                                                                                                    : as_is;
  }

  // A box around geoms moved by X, in the axes of W, which are also the base's.
  Eigen::AlignedBox3d box(const std::vector<int>& geoms, const Eigen::Isometry3d& X) const {
    Eigen::AlignedBox3d all;
    for (const Vector3d& p : all_corners(geoms, X)) all.extend(p);
    return all;
  }

  std::string foot_line(const Foot& foot) const {
    const Eigen::AlignedBox3d sole = box(soles(foot.sole_body), foot.X_laid);
    Vector3d point = foot.X_laid * Vector3d(data_->xanchor + 3 * foot.joints.back());
    if (!sole.isEmpty()) point.z() = sole.min().z();
    const Eigen::Isometry3d X =
        foot.X_laid * pose_in(data_->xpos + 3 * foot.sole_body, data_->xmat + 9 * foot.sole_body);
    const Eigen::Matrix3d R = X.linear().transpose();  // Rz(yaw) Ry(pitch) Rx(roll)
    std::string text = fmt::format("  {}: {{body: {}, sole_m: {}", side(foot), quoted(name(foot.sole_body)),
                                   rounded(X.inverse() * point));
    const bool upright = std::abs(R(2, 0)) > 1 - 1e-9;  // only the sum of roll and yaw is known
    const double roll = upright ? std::atan2(-R(1, 2), R(1, 1)) : std::atan2(R(2, 1), R(2, 2)),
                 pitch = std::asin(std::clamp(-R(2, 0), -1.0, 1.0)),
                 yaw = upright ? 0 : std::atan2(R(1, 0), R(0, 0));
    for (const auto& [key, angle] : {std::pair("roll", roll), {"pitch", pitch}, {"yaw", yaw}})
      if (std::abs(angle) > 1e-4) text += fmt::format(", sole_{}_deg: {:.6g}", key, angle * kDegrees);
    std::vector<std::string> paired;
    for (const int geom : soles(foot.sole_body))
      if (is_paired(geom)) paired.push_back(name_of(m_, mjOBJ_GEOM, geom));
    if (!paired.empty()) text += fmt::format(", contacts: [{}]", list(paired));
    return text + "}\n";
  }

  // Returns whether a body with a shape, or one of its joints, has this word in its name.
  bool is_called(int body, const char* word) const {
    bool called = lower(name(body)).find(word) != std::string::npos;
    for (int k = 0; k < m_.body_jntnum[body]; ++k)
      called |= lower(joint_name(m_.body_jntadr[body] + k)).find(word) != std::string::npos;
    return called && m_.body_geomnum[body] > 0;
  }

  // The chest carries two or more chains besides the legs. A head or neck is recognized by its name; without
  // either, the chest is used.
  void find_upper_body() {
    chest_ = base_;
    for (int body = base_ + 1; body < m_.nbody; ++body) {
      int chains = 0;
      for (int child = body + 1; child < m_.nbody; ++child) {
        const auto below = [&](int joint) {
          return has_servo(joint) && is_below(m_.jnt_bodyid[joint], child);
        };
        bool jointed = false;
        for (int joint = 1; joint < m_.njnt; ++joint) jointed |= below(joint);
        chains += m_.body_parentid[child] == body && jointed;
      }
      const bool carries_feet = is_below(feet_[0].body, body) || is_below(feet_[1].body, body);
      if (chains >= 2 && !carries_feet &&
          (chest_ == base_ || m_.body_subtreemass[body] > m_.body_subtreemass[chest_]))
        chest_ = body;
    }
    head_ = chest_;
    for (const char* const word : {"neck", "head"})
      for (int body = base_; body < m_.nbody; ++body)
        if (is_called(body, word)) head_ = body;
    std::vector<std::string> trunk;
    for (const int end : {head_, chest_, base_})
      for (int body = m_.body_weldid[end]; body > 0; body = m_.body_weldid[m_.body_parentid[body]])
        trunk.push_back(name(body));
    sensors_ = find_sensors(file_, trunk);
    std::stable_partition(sensors_.imus.begin(), sensors_.imus.end(),
                          [&](const rig::Mount& imu) { return imu.link == name(m_.body_weldid[chest_]); });
  }

  // In front of the body, with the base's axes.
  Eigen::Isometry3d front_of(int body) const {
    std::vector<int> geoms;
    for (int geom = 0; geom < m_.ngeom; ++geom)
      if (m_.geom_bodyid[geom] == body) geoms.push_back(geom);
    const Eigen::AlignedBox3d around = box(geoms, Eigen::Isometry3d::Identity());
    Vector3d front = place(body);
    if (!around.isEmpty())
      front << around.max().x(), around.center().y(), 0.2 * around.center().z() + 0.8 * around.max().z();
    return pose_in(data_->xpos + 3 * body, data_->xmat + 9 * body).inverse() * Eigen::Translation3d(front);
  }

  // Bends the three joints that pitch the most, then turns the whole legs until the soles lie flat again.
  void bend() {
    bent_.reset(mj_copyData(nullptr, &m_, data_.get()));
    const auto pitch = [&](int joint) { return data_->xaxis[3 * joint + 1]; };
    for (const Foot& foot : feet_) {
      for (const int joint : foot.joints)
        if (!has_range(joint))
          throw files::FileError(path_,
                                 "the leg's joint '{}' has no range, expected its smallest and largest angle",
                                 joint_name(joint));
      std::vector<int> pitches = foot.joints;
      std::ranges::stable_sort(pitches, std::greater(), [&](int joint) { return std::abs(pitch(joint)); });
      pitches.resize(std::min<std::size_t>(pitches.size(), 3));
      std::ranges::sort(pitches);
      if (pitches.size() == 3) {
        const mjtNum* const range = m_.jnt_range + 2 * pitches[1];
        const double bends = pitch(pitches[1]) > 0 ? range[1] : -range[0],
                     other = pitch(pitches[1]) > 0 ? -range[0] : range[1];
        if (bends < kBend_deg / kDegrees && other > 2 * kBend_deg / kDegrees)
          fail_backward("the knee bends backward", foot);
      }
      for (std::size_t i = 0; i < pitches.size(); ++i)
        bent_->qpos[m_.jnt_qposadr[pitches[i]]] =
            (pitch(pitches[i]) > 0 ? 1 : -1) * (i == 1 ? 2 : -1) * kBend_deg / kDegrees;
    }
    for (int round = 0; round < 2; ++round)  // each leg moves the center of mass
      for (const Foot& foot : feet_) level(foot, *bent_);
    for (const Foot& foot : feet_)
      for (const int joint : foot.joints)
        if (!is_level_ || !(std::abs(bent_->qpos[m_.jnt_qposadr[joint]]) < std::numbers::pi))
          throw files::FileError(path_, "has no posture with flat soles and bent knees: are {} really legs?",
                                 fmt::join(names(foot.joints), ", "));
  }

  std::string posture() const {
    std::vector<std::string> angles;
    for (const Foot& foot : feet_)
      for (const int joint : foot.joints)
        if (const double angle = bent_->qpos[m_.jnt_qposadr[joint]] * kDegrees; std::abs(angle) > 0.01)
          angles.push_back(fmt::format("{}: {:.4g}", quoted(joint_name(joint)), angle));
    return fmt::format("{}", fmt::join(angles, ", "));
  }

  bool has_weak_hips() const {
    return std::ranges::any_of(feet_, [&](const Foot& foot) {
      const auto roll = std::ranges::find_if(
          foot.joints, [&](int joint) { return std::abs(data_->xaxis[3 * joint]) > 0.7; });
      if (roll == foot.joints.end()) return false;
      const auto effort = file_.efforts.find(joint_name(*roll));
      return effort != file_.efforts.end() && std::min(effort->second.highest, -effort->second.lowest) <
                                                  kWeakHips * weight() * std::abs(place(foot.body).y());
    });
  }

  // Returns how far the center of mass must be behind the middle of the sole because of the ankle's torque
  // limit.
  double behind_middle(const Foot& foot, const Eigen::AlignedBox3d& sole) const {
    double behind = 0;
    for (const int joint : foot.joints)
      if (const auto effort = file_.efforts.find(joint_name(joint));
          effort != file_.efforts.end() && std::abs(data_->xaxis[3 * joint + 1]) > 0.7 &&
          joint >= foot.joints[foot.joints.size() - std::min<std::size_t>(2, foot.joints.size())])
        behind =
            sole.center().x() - data_->xanchor[3 * joint] - kAnkleShare * effort->second.highest / weight();
    return std::max(0.0, behind);
  }

  // Takes damped Gauss-Newton steps until the foot has the same orientation and y as when flat at zero
  // angles, and the middle of the sole is below the center of mass or ahead of it.
  void level(const Foot& foot, mjData& bent) {
    const Eigen::AlignedBox3d sole = box(soles(foot.sole_body), foot.X_laid);
    Vector3d above = Vector3d::Zero();
    if (!sole.isEmpty()) {
      above = place(foot.body) - sole.center();
      above.x() += behind_middle(foot, sole);
    }
    mj_kinematics(&m_, &bent);
    const double height = bent.xpos[3 * foot.body + 2];
    Eigen::Matrix<double, 6, 1> error;
    for (int step = 0; step < kLevelingSteps; ++step) {
      mj_kinematics(&m_, &bent);
      mj_comPos(&m_, &bent);
      Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> moves(3, m_.nv), turns(3, m_.nv);
      const mjtNum* const at = bent.xpos + 3 * foot.body;
      mj_jac(&m_, &bent, moves.data(), turns.data(), at, foot.body);
      const Eigen::AngleAxisd turn(foot.X_laid.linear() *
                                   pose_in(data_->xpos, data_->xmat + 9 * foot.body).linear() *
                                   pose_in(data_->xpos, bent.xmat + 9 * foot.body).linear().transpose());
      Eigen::MatrixXd J(6, foot.joints.size());
      for (std::size_t i = 0; i < foot.joints.size(); ++i) {
        const int dof = m_.jnt_dofadr[foot.joints[i]];
        J.col(Eigen::Index(i)) << moves.col(dof), turns.col(dof);
      }
      const Vector3d goal(bent.subtree_com[3 * base_] + above.x(), place(foot.body).y(), height);
      error << goal - Vector3d(at), turn.angle() * turn.axis();
      const Eigen::MatrixXd A =
          J.transpose() * J + kLeastDamping * Eigen::MatrixXd::Identity(J.cols(), J.cols());
      const Eigen::VectorXd change = A.llt().solve(J.transpose() * error);
      for (std::size_t i = 0; i < foot.joints.size(); ++i)
        bent.qpos[m_.jnt_qposadr[foot.joints[i]]] += change[Eigen::Index(i)];
    }
    is_level_ = error.norm() < kLevel;
    const double bottom = sole.isEmpty() ? place(foot.body).z() : sole.min().z();
    height_m_ = bent.subtree_com[3 * base_ + 2] - (height + bottom - place(foot.body).z());
  }

  fs::path path_;
  CompiledRobot file_;
  Model model_;
  const mjModel& m_;
  Data data_, bent_;
  bool is_level_ = false;  // bent
  double height_m_ = 0;    // height of the center of mass above the soles, once bent
  int base_ = 0, chest_ = 0, head_ = 0;
  FoundSensors sensors_;
  std::vector<Foot> feet_;
};

FirstRobotFile::FirstRobotFile(const fs::path& model) : guess_(std::make_unique<Guess>(model)) {}
FirstRobotFile::~FirstRobotFile() = default;
FirstRobotFile::FirstRobotFile(FirstRobotFile&&) noexcept = default;

Gait FirstRobotFile::guessed_gait() const { return guess_->gait(); }

std::string FirstRobotFile::rig() const { return guess_->rig(); }

std::string FirstRobotFile::yaml(const std::string& model, const Gait& gait, const std::string& comment,
                                 const std::string& noises) const {
  return guess_->yaml(model, gait, comment, noises);
}

std::string FirstRobotFile::trial(const std::string& model, const Gait& gait) const {
  return guess_->yaml(model, gait, "tried", "", false);
}

std::string first_robot_file(const fs::path& model, const std::string& written) {
  const FirstRobotFile first(model);
  return first.yaml(written, first.guessed_gait(), kGuessedGait);
}

}  // namespace sim::physics
