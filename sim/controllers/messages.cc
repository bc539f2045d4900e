#include "sim/controllers/messages.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

namespace sim::controllers {
namespace {

using programs::bytes_of, programs::copy, programs::flag, programs::InvalidMessage, programs::isometry_of,
    programs::pop;

constexpr double kRotation = 1e-6;  // bound on R^T R - I
constexpr double kMostSettling_s = 60;

gaitslam_part part_of(std::string_view name, const Eigen::Isometry3d& X_BK, bool measures_wrench) {
  gaitslam_part part{};
  name.copy(part.name, sizeof part.name - 1);
  part.X_BK = programs::pose_of<gaitslam_pose>(X_BK);
  part.measures_wrench = measures_wrench;
  return part;
}

std::string name_of(const char* name) { return {name, strnlen(name, GAITSLAM_NAME_BYTES)}; }

void require(bool holds, const std::string& problem) {
  if (!holds) throw InvalidMessage(problem);
}

void require_speed(double value, const char* of) {
  require(std::isfinite(value) && value >= 0, fmt::format("its {} is {}, expected a speed", of, value));
}

void require_plan(const gaitslam_walk_plan& plan) {
  for (const gaitslam_pose* pose : {&plan.X_PB, &plan.X_PB_next, &plan.X_PL, &plan.X_PR}) {
    const Eigen::Matrix4d X = isometry_of(*pose).matrix();
    const Eigen::Matrix3d R = X.topLeftCorner<3, 3>();
    require(X.allFinite() && (R.transpose() * R).isIdentity(kRotation) && R.determinant() > 0,
            "a pose of its plan is not finite or not a rotation");
  }
  require(Eigen::Map<const Eigen::Vector4d>(plan.v_PB_P).allFinite(), "a velocity of its plan is not finite");
  require(
      plan.support <= GAITSLAM_SUPPORT_RIGHT,
      fmt::format("the support of its plan is {}, expected 0 (both), 1 (left) or 2 (right)", plan.support));
}

/// Reads the joints that the program commands.
void read_joints(std::string_view payload, const walking::Robot& robot, Ready& ready) {
  std::vector<std::string> names;
  for (const walking::Joint& joint : robot.joints) names.push_back(joint.name);
  for (std::uint32_t i = 0; i < ready.words.joint_count; ++i) {
    const auto joint = pop<gaitslam_commanded_joint>(payload, "READY");
    const std::string name = name_of(joint.name);
    const auto found = std::ranges::find(names, name);
    require(found != names.end(),
            fmt::format("it commands the joint {:?}, expected one of {}", name, fmt::join(names, ", ")));
    const auto index = static_cast<int>(found - names.begin());
    require(std::ranges::count(ready.joints, index) == 0, fmt::format("it names the joint {:?} twice", name));
    const walking::Joint& limits = robot.joints[static_cast<std::size_t>(index)];
    require(joint.start_rad >= limits.lowest && joint.start_rad <= limits.highest,
            fmt::format("the start angle of '{}' is {} rad, expected {} to {}", name, joint.start_rad,
                        limits.lowest, limits.highest));
    ready.joints.push_back(index);
    ready.names.push_back(name);
    ready.start[index] = joint.start_rad;
  }
  require(payload.empty(), fmt::format("{} bytes follow the joints of its READY", payload.size()));
}

}  // namespace

std::string start_message(const programs::Choice& choice, const walking::Robot& robot,
                          const RobotDescription& description, const std::string& walk, std::uint64_t seed) {
  const std::string options = programs::options_text(choice);
  gaitslam_walk_start words{};
  words.version = GAITSLAM_WALKER_VERSION;
  words.joint_count = static_cast<std::uint32_t>(robot.joints.size());
  words.tick_ns = std::chrono::nanoseconds(walking::kTick).count();
  words.gravity_m_s2 = walking::kGravity;
  words.seed = seed;
  words.options_bytes = options.size();
  words.walk_bytes = walk.size();
  words.model_bytes = description.model.size();
  std::vector<gaitslam_joint> joints;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const walking::Joint& from = robot.joints[i];
    const RobotDescription::Motor& motor = description.motors.at(i);
    gaitslam_joint& to = joints.emplace_back();
    from.name.copy(to.name, sizeof to.name - 1);
    copy(from.axis, to.axis);
    to.lowest_rad = from.lowest, to.highest_rad = from.highest;
    to.effort_nm = from.effort, to.speed_rad_s = std::numeric_limits<double>::infinity();
    to.armature_kg_m2 = motor.armature, to.damping_nms_rad = motor.damping;
    to.start_rad = robot.posture[static_cast<Eigen::Index>(i)];
    to.kp_nm_rad = motor.kp, to.kd_nms_rad = motor.kd;
  }
  const std::vector<gaitslam_part> parts{
      part_of("imu", description.X_BG, false),
      part_of("left", description.X_BS[std::size_t(walking::Side::left)], description.measures_wrenches),
      part_of("right", description.X_BS[std::size_t(walking::Side::right)], description.measures_wrenches)};
  const std::string_view zero("", 1);
  return programs::message(programs::Message::start, {bytes_of(words), bytes_of(joints), bytes_of(parts),
                                                      options, zero, walk, zero, description.model, zero});
}

std::string sensors_message(const gaitslam_walk_sensors& words, const Readings& readings,
                            std::string_view rig) {
  const auto bytes = [](const walking::JointVector& values) {
    return std::string_view(reinterpret_cast<const char*>(values.data()),
                            static_cast<std::size_t>(values.size()) * sizeof(double));
  };
  return programs::message(programs::Message::input, {bytes_of(words), bytes(readings.q), bytes(readings.dq),
                                                      bytes(readings.torque), rig});
}

