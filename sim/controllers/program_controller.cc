#include "sim/controllers/program_controller.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sim::controllers {
namespace {

using std::chrono::nanoseconds;

constexpr std::array kAhead_s{0.25, 0.5, 1.0, 2.0};

Eigen::Isometry3d between(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to, double part) {
  if (part == 0) return from;
  if (part == 1) return to;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::Quaterniond(from.linear()).slerp(part, Eigen::Quaterniond(to.linear())).matrix();
  X.translation() = (1 - part) * from.translation() + part * to.translation();
  return X;
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
      plan_(ready_.words.plan) {
  const auto joints = static_cast<Eigen::Index>(start_.robot.joints.size());
  commands_ = {ready_.start, walking::JointVector::Zero(joints), Gains{}};
  commands_.gains->torque = walking::JointVector::Zero(joints);
  commands_.gains->kp = commands_.gains->kd = commands_.gains->torque;
  for (Eigen::Index i = 0; i < joints; ++i) {
    const RobotDescription::Motor& motor = start_.description.motors[static_cast<std::size_t>(i)];
    commands_.gains->kp[i] = motor.kp, commands_.gains->kd[i] = motor.kd;
  }
  if (ready_.words.plans == 1) {
    if (start_.commands.steering.by != walking::SteeredBy::plan)
      throw std::invalid_argument(
          fmt::format("walk.steering.by: the walking controller {} plans its own steps, expected plan",
                      start_.choice.name));
  } else {
    const Velocity largest{ready_.words.largest_vx_m_s, ready_.words.largest_vy_m_s,
                           ready_.words.largest_wz_rad_s};
    follower_.emplace(Path(start_.commands.commands, largest), largest, start_.commands.steering);
  }
  refer();
}

JointCommands ProgramController::command(const Readings& readings, bool settles) {
  if (std::exchange(settling_, settles) && !settles) tick_ = 0, answered_ = 0, pending_.reset();
  // The axes of the readings are those of the IMU.
  attitude_.update(readings.gyro, readings.accelerometer, Eigen::Vector3d::Zero(), walking::kPeriod);
  if (now() % ready_.period == nanoseconds(0) && !pending_) ask(readings, settles);
  if (pending_ && effect_ <= now()) take_effect();
  refer();
  if (settles) ++tick_;
  return commands_;
}

void ProgramController::advance() {
  ++tick_;
  if (follower_) follower_->advance(walking::kPeriod);
  refer();
}

void ProgramController::ask(const Readings& readings, bool settles) {
  gaitslam_walk_sensors words{};
  words.t_ns = now().count();
  words.command = settles ? GAITSLAM_WALK_SETTLE : GAITSLAM_WALK_GO;
  words.joint_count = static_cast<std::uint32_t>(start_.robot.joints.size());
  if (follower_ && !settles) {
    words.command = follower_->stands() ? GAITSLAM_WALK_STAND : GAITSLAM_WALK_GO;
    const Velocity v = follower_->velocity();
    words.vx_m_s = v.ahead, words.vy_m_s = v.left, words.wz_rad_s = v.turn;
    for (std::size_t i = 0; ready_.words.wants_path == 1 && i < GAITSLAM_PATH_POINTS; ++i) {
      const walking::FootPose ahead = follower_->ahead(kAhead_s[i]);
      copy({ahead.position.x(), ahead.position.y(), ahead.yaw}, words.path[i]);
    }
  }
  copy(readings.gyro, words.gyro_rad_s);
  copy(readings.accelerometer, words.accelerometer_m_s2);
  copy(walking::imu_in_base(start_.robot, readings.q) * attitude_.up(), words.up_B);
  words.left = wrench_of(readings.left), words.right = wrench_of(readings.right);
  const auto begun = std::chrono::steady_clock::now();
  try {
    pending_ = read_answer(program_.ask(sensors_message(words, readings)), ready_, now(), settles);
  } catch (const programs::ProgramFailed& failure) {
    throw program_.failed(fmt::format("at t = {:.3f} s{}", std::chrono::duration<double>(now()).count(),
                                      settles ? " of settling" : ""),
                          failure.what());
  }
  const nanoseconds took = std::chrono::steady_clock::now() - begun;
  effect_ = now() + (start_.time.measured ? took
                                          : std::chrono::duration_cast<nanoseconds>(
                                                std::chrono::duration<double>(start_.time.fixed_s)));
}

void ProgramController::take_effect() {
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
  plan_ = answer.words.plan;
  answered_ = answer.words.t_ns / nanoseconds(walking::kTick).count();
}

// Without a plan, the commanded path takes its place, with the soles of the start posture.
void ProgramController::refer_to_path() {
  const auto place = [this](const walking::FootPose& on_path) {
    Eigen::Isometry3d X_PB = Eigen::Isometry3d::Identity();
    X_PB.translation() << on_path.position, start_.robot.base_height;
    X_PB.linear() = Eigen::AngleAxisd(on_path.yaw, Eigen::Vector3d::UnitZ()).matrix();
    return X_PB;
  };
  const walking::FootPose here = follower_ ? follower_->desired() : walking::FootPose{};
  const Velocity v = follower_ ? follower_->velocity() : Velocity{};
  reference_.X_PB = place(here);
  following_ = reference_;
  following_.X_PB = place(here * walking::FootPose{Eigen::Vector2d(v.ahead, v.left) * walking::kPeriod,
                                                   v.turn * walking::kPeriod});
  following_.t_s += walking::kPeriod;
  reference_.X_PL = reference_.X_PB * start_.description.X_BS[std::size_t(walking::Side::left)];
  reference_.X_PR = reference_.X_PB * start_.description.X_BS[std::size_t(walking::Side::right)];
}

// Between two answers the planned base moves from X_PB to X_PB_next.
void ProgramController::refer() {
  const auto ticks = static_cast<double>(ready_.period / nanoseconds(walking::kTick));
  const auto since = static_cast<double>(tick_ - answered_);
  const Eigen::Isometry3d from = isometry_of(plan_.X_PB), to = isometry_of(plan_.X_PB_next);
  reference_.t_s = settling_ ? 0 : static_cast<double>(tick_) * walking::kPeriod;
  if (!has_plan()) return refer_to_path();
  reference_.X_PB = between(from, to, std::min(since / ticks, 1.0));
  reference_.X_PL = isometry_of(plan_.X_PL), reference_.X_PR = isometry_of(plan_.X_PR);
  reference_.waist_velocity = Eigen::Map<const Eigen::Vector3d>(plan_.v_PB_P);
  reference_.waist_yaw_rate = plan_.yaw_rate_rad_s;
  reference_.support = static_cast<walking::Support>(plan_.support);
  following_ = reference_;
  following_.t_s += walking::kPeriod;
  following_.X_PB = between(from, to, std::min((since + 1) / ticks, 1.0));
}

std::string ProgramController::finish() {
  std::string log = program_.finish();
  if (clipped_ > 0)
    log += fmt::format("gaitslam: {} commanded angles were beyond the range of their joints and clipped\n",
                       clipped_);
  return log;
}

double ProgramController::progress() const {
  if (follower_) return follower_->progress();
  return ready_.words.duration_s > 0
             ? std::min(1.0, static_cast<double>(tick_) * walking::kPeriod / ready_.words.duration_s)
             : 0;
}

}  // namespace sim::controllers
