#include "sim/physics/world.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sim::physics {
namespace {

constexpr std::array<std::string_view, 2> kFeet{"left", "right"};

int sole_site(const mjModel& model, std::size_t foot) {
  return part(model, mjOBJ_SITE, fmt::format("{}_sole", kFeet[foot]));
}

Eigen::Vector2d horizontal(const mjtNum* p) { return {p[0], p[1]}; }

// The friction force on a pad in W, and the steady-state velocity of MuJoCo's friction constraint against it:
// without acceleration, the constraint's law a + B v = -R f gives v = -R f / B.
struct Friction {
  Eigen::Vector2d place, creep_velocity;
};

Friction friction(const mjData& d, const mjContact& contact, double sign) {
  Friction result{horizontal(contact.pos), Eigen::Vector2d::Zero()};
  for (int i = 1; i < contact.dim; ++i) {
    const int row = contact.efc_address + i;
    const double velocity = -d.efc_R[row] * d.efc_force[row] / d.efc_KBIP[4 * row + 1];
    result.creep_velocity += sign * velocity * horizontal(contact.frame + 3 * i);
  }
  return result;
}

constexpr std::chrono::milliseconds kStep{1};
constexpr double kStep_s = 1e-3;
constexpr double kFallen = 0.694;                     // fraction of the waist's start height
constexpr double kFallenTilt = std::numbers::pi / 4;  // angle of the waist's axis from the vertical

Eigen::Vector3d vector(const mjtNum* numbers) { return Eigen::Vector3d(numbers[0], numbers[1], numbers[2]); }

}  // namespace

Soles::Soles(mjModel& model, double friction, std::vector<FloorPatch> patches, std::vector<FloorWave> waves)
    : floor_(model), friction_(friction), patches_(std::move(patches)), waves_(std::move(waves)) {
  for (std::size_t foot = 0; foot < 2; ++foot)
    for (const int geom : contacts(model, model.site_bodyid[sole_site(model, foot)]))
      pads_.push_back({geom, int(foot), model.geom_pos[3 * geom + 2]});
  for (const Pad& pad : pads_) model.geom_friction[3 * pad.geom] = friction_;
}

void Soles::apply_floor(mjModel& model, const mjData& data) const {
  if (patches_.empty() && waves_.empty() && floor_.is_plain()) return;
  for (const Pad& pad : pads_) {
    const Eigen::Vector2d place = horizontal(data.geom_xpos + 3 * pad.geom);
    model.geom_friction[3 * pad.geom] =
        friction_at(place, friction_, patches_) * floor_.friction(data, place);
    model.geom_pos[3 * pad.geom + 2] = pad.z - height_at(place, waves_);
  }
}

double Soles::lowest_pad(const mjModel& model, const mjData& data) const {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Pad& pad : pads_) {
    const Eigen::RowVector3d up = geom_pose(data, pad.geom).linear().row(2).cwiseAbs();
    const bool sphere = model.geom_type[pad.geom] == mjGEOM_SPHERE;
    const double half = sphere ? model.geom_size[3 * pad.geom] : up.dot(half_extents(model, pad.geom));
    const mjtNum* const p = data.geom_xpos + 3 * pad.geom;
    lowest = std::min(lowest, p[2] - half - floor_.height(data, horizontal(p)));
  }
  return lowest;
}

void Soles::add_contact_forces(const mjModel& model, const mjData& data) {
  for (std::size_t foot = 0; foot < 2; ++foot) add_contact_forces(model, data, foot);
  ++steps_;
}

