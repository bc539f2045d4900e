#include <algorithm>
#include <cstdio>
#include <memory>
#include <sstream>

#include "sim/controllers/messages.h"
#include "sim/controllers/plan_controller.h"
#include "sim/live/run.h"
#include "sim/physics/nominal_body.h"
#include "sim/physics/robot.h"
#include "sim/scenario/robot.h"
#include "sim/scenario/scenario.h"

#define GAITSLAM_WALKER_MAIN
#define main walker_main
#include "sim/controllers/gaitslam_walker.h"
#undef main

namespace sim::live {
namespace {

/// The program's options.
struct Options {
  bool plan = true;    ///< whether answers contain the plan
  bool slope = false;  ///< whether the soles follow the slope that they measure
};

Options read_options(const char* text) {
  Options options;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t end = line.find('=');
    const std::string name = line.substr(0, end), value = line.substr(end + 1);
    bool* const option = name == "plan" ? &options.plan : name == "slope" ? &options.slope : nullptr;
    if (!option || (value != "true" && value != "false"))
      throw std::invalid_argument("unknown option '" + line + "', expected plan or slope: true or false");
    *option = value == "true";
  }
  return options;
}

walking::Wrench wrench_of(const gaitslam_wrench& from) {
  return {Eigen::Vector3d(from.force_n), Eigen::Vector3d(from.torque_nm)};
}

class PlanProgram {
 public:
  explicit PlanProgram(const gaitslam_robot& start)
      : options_(read_options(start.options)),
        read_(scenario::read_scenario_text(start.walk, "walk")),
        models_(scenario::read_robot(read_.scenario), physics::kPhysicalRoom, scenario::standard_models()),
        controller_(walking::PatternGenerator(models_.robot, read_.scenario.walk,
                                              physics::nominal_body(copy_of(models_.on_floor))),
                    read_.scenario.stabilizer) {
    if (options_.slope) controller_.adapt_to_slope();
    for (std::size_t i = 0; i < models_.robot.joints.size(); ++i) {
      gaitslam_commanded_joint& joint = commanded_.emplace_back();
      models_.robot.joints[i].name.copy(joint.name, sizeof joint.name - 1);
      joint.start_rad = controller_.start()[static_cast<Eigen::Index>(i)];
      gains_.push_back({start.joints[i].kp_nm_rad, start.joints[i].kd_nms_rad});
    }
  }

  const gaitslam_commanded_joint* describe(gaitslam_walk_ready& ready) const {
    ready.rate_hz = 1 / walking::kPeriod;
    ready.stands = 1;
    ready.plans = 1;
    ready.duration_s = static_cast<double>(controller_.ticks()) * walking::kPeriod;
    ready.has_plan = options_.plan;
    ready.slopes = options_.slope;
    ready.plan = plan();
    ready.joint_count = static_cast<std::uint32_t>(commanded_.size());
    return commanded_.data();
  }

  void step(const gaitslam_walk_sensors& sensors, const double* q, gaitslam_walk_answer& answer,
            gaitslam_joint_command* commands) {
    const bool settles = sensors.command == GAITSLAM_WALK_SETTLE;
    if (!settles && sensors.t_ns > 0) controller_.advance();
    controllers::Readings readings;
    readings.q = Eigen::Map<const Eigen::VectorXd>(q, static_cast<Eigen::Index>(commanded_.size()));
    readings.gyro = Eigen::Vector3d(sensors.gyro_rad_s);
    readings.accelerometer = Eigen::Vector3d(sensors.accelerometer_m_s2);
    readings.left = wrench_of(sensors.left), readings.right = wrench_of(sensors.right);
    const controllers::JointCommands made = controller_.command(readings, settles);
    for (std::size_t i = 0; i < commanded_.size(); ++i) {
      const auto joint = static_cast<Eigen::Index>(i);
      commands[i] = {made.q[joint], made.dq[joint], gains_[i].first, gains_[i].second, 0};
    }
    if (!settles && controller_.is_last()) answer.status = GAITSLAM_WALKER_FINISHED;
    answer.has_plan = options_.plan;
    if (options_.plan) answer.plan = plan();
  }

 private:
  gaitslam_walk_plan plan() const {
    constexpr auto pose_of = programs::pose_of<gaitslam_pose>;
    const walking::Reference &now = controller_.reference(), next = controller_.following();
    gaitslam_walk_plan plan{
        pose_of(now.X_PB), pose_of(next.X_PB), pose_of(now.X_PL), pose_of(now.X_PR), {}, 0, 0, 0};
    std::copy_n(now.waist_velocity.data(), 3, plan.v_PB_P);
    plan.yaw_rate_rad_s = now.waist_yaw_rate;
    plan.support = static_cast<std::uint32_t>(now.support);
    return plan;
  }

  Options options_;
  scenario::ReadScenario read_;
  physics::Models models_;
  controllers::PlanController controller_;
  std::vector<gaitslam_commanded_joint> commanded_;
  std::vector<std::pair<double, double>> gains_;  // kp and kd of the robot's own servos
};

}  // namespace

int run_plan_program() { return walker_main(); }

}  // namespace sim::live

void* gaitslam_walker_create(const gaitslam_walk_start*, const gaitslam_robot* robot,
                             gaitslam_walk_ready* ready, const gaitslam_commanded_joint** commanded,
                             char* error, size_t error_bytes) {
  try {
    auto program = std::make_unique<sim::live::PlanProgram>(*robot);
    *commanded = program->describe(*ready);
    return program.release();
  } catch (const std::exception& e) {
    std::snprintf(error, error_bytes, "%s", e.what());
    return nullptr;
  }
}

int gaitslam_walker_step(void* walker, const gaitslam_walk_sensors* sensors, const double* q, const double*,
                         const double*, const void*, size_t, gaitslam_walk_answer* answer,
                         gaitslam_joint_command* commands, const char**) {
  static_cast<sim::live::PlanProgram*>(walker)->step(*sensors, q, *answer, commands);
  return 0;
}

void gaitslam_walker_destroy(void* walker) { delete static_cast<sim::live::PlanProgram*>(walker); }