std::size_t most_bytes(const walking::Robot& robot) {
  return std::max(sizeof(gaitslam_walk_ready) + robot.joints.size() * sizeof(gaitslam_commanded_joint),
                  sizeof(gaitslam_walk_answer) + robot.joints.size() * sizeof(gaitslam_joint_command)) +
         GAITSLAM_MOST_TEXT_BYTES;
}

Ready read_ready(std::string_view payload, const walking::Robot& robot) {
  std::string_view rest = payload;
  programs::check_ready(rest, GAITSLAM_WALKER_VERSION, "gaitslam_walker.h");
  Ready ready;
  ready.words = pop<gaitslam_walk_ready>(payload, "READY");
  const gaitslam_walk_ready& words = ready.words;
  const double ticks = 1 / (words.rate_hz * walking::kPeriod);
  require(
      words.rate_hz > 0 && ticks >= 1 && std::abs(ticks - std::round(ticks)) < 1e-9 * ticks && ticks < 201,
      fmt::format("its rate is {} Hz, expected a divisor of {} Hz of at least 1 Hz, such as 200, 100 or 50",
                  words.rate_hz, 1 / walking::kPeriod));
  ready.period = walking::kTick * std::lround(ticks);
  require(words.settle_s >= 0 && words.settle_s <= kMostSettling_s,
          fmt::format("its settle time is {} s, expected 0 to {}", words.settle_s, kMostSettling_s));
  require_speed(words.largest_vx_m_s, "largest vx");
  require_speed(words.largest_vy_m_s, "largest vy");
  require_speed(words.largest_wz_rad_s, "largest wz");
  require(words.duration_s >= 0 && std::isfinite(words.duration_s), "its duration is negative or not finite");
  flag(words.stands, "stands"), flag(words.wants_path, "wants_path"), flag(words.slopes, "slopes");
  flag(words.wants_rig, "wants_rig");
  const bool plans = flag(words.plans, "plans");
  require(plans || words.largest_vx_m_s + words.largest_wz_rad_s > 0,
          "its largest speeds are 0, expected positive speeds or `plans`");
  if (flag(words.has_plan, "has_plan")) require_plan(words.plan);
  require(words.joint_count > 0 && words.joint_count <= robot.joints.size(),
          fmt::format("it commands {} joints, expected 1 to {}", words.joint_count, robot.joints.size()));
  ready.start = robot.posture;
  read_joints(payload, robot, ready);
  return ready;
}

Answer read_answer(std::string_view payload, const Ready& ready, std::chrono::nanoseconds t, bool settles) {
  Answer answer;
  answer.words = pop<gaitslam_walk_answer>(payload, "ANSWER");
  const gaitslam_walk_answer& words = answer.words;
  const std::size_t joint_bytes = std::size_t{words.joint_count} * sizeof(gaitslam_joint_command);
  require(
      words.cause_bytes <= GAITSLAM_MOST_TEXT_BYTES && joint_bytes + words.cause_bytes == payload.size(),
      fmt::format("its ANSWER announces {} joints and a cause of {} bytes (at most {}), and {} bytes follow",
                  words.joint_count, words.cause_bytes, GAITSLAM_MOST_TEXT_BYTES, payload.size()));
  require(words.t_ns == t.count(),
          fmt::format("its answer has the stamp {} ns, expected the sensors' stamp, {} ns", words.t_ns,
                      t.count()));
  require(words.status <= GAITSLAM_WALKER_FINISHED,
          fmt::format("its status is {}, expected 0 (ok), 1 (not ready), 2 (gave up) or 3 (finished)",
                      words.status));
  const std::string cause = programs::printable(payload.substr(joint_bytes));
  require(words.status != GAITSLAM_WALKER_GAVE_UP,
          "it gave up: " + (cause.empty() ? "without a cause" : cause));
  const bool waits = words.status == GAITSLAM_WALKER_NOT_READY;
  require(!waits || settles, "it is not ready, but the walk has started");
  require(words.status != GAITSLAM_WALKER_FINISHED || ready.words.plans,
          "it finished, but only a controller with `plans` may");
  require(waits || words.joint_count == ready.joints.size(),
          fmt::format("it commands {} joints, expected {} as in its READY", words.joint_count,
                      ready.joints.size()));
  require(waits || flag(words.has_plan, "has_plan") == (ready.words.has_plan == 1),
          "its has_plan changes, expected the value in its READY");
  if (words.has_plan == 1) require_plan(words.plan);
  for (std::uint32_t i = 0; i < words.joint_count; ++i) {
    const auto& joint = answer.joints.emplace_back(pop<gaitslam_joint_command>(payload, "ANSWER"));
    const auto& [q, dq, kp, kd, torque] = joint;
    require(std::isfinite(q) && std::isfinite(dq) && std::isfinite(torque),
            fmt::format("its command of joint {} is not finite", ready.names[i]));
    require(kp >= 0 && kp <= GAITSLAM_MOST_KP && kd >= 0 && kd <= GAITSLAM_MOST_KD,
            fmt::format("its gains of joint {} are kp {} and kd {}, expected 0 to {} and 0 to {}",
                        ready.names[i], kp, kd, GAITSLAM_MOST_KP, GAITSLAM_MOST_KD));
  }
  return answer;
}

}  // namespace sim::controllers