void Soles::add_contact_forces(const mjModel& model, const mjData& data, std::size_t foot) {
  std::vector<Friction> pads;
  for (const mjContact* c = data.contact; c < data.contact + data.ncon; ++c) {
    const auto touches = [&](const Pad& pad) {
      return pad.foot == int(foot) && (pad.geom == c->geom1 || pad.geom == c->geom2);
    };
    const auto pad = std::ranges::find_if(pads_, touches);
    if (pad == pads_.end() || c->efc_address < 0) continue;
    sum_[foot].load += data.efc_force[c->efc_address];
    pads.push_back(friction(data, *c, pad->geom == c->geom2 ? 1 : -1));
  }
  if (pads.empty()) return;
  // The rigid motion closest to the pads' motion.
  const double dt = model.opt.timestep, count = double(pads.size());
  Eigen::Vector2d center = Eigen::Vector2d::Zero(), mean = Eigen::Vector2d::Zero();
  for (const Friction& pad : pads) {
    center += pad.place / count;
    mean += pad.creep_velocity / count;
  }
  double turn = 0, spread = 0;
  for (const Friction& pad : pads) {
    const Eigen::Vector2d r = pad.place - center, v = pad.creep_velocity;
    turn += r.x() * v.y() - r.y() * v.x();
    spread += r.squaredNorm();
  }
  sum_[foot].creep += dt * mean;
  if (spread > 0) sum_[foot].creep_yaw += dt * turn / spread;
}

std::array<SoleContact, 2> Soles::since_last() {
  std::array<SoleContact, 2> last = std::exchange(sum_, {});
  for (SoleContact& foot : last) foot.load /= std::max(1, steps_);
  steps_ = 0;
  return last;
}

double friction_at(const Eigen::Vector2d& p_W, double elsewhere, const std::vector<FloorPatch>& patches) {
  double friction = elsewhere;
  for (const FloorPatch& p : patches)
    if (p_W.x() >= p.x_min_m && p_W.x() <= p.x_max_m && p_W.y() >= p.y_min_m && p_W.y() <= p.y_max_m)
      friction = p.friction;
  return friction;
}

double height_at(const Eigen::Vector2d& p_W, const std::vector<FloorWave>& waves) {
  double height = 0;
  for (const FloorWave& w : waves) height += w.amplitude_m * std::cos(w.k_1_m.dot(p_W) + w.phase_rad);
  return height;
}

ImuReading reading_between(const ImuState& from, const ImuState& to, const Eigen::Vector3d& gravity) {
  ImuReading reading{.begin = from.t, .end = to.t};
  const double dt = std::chrono::duration<double>(to.t - from.t).count();
  if (dt <= 0) return reading;
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(from.R_WG.transpose() * to.R_WG).normalized());
  reading.gyro = turn.axis() * (turn.angle() / dt);
  // Rotation at the middle of the interval.
  const Eigen::Matrix3d R_WG = from.R_WG * Eigen::AngleAxisd(turn.angle() / 2, turn.axis());
  reading.specific_force = R_WG.transpose() * ((to.v_WG - from.v_WG) / dt - gravity);
  return reading;
}

World::World(const WorldOptions& options, const PlantVariation& draw, const walking::JointVector& q,
             const Eigen::Isometry3d& X_WB, const Models& models)
    : robot_(models.robot),
      model_(copy_of(models.on_floor)),
      data_(mj_makeData(model_.get())),
      soles_(*model_, draw.floor_friction, options.floor_patches, draw.floor),
      pushes_(options.pushes),
      floor_friction_(draw.floor_friction) {
  if (options.room != kPhysicalRoom) room_.emplace(copy_of(models.in_room));
  find_ids();
  apply(draw);
  desired_velocity_ = walking::JointVector::Zero(q.size());
  place(draw.posture_rad.size() ? q + draw.posture_rad : q, X_WB);
  command({q, walking::JointVector::Zero(q.size())});
  mj_forward(model_.get(), data_.get());
  last_read_ = last_recorded_ = imu_state();
  if (!models.has_force_sensors) leg_loads_.emplace(copy_of(models.on_floor), robot_);
  by_encoders_.reset(mj_makeData(model_.get()));
  if (models.imu_is_moved) R_HG_ = imu_in_chest(leg_readings().q);
}

