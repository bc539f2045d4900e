#include "sim/controllers/program_controller.h"

#include <fmt/format.h>

namespace sim::controllers {
namespace {

using programs::copy, programs::isometry_of;
using std::chrono::nanoseconds;

constexpr std::array kAhead_s{0.25, 0.5, 1.0, 2.0};
// Half a step of public policies, whose two steps take 0.64 to 1 s. A command can end half a step off,
// because a velocity moves the robot by whole steps.
constexpr double kHalfStep_s = 0.2;
// Errors of the velocity by the legs: slip and the tilt of the soles. Measured with the policy of
// unitree_rl_gym on the G1: 0.031, 0.014 and 0.017 m/s at 0.3 m/s.
const Eigen::Vector3d kVelocitySigma_m_s{0.015, 0.015, 0.015};
constexpr double kVelocitySigma = 0.05;

/// Interpolates between two poses; parts 0 and 1 return them bit for bit.
Eigen::Isometry3d between(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to, double part) {
  return part == 0 ? from : part == 1 ? to : walking::pose_between(from, to, part);
}

gaitslam_wrench wrench_of(const walking::Wrench& from) {
  gaitslam_wrench to{};
  copy(from.force, to.force_n), copy(from.torque, to.torque_nm);
  return to;
}

}  // namespace

ProgramController::ProgramController(ProgramStart start)
    : start_(std::move(start)),
      program_(
          start_.choice, "walking controller",
          start_message(start_.choice, start_.robot, start_.description, start_.walk, start_.seed),
          [this](std::string_view payload) { ready_ = read_ready(payload, start_.robot); },
          most_bytes(start_.robot)),
      attitude_(Eigen::Vector3d::UnitZ(), start_.attitude),
      legs_(start_.robot, Eigen::Isometry3d::Identity(), walking::Floor::any),
      answer_(ready_.words.plan) {
  const auto joints = static_cast<Eigen::Index>(start_.robot.joints.size());
  commands_ = {ready_.start, walking::JointVector::Zero(joints), Gains{},
               ready_.period == nanoseconds(walking::kTick)};
  commands_.gains->torque = walking::JointVector::Zero(joints);
  commands_.gains->kp = commands_.gains->kd = commands_.gains->torque;
  for (Eigen::Index i = 0; i < joints; ++i) {
    const RobotDescription::Motor& motor = start_.description.motors[static_cast<std::size_t>(i)];
    commands_.gains->kp[i] = motor.kp, commands_.gains->kd[i] = motor.kd;
  }
  if (ready_.words.plans == 1) {
    walking::SteeredBy& by = start_.commands.steering.by;
    if (by == walking::SteeredBy::legs) by = walking::SteeredBy::plan;  // a robot's default
    if (by != walking::SteeredBy::plan)
      throw std::invalid_argument(
          fmt::format("walk.steering.by: the walking controller {} plans its own steps, expected plan",
                      start_.choice.name));
  } else {
    const Velocity largest{ready_.words.largest_vx_m_s, ready_.words.largest_vy_m_s,
                           ready_.words.largest_wz_rad_s};
    const walking::SteeringOptions& given = start_.commands.steering;
    walking::SteeringOptions steering =
        given.with_tolerance(kHalfStep_s * largest.ahead, kHalfStep_s * largest.turn);
    if (steering.by == walking::SteeredBy::plan)  // a command then ends after its duration
      steering.tolerance_m = steering.tolerance_rad = std::numeric_limits<double>::infinity();
    follower_.emplace(Path(start_.commands.commands, largest), largest, steering, !stands());
  }
  refer();
}

JointCommands ProgramController::command(const Readings& readings, bool settles) {
  if (std::exchange(settling_, settles) && !settles) tick_ = 0, answered_ = 0, pending_.reset();
  // The readings have the IMU's axes.
  attitude_.update(readings.gyro, readings.accelerometer, Eigen::Vector3d::Zero(), walking::kPeriod);
  legs_.add(readings);
  if (!settles) on_path_.push_back(walking::on_floor(reference().X_PB));
  take_effect();
  if (now() % ready_.period == nanoseconds(0) && !pending_) ask(readings, settles);
  take_effect();
  refer();
  if (settles) ++tick_;
  return commands_;
}

void ProgramController::advance() {
  ++tick_;
  if (follower_) {
    if (has_plan()) locate();
    if (follower_->is_over()) stopping_s_ += walking::kPeriod;
    follower_->advance(walking::kPeriod);
  }
  refer();
}

void ProgramController::start_at(const walking::FootPose& start) {
  start_at_ = start;
  if (follower_) follower_->start_at(start);
  refer();
}

void ProgramController::steer(std::size_t, const std::optional<walking::PlaceEstimate>& newest) {
  if (!newest) return;
  located_ = *newest;
  if (!has_plan()) follower_->locate(*newest);
  X_WP_.yaw = newest->estimated.yaw - newest->planned.yaw;
  X_WP_.position =
      newest->estimated.position - (walking::FootPose{{0, 0}, X_WP_.yaw} * newest->planned).position;
}

// Places the robot using the newest estimate of the plan's drift; if steering uses no estimates, the drift is
// assumed to be zero.
void ProgramController::locate() {
  const bool estimates = start_.commands.steering.by != walking::SteeredBy::plan;
  if (estimates && !located_) return;
  follower_->locate({located_ ? located_->t_s : plan_.now.t_s, follower_->desired(),
                     X_WP_ * walking::on_floor(plan_.now.X_PB)});
}

// Sets the mean velocity since the last SENSORS.
void ProgramController::measure_velocity(const Readings& readings, gaitslam_walk_sensors& words) {
  const Eigen::Isometry3d X_OB = legs_.motion(readings.q).X_OB;
  const double dt_s = std::chrono::duration<double>(ready_.period).count();
  const Eigen::Vector3d v_B =
      X_OB.linear().transpose() * (X_OB.translation() - X_OB_.value_or(X_OB).translation()) / dt_s;
  X_OB_ = X_OB;
  copy(v_B, words.velocity_m_s);
  copy(kVelocitySigma_m_s + kVelocitySigma * v_B.norm() * Eigen::Vector3d::Ones(), words.velocity_sigma_m_s);
}

gaitslam_walk_place ProgramController::place() const {
  const double ticks = located_->t_s / walking::kPeriod;
  const std::size_t last = on_path_.size() - 1, before = std::min(last, static_cast<std::size_t>(ticks));
  const walking::FootPose step = inverse(on_path_[before]) * on_path_[std::min(last, before + 1)];
  const double part = std::min(1.0, ticks - static_cast<double>(before));
  const walking::FootPose X_WB =
      X_WP_ * (on_path_[before] * walking::FootPose{part * step.position, part * step.yaw});
  gaitslam_walk_place place{
      std::llround(1e9 * located_->t_s), X_WB.position.x(), X_WB.position.y(), X_WB.yaw, {}};
  Eigen::Map<programs::RowMajor3d>(place.covariance) = located_->covariance;
  return place;
}

void ProgramController::ask(const Readings& readings, bool settles) {
  gaitslam_walk_sensors words{};
  words.t_ns = now().count();
  words.command = settles ? GAITSLAM_WALK_SETTLE : GAITSLAM_WALK_GO;
  words.joint_count = static_cast<std::uint32_t>(start_.robot.joints.size());
  if (follower_ && !settles) {
    words.command = follower_->is_over()  ? GAITSLAM_WALK_STOP
                    : follower_->stands() ? GAITSLAM_WALK_STAND
                                          : GAITSLAM_WALK_GO;
    const Velocity v = follower_->velocity();
    words.vx_m_s = v.ahead, words.vy_m_s = v.left, words.wz_rad_s = v.turn;
    for (std::size_t i = 0; ready_.words.wants_path == 1 && i < GAITSLAM_PATH_POINTS; ++i) {
      const walking::FootPose ahead = follower_->ahead(kAhead_s[i]);
      copy({ahead.position.x(), ahead.position.y(), ahead.yaw}, words.path[i]);
    }
  }
  copy(readings.gyro, words.gyro_rad_s);
  copy(readings.accelerometer, words.accelerometer_m_s2);
  copy(walking::imu_in_base(start_.robot, readings.q).linear() * attitude_.up(), words.up_B);
  words.left = wrench_of(readings.left), words.right = wrench_of(readings.right);
  measure_velocity(readings, words);
  words.has_place = located_ && start_.commands.steering.by == walking::SteeredBy::estimate;
  if (words.has_place) words.place = place();
  const Clock::time_point begun = Clock::now();
  try {
    const std::string bytes = program_.ask(sensors_message(words, readings, std::exchange(rig_, {})));
    answers_.add_part(bytes);
    pending_ = read_answer(bytes, ready_, now(), settles);
  } catch (const programs::ProgramFailed& failure) {
    throw program_.failed(fmt::format("at t = {:.3f} s{}", std::chrono::duration<double>(now()).count(),
                                      settles ? " of settling" : ""),
                          failure.what());
  }
  const nanoseconds time = Clock::now() - begun;
  took(time);
  effect_ = now() + (start_.time.measured ? time
                                          : std::chrono::duration_cast<nanoseconds>(
                                                std::chrono::duration<double>(start_.time.fixed_s)));
}

void ProgramController::take_effect() {
  if (!pending_ || effect_ > now()) return;
  const Answer answer = std::move(*pending_);
  pending_.reset();
  if (answer.words.status == GAITSLAM_WALKER_NOT_READY) return;
  finished_ = answer.words.status == GAITSLAM_WALKER_FINISHED;
  for (std::size_t i = 0; i < answer.joints.size(); ++i) {
    const Eigen::Index joint = ready_.joints[i];
    const walking::Joint& limits = start_.robot.joints[static_cast<std::size_t>(joint)];
    const gaitslam_joint_command& given = answer.joints[i];
    const double q = std::clamp(given.q_rad, limits.lowest, limits.highest);
    clipped_ += q != given.q_rad;
    commands_.q[joint] = q, commands_.dq[joint] = given.dq_rad_s;
    commands_.gains->kp[joint] = given.kp_nm_rad, commands_.gains->kd[joint] = given.kd_nms_rad;
    commands_.gains->torque[joint] = given.torque_nm;
  }
  answer_ = answer.words.plan;
  answered_ = answer.words.t_ns / nanoseconds(walking::kTick).count();
}

// Sets path_ from the commanded path, with the soles as in the start posture.
void ProgramController::refer_to_path() {
  const auto sole = [this](walking::Side side) {
    return sole_in_base(start_.robot, side, leg_angles(start_.robot.leg(side), ready_.start));
  };
  const Eigen::Isometry3d X_BL = sole(walking::Side::left), X_BR = sole(walking::Side::right);
  const auto place = [&](const walking::FootPose& on_path) {
    Eigen::Isometry3d X_PB = Eigen::Isometry3d::Identity();
    X_PB.translation() << on_path.position, -(X_BL.translation() + X_BR.translation()).z() / 2;
    X_PB.linear() = Eigen::AngleAxisd(on_path.yaw, Eigen::Vector3d::UnitZ()).matrix();
    return X_PB;
  };
  const walking::FootPose here = follower_ ? follower_->desired() : start_at_;
  const Velocity v = follower_ ? follower_->velocity() : Velocity{};
  path_.now.X_PB = place(here);
  path_.next = path_.now;
  path_.next.X_PB = place(here * walking::FootPose{Eigen::Vector2d(v.ahead, v.left) * walking::kPeriod,
                                                   v.turn * walking::kPeriod});
  path_.now.X_PL = path_.now.X_PB * X_BL;
  path_.now.X_PR = path_.now.X_PB * X_BR;
}

// Between two answers the planned base moves from X_PB to X_PB_next.
void ProgramController::refer_to_plan() {
  const auto ticks = static_cast<double>(ready_.period / nanoseconds(walking::kTick));
  const auto since = static_cast<double>(tick_ - answered_);
  const Eigen::Isometry3d from = isometry_of(answer_.X_PB), to = isometry_of(answer_.X_PB_next);
  plan_.now.X_PB = between(from, to, std::min(since / ticks, 1.0));
  plan_.now.X_PL = isometry_of(answer_.X_PL), plan_.now.X_PR = isometry_of(answer_.X_PR);
  plan_.now.waist_velocity = Eigen::Map<const Eigen::Vector3d>(answer_.v_PB_P);
  plan_.now.waist_yaw_rate = answer_.yaw_rate_rad_s;
  plan_.now.support = static_cast<walking::Support>(answer_.support);
  plan_.next = plan_.now;
  plan_.next.X_PB = between(from, to, std::min((since + 1) / ticks, 1.0));
}

void ProgramController::refer() {
  if (follower_ || !has_plan()) refer_to_path();
  if (has_plan()) refer_to_plan();
  for (Ticks* ticks : {&plan_, &path_}) {
    ticks->now.t_s = settling_ ? 0 : static_cast<double>(tick_) * walking::kPeriod;
    ticks->next.t_s = ticks->now.t_s + walking::kPeriod;
  }
}

std::string ProgramController::answers() const {
  return fmt::format("{{\n  \"answers\": {},\n  \"xxh3_128\": \"{}\"\n}}\n", took_ms().size(),
                     answers_.hex());
}

std::string ProgramController::finish() {
  std::string log = program_.finish();
  if (clipped_ > 0)
    log +=
        fmt::format("gaitslam: {} of {} commanded angles were beyond the range of their joints and clipped\n",
                    clipped_, took_ms().size() * ready_.joints.size());
  return log;
}

double ProgramController::progress() const {
  if (follower_) return follower_->progress();
  return ready_.words.duration_s > 0
             ? std::min(1.0, static_cast<double>(tick_) * walking::kPeriod / ready_.words.duration_s)
             : 0;
}

}  // namespace sim::controllers