void World::find_ids() {
  const mjModel& m = *model_;
  ids_.waist = m.jnt_bodyid[0];
  ids_.camera = part(m, mjOBJ_CAMERA, "head_camera");
  ids_.imu = part(m, mjOBJ_SITE, "imu");
  for (std::size_t foot = 0; foot < 2; ++foot) {
    ids_.sole[foot] = sole_site(m, foot);
    ids_.foot[foot] = m.site_bodyid[ids_.sole[foot]];
    ids_.force[foot] = m.sensor_adr[part(m, mjOBJ_SENSOR, fmt::format("{}_force", kFeet[foot]))];
    ids_.torque[foot] = m.sensor_adr[part(m, mjOBJ_SENSOR, fmt::format("{}_torque", kFeet[foot]))];
  }
  for (int servo = 0; servo < m.nu; ++servo) {
    const int joint = m.actuator_trnid[2 * servo];
    ids_.position.push_back(m.jnt_qposadr[joint]);
    ids_.velocity.push_back(m.jnt_dofadr[joint]);
    ids_.body.push_back(m.jnt_bodyid[joint]);
  }
}

void World::apply(const PlantVariation& draw) {
  mjModel* m = model_.get();
  offset_ = draw.joint_offset_rad;
  if (offset_.size() == 0) offset_ = walking::JointVector::Zero(m->nu);
  servo_scale_ = draw.servo_scale;
  for (int servo = 0; servo < draw.servo_scale.size(); ++servo) {
    m->actuator_gainprm[mjNGAIN * servo] *= draw.servo_scale[servo];
    m->actuator_biasprm[mjNBIAS * servo + 1] *= draw.servo_scale[servo];
  }
  const auto body_of = [this](Eigen::Index link) {
    return link == 0 ? ids_.waist : ids_.body[std::size_t(link - 1)];
  };
  for (Eigen::Index link = 0; link < draw.mass_scale.size(); ++link) {
    m->body_mass[body_of(link)] *= draw.mass_scale[link];
    Eigen::Map<Eigen::Vector3d>(m->body_inertia + 3 * body_of(link)) *= draw.mass_scale[link];
  }
  for (Eigen::Index link = 0; link < draw.com_offset_m.cols(); ++link) {
    Eigen::Map<Eigen::Vector3d>(m->body_ipos + 3 * body_of(link)) += draw.com_offset_m.col(link);
    m->body_sameframe[body_of(link)] = 0;
  }
  mj_setConst(m, data_.get());
}

void World::place(const walking::JointVector& q, const Eigen::Isometry3d& X_WB) {
  mj_resetData(model_.get(), data_.get());
  const Eigen::Quaterniond turn(X_WB.linear());
  mjtNum* base = data_->qpos + model_->jnt_qposadr[model_->body_jntadr[ids_.waist]];
  Eigen::Map<Eigen::Matrix<double, 7, 1>>(base) << X_WB.translation(), turn.w(), turn.vec();
  for (int joint = 0; joint < model_->nu; ++joint)
    data_->qpos[ids_.position[joint]] = q[joint] + offset_[joint];
  for (int pass = 0; pass < 2; ++pass) {  // a pad's place determines its length
    mj_kinematics(model_.get(), data_.get());
    soles_.apply_floor(*model_, *data_);
  }
  base[2] -= soles_.lowest_pad(*model_, *data_);
}

// A servo's target moves around the command during the tick, at the mean desired velocity of the last two
// ticks. If it were held, the joints' velocities would have a ripple at exactly the rate of the IMU's
// readings; at the last desired velocity alone, feedback at half that rate makes a robot on bushes chatter.
void World::command(const controllers::JointCommands& commands) {
  const auto& [q, dq, gains, moves] = commands;
  constexpr double kHalf_s = (walking::kPeriod - kStep_s) / 2;
  const walking::JointVector desired = moves ? dq : walking::JointVector::Zero(dq.size());
  target_velocity_ = (std::exchange(desired_velocity_, desired) + desired) / 2;
  const walking::JointVector& damped = moves ? target_velocity_ : dq;  // kd acts on the difference from it
  for (int joint = 0; joint < model_->nu; ++joint) {
    double &kp = model_->actuator_gainprm[mjNGAIN * joint], &kd = model_->dof_damping[ids_.velocity[joint]];
    double& added = data_->qfrc_applied[ids_.velocity[joint]];
    added = gains ? gains->torque[joint] : 0;
    if (gains) {
      kp = gains->kp[joint] * (servo_scale_.size() ? servo_scale_[joint] : 1);
      model_->actuator_biasprm[mjNBIAS * joint + 1] = -kp;
      kd = gains->kd[joint];  // MuJoCo integrates it implicitly
    }
    // MuJoCo's position servo is kp (ctrl − q), and its damping acts on the whole joint velocity, so the
    // command includes the term for the desired velocity.
    if (kp > 0)
      data_->ctrl[joint] =
          q[joint] + offset_[joint] + kd / kp * damped[joint] - kHalf_s * target_velocity_[joint];
    else
      added += kd * damped[joint];
  }
}

double World::added_torque(int joint) const { return data_->qfrc_applied[ids_.velocity[joint]]; }

// Keeps the waist at rest, as if hanging from a hoist.
void World::place_held() {
  const int joint = model_->body_jntadr[ids_.waist];
  const Eigen::Quaterniond turn(held_->linear());
  Eigen::Map<Eigen::Matrix<double, 7, 1>>(data_->qpos + model_->jnt_qposadr[joint]) << held_->translation(),
      turn.w(), turn.vec();
  Eigen::Map<Eigen::Matrix<double, 6, 1>>(data_->qvel + model_->jnt_dofadr[joint]).setZero();
}

// The limit applies to a servo's whole torque. MuJoCo adds damping and added torque separately.
void World::limit_torques() {
  for (int joint = 0; joint < model_->nu; ++joint) {
    const walking::Joint& limits = robot_.joints[std::size_t(joint)];
    if (std::isinf(limits.effort)) continue;
    const double damping = damping_torque(joint) - added_torque(joint);
    const double force =
        model_->actuator_gainprm[mjNGAIN * joint] * (data_->ctrl[joint] - data_->qpos[ids_.position[joint]]);
    const double torque = force - damping,
                 share = torque / (torque < 0 ? limits.lowest_effort : limits.effort);
    if (share > largest_share_.value) largest_share_ = {share, joint};
    if (share > 1) {
      ++limited_ms_[std::size_t(joint)];
      at_limit_ |= std::ranges::any_of(
          robot_.legs, [&](const walking::Leg& leg) { return std::ranges::count(leg.joints, joint) > 0; });
    }
    mjtNum* const range = model_->actuator_forcerange + 2 * joint;
    range[0] = damping + limits.lowest_effort, range[1] = damping + limits.effort;
  }
}

std::optional<bool> World::torque_limited_since_last() {
  if (std::ranges::all_of(robot_.joints, [](const walking::Joint& j) { return std::isinf(j.effort); }))
    return std::nullopt;
  return std::exchange(at_limit_, false);
}

double World::damping_torque(int joint) const {
  const int dof = ids_.velocity[joint];
  return model_->dof_damping[dof] * data_->qvel[dof];
}

const Status& World::step() {
  if (status_.condition != Condition::ok) return status_;
  push();
  limit_torques();
  // Ankle forces take 3 % of a step, so they are only computed at the end of a tick.
  int& disabled = model_->opt.disableflags;
  disabled =
      (time_ + kStep) % walking::kTick == kStep.zero() ? disabled & ~mjDSBL_SENSOR : disabled | mjDSBL_SENSOR;
  mj_step2(model_.get(), data_.get());
  soles_.add_contact_forces(*model_, *data_);
  if (held_) place_held();
  soles_.apply_floor(*model_, *data_);
  mj_step1(model_.get(), data_.get());
  Eigen::Map<Eigen::VectorXd>(data_->ctrl, model_->nu) += kStep_s * target_velocity_;
  time_ += kStep;
  status_ = check();
  if (status_.condition == Condition::ok && room_ && time_ >= next_look_) look_around();
  return status_;
}

// Distant shapes cannot be touched soon, so most steps need no check.
void World::look_around() {
  const Clearance clearance =
      room_->at(data_->qpos, settling_ ? 0 : std::chrono::duration<double>(time_).count());
  next_look_ = time_ + std::chrono::nanoseconds(
                           std::llround(1e9 * std::min(clearance.distance_m / kFastest_m_s, 1.0)));
  if (!clearance.collision) return;
  const auto& [link, object, p_W] = *clearance.collision;
  status_ = {Condition::collided,
             fmt::format("{} touched {} at ({:.3f}, {:.3f}, {:.3f}) m in the room after {:.3f} s", link,
                         object, p_W.x(), p_W.y(), p_W.z(), std::chrono::duration<double>(time_).count())};
}

void World::start_clock(std::vector<Push> pushes) {
  pushes_ = std::move(pushes);
  time_ = next_look_ = std::chrono::nanoseconds(0);
  data_->time = 0;
  at_limit_ = settling_ = false;
  largest_share_ = {};
  std::ranges::fill(limited_ms_, 0);
  last_read_ = last_recorded_ = imu_state();
  soles_.since_last();
}

void World::push() {
  const double now = std::chrono::duration<double>(time_).count();
  Eigen::Map<Eigen::Vector3d> force(data_->xfrc_applied + 6 * ids_.waist);
  force.setZero();
  const Eigen::Vector3d ahead = X_WB().linear().col(0);
  for (const Push& push : pushes_) {
    if (now < push.time_s || now >= push.time_s + push.duration_s) continue;
    const double heading = std::atan2(ahead.y(), ahead.x()) + push.direction_rad;
    force += push.impulse_ns / push.duration_s * Eigen::Vector3d(std::cos(heading), std::sin(heading), 0);
  }
}

Status World::check() const {
  const double lag = data_->time - std::chrono::duration<double>(time_).count();
  if (const auto warning = latest_warning()) return {Condition::physics_failed, *warning};
  const auto raised = [](const mjWarningStat& w) { return w.number > 0; };
  if (std::any_of(data_->warning, data_->warning + mjNWARNING, raised))
    return {Condition::physics_failed, "a warning of MuJoCo"};
  // If a state is not finite, MuJoCo resets the robot and its clock and continues.
  if (!(std::abs(lag) < 1e-6)) return {Condition::physics_failed, "the physics has reset itself"};
  const auto between_feet = [this](const mjContact& contact) {
    const auto is_of = [&](std::size_t foot, int geom) {
      return model_->body_weldid[model_->geom_bodyid[geom]] == model_->body_weldid[ids_.foot[foot]];
    };
    return (is_of(0, contact.geom1) && is_of(1, contact.geom2)) ||
           (is_of(1, contact.geom1) && is_of(0, contact.geom2));
  };
  if (!feet_may_touch_ && std::any_of(data_->contact, data_->contact + data_->ncon, between_feet))
    return {Condition::collided, "one foot touched the other"};
  const Eigen::Isometry3d X = X_WB();
  double below = 0;  // floor height under the feet
  for (const int sole : ids_.sole)
    below += soles_.floor().height(*data_, horizontal(data_->site_xpos + 3 * sole)) / 2;
  if (X.translation().z() - below < kFallen * robot_.base_height || X.linear()(2, 2) < std::cos(kFallenTilt))
    return {Condition::fell, fall_text(X)};
  return {};
}

// "to the left at 3.20 s: ..., 0.4 s after the start of a push of 40 N s", as seen by the robot.
std::string World::fall_text(const Eigen::Isometry3d& X_WB) const {
  constexpr std::array<const char*, 4> kWays{"forward", "to the left", "backward", "to the right"};
  const Eigen::Vector3d up = X_WB.linear().col(2), ahead = X_WB.linear().col(0);
  const double way = std::remainder(std::atan2(up.y(), up.x()) - std::atan2(ahead.y(), ahead.x()), 2 * M_PI);
  const double now = std::chrono::duration<double>(time_).count();
  std::string text =
      fmt::format("{} at {:.2f} s{}: the waist is {:.2f} m high and tilted by {:.0f} deg",
                  kWays[std::size_t(std::lround(way / M_PI_2) + 4) % 4], now, settling_ ? " of settling" : "",
                  X_WB.translation().z(), std::acos(std::clamp(up.z(), -1.0, 1.0)) * 180 / M_PI);
  constexpr double kBlamed_s = 5;  // after a push
  for (const Push& push : pushes_)
    if (now >= push.time_s && now < push.time_s + push.duration_s + kBlamed_s)
      text +=
          fmt::format(", {:.1f} s after the start of a push of {} N s", now - push.time_s, push.impulse_ns);
  const auto longest = std::ranges::max_element(limited_ms_);
  const auto name = [&](std::ptrdiff_t joint) { return robot_.joints[std::size_t(joint)].name; };
  if (largest_share_.value > 1)
    text += fmt::format(", {:.2f} s at a torque limit ({})", 1e-3 * *longest,
                        name(longest - limited_ms_.begin()));
  else if (largest_share_.value > 0)
    text += fmt::format(", at most {:.0f} % of a torque limit ({})", 1e2 * largest_share_.value,
                        name(largest_share_.joint));
  text += fmt::format(", floor friction {:.2f}", floor_friction_);
  return text;
}

walking::Wrench World::wrench(std::size_t foot) const {
  // MuJoCo gives the wrench of the leg on the sole. At rest, the ground exerts the opposite wrench on the
  // foot, except for the weight below the sensor, for which the sensor is tared.
  walking::Wrench wrench{-vector(data_->sensordata + ids_.force[foot]),
                         -vector(data_->sensordata + ids_.torque[foot])};
  wrench.force.z() -= model_->body_subtreemass[ids_.foot[foot]] * model_->opt.gravity[2];
  return wrench;
}

walking::JointVector World::velocities() const {
  walking::JointVector dq(model_->nu);
  for (int joint = 0; joint < model_->nu; ++joint) dq[joint] = data_->qvel[ids_.velocity[joint]];
  return dq;
}

walking::JointVector World::torques() const {
  walking::JointVector torque(model_->nu);
  for (int joint = 0; joint < model_->nu; ++joint)
    torque[joint] = data_->actuator_force[joint] - damping_torque(joint) + added_torque(joint);
  return torque;
}

walking::SensorReadings World::leg_readings() const {
  walking::SensorReadings readings;
  readings.q.resize(model_->nu);
  for (int joint = 0; joint < model_->nu; ++joint)
    readings.q[joint] = data_->qpos[ids_.position[joint]] - offset_[joint];
  if (leg_loads_) {
    const auto [left, right] = leg_loads_->wrenches(readings.q, torques());
    readings.left = left, readings.right = right;
    return readings;
  }
  readings.left = wrench(0);
  readings.right = wrench(1);
  return readings;
}

walking::SensorReadings World::sensor_readings() {
  const ImuReading reading = reading_since(last_read_);
  walking::SensorReadings readings = leg_readings();
  readings.gyro = reading.gyro;
  readings.accelerometer = reading.specific_force;
  if (!R_HG_) return readings;
  const double dt = std::chrono::duration<double>(reading.end - reading.begin).count();
  const Eigen::Matrix3d before = *std::exchange(R_HG_, imu_in_chest(readings.q));
  const Eigen::Vector3d turn_G = readings.gyro * dt;
  const Eigen::AngleAxisd turn_H(before * Eigen::AngleAxisd(turn_G.norm(), turn_G.stableNormalized()) *
                                 R_HG_->transpose());
  readings.gyro = dt > 0 ? Eigen::Vector3d(turn_H.axis() * (turn_H.angle() / dt)) : Eigen::Vector3d::Zero();
  readings.accelerometer = *R_HG_ * readings.accelerometer;
  return readings;
}

/// Poses the robot according to its encoders, with its waist anywhere.
const mjData& World::pose_by_encoders(const walking::JointVector& encoders) const {
  for (int joint = 0; joint < model_->nu; ++joint) by_encoders_->qpos[ids_.position[joint]] = encoders[joint];
  mj_kinematics(model_.get(), by_encoders_.get());
  mj_camlight(model_.get(), by_encoders_.get());
  return *by_encoders_;
}

World::Mounts World::mounts_by_encoders() const {
  const mjData& data = pose_by_encoders(leg_readings().q);
  const Eigen::Isometry3d X_WB = pose_in(data.xpos + 3 * ids_.waist, data.xmat + 9 * ids_.waist),
                          X_WG = pose_in(data.site_xpos + 3 * ids_.imu, data.site_xmat + 9 * ids_.imu),
                          X_WC = camera_in_world(data);
  return {X_WB.inverse() * X_WC, X_WC.inverse() * X_WG};
}

Eigen::Matrix3d World::imu_in_chest(const walking::JointVector& encoders) const {
  const mjData& data = pose_by_encoders(encoders);
  const Eigen::Matrix3d R_WB = pose_in(data.xpos, data.xmat + 9 * ids_.waist).linear(),
                        R_WG = pose_in(data.xpos, data.site_xmat + 9 * ids_.imu).linear();
  return (R_WB * walking::imu_in_base(robot_, encoders).linear()).transpose() * R_WG;
}

ImuReading World::reading_since(ImuState& last) const {
  const ImuState before = std::exchange(last, imu_state());
  return reading_between(before, last, vector(model_->opt.gravity));
}

ImuState World::imu_state() const {
  std::array<mjtNum, 6> velocity{};  // angular, linear
  mj_objectVelocity(model_.get(), data_.get(), mjOBJ_SITE, ids_.imu, velocity.data(), 0);
  return {time_, X_WG().linear(), vector(velocity.data() + 3)};
}

Eigen::Isometry3d World::X_W(const Place& place) const {
  return pose_in(data_->xpos + 3 * place.body, data_->xmat + 9 * place.body) * place.X_BL;
}

ImuState World::imu_state(const Place& place) const {
  std::array<mjtNum, 6> velocity{};  // angular, linear, of the body's origin
  mj_objectVelocity(model_.get(), data_.get(), mjOBJ_XBODY, place.body, velocity.data(), 0);
  const Eigen::Isometry3d X = X_W(place);
  const Eigen::Vector3d lever = X.translation() - vector(data_->xpos + 3 * place.body);
  return {time_, X.linear(), vector(velocity.data() + 3) + vector(velocity.data()).cross(lever)};
}

double World::weight() const { return model_->body_subtreemass[ids_.waist] * gravity().norm(); }

Eigen::Vector3d World::gravity() const { return vector(model_->opt.gravity); }

Eigen::Isometry3d World::X_WB() const {
  return pose_in(data_->xpos + 3 * ids_.waist, data_->xmat + 9 * ids_.waist);
}

Eigen::Isometry3d World::camera_in_world(const mjData& data) const {
  // MuJoCo's camera looks along -z with y up.
  Eigen::Isometry3d X = pose_in(data.cam_xpos + 3 * ids_.camera, data.cam_xmat + 9 * ids_.camera);
  X.linear().col(1) *= -1;
  X.linear().col(2) *= -1;
  return X;
}

Eigen::Isometry3d World::X_WS(int site) const {
  return pose_in(data_->site_xpos + 3 * site, data_->site_xmat + 9 * site);
}

Eigen::Vector3d World::com() const { return vector(data_->subtree_com + 3 * ids_.waist); }

}  // namespace sim::physics
