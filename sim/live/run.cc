#include "sim/live/run.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/estimators/messages.h"
#include "sim/live/frame_pipeline.h"
#include "sim/live/self_check.h"
#include "sim/live/setup.h"
#include "sim/live/steering_pose_buffer.h"
#include "sim/physics/walking_robot.h"
#include "sim/scenario/robot.h"
#include "sim/sensor_errors/random.h"
#include "walking/kinematics.h"
#include "walking/leg_odometry.h"

namespace sim::live {
namespace {

slam::Support support(walking::Support s) {
  if (s == walking::Support::both) return slam::Support::both;
  return s == walking::Support::left ? slam::Support::left : slam::Support::right;
}

Eigen::Vector3d support_sole(const walking::Reference& reference) {
  const Eigen::Vector3d left = reference.X_PL.translation(), right = reference.X_PR.translation();
  if (reference.support == walking::Support::both) return (left + right) / 2;
  return reference.support == walking::Support::left ? left : right;
}

Eigen::Vector3d on_ground(const Eigen::Isometry3d& X) {
  return {X.translation().x(), X.translation().y(), std::atan2(X.linear()(1, 0), X.linear()(0, 0))};
}

Eigen::Vector3d planar(const walking::FootPose& pose) {
  return {pose.position.x(), pose.position.y(), pose.yaw};
}

recording::TrueFoot true_foot(const Eigen::Isometry3d& X_WS, const Eigen::Isometry3d& X_PS, bool planned_down,
                              const physics::SoleContact& contact) {
  return {on_ground(X_WS), on_ground(X_PS), planned_down, contact.load,
          Eigen::Vector3d(contact.creep.x(), contact.creep.y(), contact.creep_yaw)};
}

/// The waist pose X_PB at time t (s), from.t_s <= t <= to.t_s. Position and yaw are linear between the two
/// references, which are one control period apart. The plan accelerates by at most a few m/s², so the error
/// is below 20 µm.
Eigen::Isometry3d planned_waist(const walking::Reference& from, const walking::Reference& to, double t_s) {
  return walking::pose_between(from.X_PB, to.X_PB, (t_s - from.t_s) / walking::kPeriod);
}

/// The planned motion of a camera fixed to the waist at X_BC. Its velocities are taken at the tick before t.
slam::PlannedMotion planned_motion(const walking::Reference& from, const walking::Reference& to, double t_s,
                                   const Eigen::Isometry3d& X_BC) {
  slam::PlannedMotion motion;
  motion.X_PC = planned_waist(from, to, t_s) * X_BC;
  const Eigen::Matrix3d R_CP = motion.X_PC.linear().transpose();
  const Eigen::Vector3d w_PB_P = from.waist_yaw_rate * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d p_BC_P = from.X_PB.linear() * X_BC.translation();
  motion.v_PC_C = R_CP * (from.waist_velocity + w_PB_P.cross(p_BC_P));
  motion.w_PC_C = R_CP * w_PB_P;
  motion.support = support(from.support);
  motion.p_CF = motion.X_PC.inverse() * support_sole(from);
  return motion;
}

std::vector<score::StepCorrection> recorded(const std::vector<walking::StepCorrection>& corrections) {
  std::vector<score::StepCorrection> steps;
  for (const walking::StepCorrection& c : corrections)
    steps.push_back({std::chrono::nanoseconds(std::llround(1e9 * c.decided_s)), c.correction.position.x(),
                     c.correction.position.y(), c.correction.yaw, c.desired.side == walking::Side::left,
                     planar(c.desired.pose), planar(c.expected)});
  return steps;
}

slam::BodyReading recorded(std::chrono::nanoseconds t, const walking::SensorReadings& readings) {
  const auto wrench = [](const walking::Wrench& w) { return slam::BodyReading::Wrench{w.force, w.torque}; };
  return {t, readings.q, wrench(readings.left), wrench(readings.right)};
}

recording::TrueMotion true_motion(const physics::World& world) {
  return {world.time(), world.X_WG(), world.v_WG()};
}

/// Returns both feet, true and planned, with load and creep since the last call.
recording::TrueFeet true_feet(physics::World& world, const walking::Reference& plan) {
  const auto [left, right] = world.sole_contacts_since_last();
  return {world.time(), true_foot(world.X_WL(), plan.X_PL, plan.support != walking::Support::right, left),
          true_foot(world.X_WR(), plan.X_PR, plan.support != walking::Support::left, right),
          world.torque_limited_since_last()};
}

scenario::Ending ending(physics::Condition condition) {
  using enum scenario::Ending;
  constexpr std::array kEndings{completed, fell, collided, failed};  // in the order of the conditions
  return kEndings[static_cast<std::size_t>(condition)];
}

/// The rig's additional IMUs, each read at its own period.
class RigImus {
 public:
  RigImus(const std::vector<rig::Item>& rig, const std::vector<physics::Place>& places,
          const physics::World& world) {
    for (std::size_t i = 0; i < rig.size(); ++i)
      if (const auto* imu = std::get_if<rig::Imu>(&rig[i]))
        imus_.push_back({static_cast<int>(i), places[i],
                         std::chrono::milliseconds(std::llround(1e3 / imu->rate_hz)),
                         world.imu_state(places[i])});
  }
  /// Appends the readings that end now. Must be called every millisecond.
  void read(const physics::World& world, std::vector<slam::RigReading>& readings) {
    for (auto& [sensor, place, period, last] : imus_) {
      if (world.time() < last.t + period) continue;
      const physics::ImuState now = world.imu_state(place);
      const physics::ImuReading reading = physics::reading_between(last, now, world.gravity());
      slam::RigReading& added = readings.emplace_back();
      added.sensor = sensor;
      added.begin = reading.begin, added.t = reading.end;
      added.gyro = reading.gyro, added.accelerometer = reading.specific_force;
      last = now;
    }
  }

 private:
  struct Imu {
    int sensor;
    physics::Place place;
    slam::Stamp period;
    physics::ImuState last;
  };
  std::vector<Imu> imus_;
};

/// The walking robot, its own sensors, and the quantities computed from them: noisy readings for the
/// stabilizer, and leg odometry.
class SensingRobot {
 public:
  SensingRobot(const scenario::Scenario& scenario, std::unique_ptr<controllers::Controller> controller,
               const physics::Models& models)
      : noise_(scenario.stabilizer, scenario.seed),
        legs_(models.robot, controller->reference().X_PB,
              controller->is_level() ? walking::Floor::level : walking::Floor::any),
        robot_(std::move(controller), scenario.world,
               plant_variation(scenario.world.variation.seed ? scenario.world.variation.seed : scenario.seed,
                               scenario.world, static_cast<int>(models.robot.joints.size())),
               models, Eigen::Isometry3d::Identity(), &legs_),
        mounting_(live::mounting(scenario, robot_.controller(), models)),
        imus_(scenario.rig, places(scenario.rig, *models.on_floor), robot_.world()) {
    const walking::SensorReadings readings = robot_.world().leg_readings();
    legs_.add(readings);
    if (!robot_.controller().has_plan())
      legs_.move_to(walking::on_floor(robot_.reference().X_PB), readings.q);
  }

  physics::WalkingRobot* operator->() { return &robot_; }
  const physics::WalkingRobot* operator->() const { return &robot_; }
  const walking::LegOdometry& legs() const { return legs_; }
  const Mounting& mounting() const { return mounting_; }
  recording::RecordingSetup setup(const scenario::Scenario& scenario, const walking::Robot& robot) const {
    recording::RecordingSetup setup = recording_setup(scenario, robot, mounting_, start());
    setup.calibration.level_floor = robot_.controller().is_level();
    return setup;
  }
  /// The camera at t = 0 as the robot knows it: by its plan; or, above the place where its walk begins, by
  /// its legs since it was released.
  Eigen::Isometry3d start() const {
    if (robot_.controller().has_plan()) return robot_.reference().X_PB * mounting_.X_BC;
    const physics::World& world = robot_.world();
    return legs_.motion(world.leg_readings().q).X_OB * world.mounts_by_encoders().X_BC;
  }
  /// Appends the readings of the rig's IMUs that end now. Must be called every millisecond.
  void read_imus(std::vector<slam::RigReading>& readings) { imus_.read(robot_.world(), readings); }

  /// Commands the servos for this tick. Returns the readings without noise.
  walking::SensorReadings command() {
    const walking::SensorReadings ideal = robot_.world().sensor_readings();
    walking::SensorReadings noisy = ideal;
    noise_.add(noisy);
    legs_.add(noisy);
    robot_.command(noisy);
    return ideal;
  }

 private:
  FeltNoise noise_;
  walking::LegOdometry legs_;
  physics::WalkingRobot robot_;
  Mounting mounting_;
  RigImus imus_;
};

/// The models of a run, with its sensors mounted, and its plan if the built-in controller walks. Throws as
/// run() does.
struct Start {
  Start(const scenario::ReadScenario& read, const std::filesystem::path& folder)
      : models(scenario::read_robot(read.scenario), read.scenario.world.room, folder,
               read.scenario.world.actors_in_W()) {
    arrange(read, models);
    if (read.scenario.controller.source == programs::Source::built_in) plan = clear_plan(read, models);
    mount_sensors(read, models);
  }
  std::unique_ptr<controllers::Controller> controller(const scenario::ReadScenario& read) const {
    if (plan)
      return std::make_unique<controllers::PlanController>(*plan, read.scenario.stabilizer,
                                                           read.scenario.walk.steering);
    return program_controller(read, models);
  }
  physics::Models models;
  std::optional<walking::PatternGenerator> plan;
};

/// One run. walk() and the functions it calls are in the order of a simulated tick.
class Run {
 public:
  /// folder: of the recording.
  Run(const scenario::ReadScenario& read, const estimators::Session& session, const Start& start,
      const std::filesystem::path& folder, int threads, const RunObserver& observer);

  void walk(const result::Progress& progress);
  result::RunRecord record(const std::filesystem::path& folder);
  const result::Timing& timing() const { return timing_.all; }
  /// Dividing by 1e9 would differ in the last bit from the times in recordings.
  double time_s() const { return 1e-9 * static_cast<double>(robot_->world().time().count()); }

 private:
  void command();
  void step_until(slam::Stamp end);
  void process_frames();
  void stamp_frame();
  void read_imu();
  void deliver_frame();
  void steer();
  void add_steering_poses();

  const scenario::ReadScenario& read_;
  const RunObserver& observer_;
  SensingRobot robot_;
  recording::RecordingSetup setup_;
  std::optional<tracking::Tracking>
      tracking_;  // before the cameras: a program that rejects its start costs no rendering
  FramePipeline frames_;
  recording::RecordingWriter writer_;
  InertialCheck check_;
  std::optional<SteeringPoseBuffer> steering_;  // only if the truth or estimates steer
  std::size_t steering_answers_ = 0;            // number of the estimator's answers added to it
  slam::Observation next_;                      // readings of IMUs, encoders and forces since the last frame
  struct {
    walking::Wrench left, right;  // ground on feet
    recording::TrueFeet feet;     // at the end of the tick
  } last_tick_;
  struct {
    result::Timing all;
    result::FrameTiming frame;  // timing of the next frame
  } timing_;
};

Run::Run(const scenario::ReadScenario& read, const estimators::Session& session, const Start& start,
         const std::filesystem::path& folder, int threads, const RunObserver& observer)
    : read_(read),
      observer_(observer),
      robot_(read.scenario, start.controller(read), start.models),
      setup_(robot_.setup(read.scenario, start.models.robot)),
      tracking_(read.scenario.slam ? std::optional<tracking::Tracking>(
                                         std::in_place, read.scenario, setup_.calibration, setup_.X_WC_start,
                                         setup_.camera_rate_hz, setup_.rig, setup_.joints, session)
                                   : std::nullopt),
      frames_(read.scenario, start.models, threads > 1),
      writer_(folder, setup_),
      check_(true_motion(robot_->world())) {
  for (const score::Surface& surface : frames_.surfaces()) writer_.add(surface);
  if (observer_.begins) observer_.begins(setup_);
  if (const auto by = read.scenario.walk.steering.by;
      by == walking::SteeredBy::truth || by == walking::SteeredBy::estimate)
    steering_.emplace(read.scenario.walk.steering, read.scenario.errors.faults, frames_.lead());
  if (!robot_->controller().wants_rig()) return;
  estimators::Start sensors{
      setup_.calibration, setup_.X_WC_start, read.scenario.seed, {}, setup_.camera_rate_hz};
  sensors.rig = setup_.rig, sensors.joints = setup_.joints;
  robot_->controller().add_rig(estimators::start_message({}, sensors));
}

void Run::walk(const result::Progress& progress) {
  if (!robot_->is_ok()) return;  // it fell while settling
  frames_.add_positions(robot_->world());
  process_frames();
  while (robot_->walks()) {
    command();
    if (robot_->failure()) break;
    for (const slam::Stamp end = robot_->world().time() + walking::kTick;
         robot_->is_ok() && robot_->world().time() < end;) {
      step_until(std::min(end, frames_.next_event()));
      process_frames();
    }
    read_imu();
    last_tick_.feet = true_feet(robot_->world(), robot_->reference());
    writer_.add(last_tick_.feet);
    steer();
    robot_->advance();
    progress(robot_->progress());
    if (observer_.ticked) observer_.ticked(robot_->world().time());
  }
  frames_.draw_complete();
  while (!frames_.empty()) deliver_frame();
}

// Called every 5 ms.
void Run::command() {
  const slam::Stamp now = robot_->world().time();
  while (robot_->controller().wants_rig() && !frames_.empty() && frames_.next_stamp() + frames_.lead() <= now)
    deliver_frame();
  const result::StageClock clock(timing_.frame.plan_and_physics_ms);
  const walking::SensorReadings readings = robot_.command();
  next_.body.push_back(recorded(now, readings));
  writer_.add(next_.body.back());
  writer_.add(now, robot_->world().torques());
  last_tick_.left = readings.left, last_tick_.right = readings.right;
}

// Steps by a millisecond at a time.
void Run::step_until(slam::Stamp end) {
  const result::StageClock clock(timing_.frame.plan_and_physics_ms);
  do {
    robot_->world().step();
    frames_.add_positions(robot_->world());
    robot_.read_imus(next_.rig);
  } while (robot_->is_ok() && robot_->world().time() < end);
}

void Run::process_frames() {
  const slam::Stamp now = robot_->world().time();
  if (now >= frames_.next_due()) stamp_frame();
  frames_.draw_complete(now);
  while (frames_.is_full()) deliver_frame();
}

void Run::stamp_frame() {
  const physics::World& world = robot_->world();
  const walking::Reference &from = robot_->reference(), to = robot_->following();
  read_imu();
  next_.t = world.time();
  if (robot_->controller().has_plan())
    next_.plan = planned_motion(from, to, time_s(), robot_.mounting().X_BC);
  const slam::Stamp now = world.time(), tick = slam::Stamp(walking::kTick);  // a tick includes its end
  const double into_s = now.count() > 0 ? slam::seconds((now - slam::Stamp(1)) % tick + slam::Stamp(1)) : 0;
  const auto [X_OB, p_OS] = robot_.legs().motion(world.leg_readings().q, into_s);
  const auto [X_BC, X_CG] = world.mounts_by_encoders();
  const Eigen::Isometry3d X_OC = X_OB * X_BC;
  next_.legs = {X_OC, X_OC.inverse() * p_OS, X_CG};
  if (const auto v = robot_->controller().velocity()) next_.command = {next_.t, v->ahead, v->left, v->turn};
  const Eigen::Isometry3d followed = planned_waist(from, to, time_s());
  if (steering_) {  // from the plan without adjusted landings, or from the path if there is no plan
    slam::PlannedMotion motion = next_.plan.value_or(slam::PlannedMotion());
    motion.X_PC = followed * robot_.mounting().X_BC;
    motion.X_PC.translation().head<2>() -= from.frame_shift;
    if (!next_.plan) motion.p_CF = robot_.mounting().X_BC.inverse().translation();
    steering_->add(next_.t, motion);
  }
  if (observer_.stamped)
    observer_.stamped({next_.t, world, from, followed * robot_.mounting().X_BC, last_tick_.feet,
                       last_tick_.left, last_tick_.right});
  frames_.push({std::exchange(next_, {}), world.X_WC()});
  recording::TruePoses poses{world.time(), world.X_WC(), world.X_WB()};
  if (robot_->controller().has_plan()) poses.X_PB = followed;
  if (const auto path = robot_->controller().path())
    poses.X_WB_desired = planned_waist(path->now, path->next, time_s());
  writer_.add(poses);
}

// Called at the end of each tick and at each frame's stamp within it.
void Run::read_imu() {
  const physics::ImuReading reading = robot_->world().imu_since_last();
  if (reading.begin == reading.end) return;
  next_.gyro.push_back({reading.begin, reading.end, reading.gyro});
  next_.accelerometer.push_back({reading.begin, reading.end, reading.specific_force});
  const recording::TrueMotion motion = true_motion(robot_->world());
  writer_.add(motion);
  check_.add(next_.gyro.back(), next_.accelerometer.back(), motion);
}

// Delivers a frame to the recording and, if the scenario has one, to the filter.
void Run::deliver_frame() {
  Frame frame = frames_.pop();
  const slam::Stamp t = frame.observation.t;
  timing_.frame.t = t;
  timing_.frame.render_ms = frame.render_ms;
  timing_.frame.encode_ms = frame.encode_ms;
  {
    const result::StageClock clock(timing_.frame.record_ms);
    writer_.add(frame.observation, frame.png, frame.rig_pngs);
  }
  std::optional<slam::Observation> shown;
  if (observer_.wants && observer_.wants(frame.observation)) {
    shown = frame.observation;
    shown->image = shown->image.clone();  // sensor errors may be applied in place
  }
  if (robot_->controller().wants_rig())
    robot_->controller().add_rig(estimators::observation_message(frame.observation, setup_.rig));
  if (tracking_) {
    tracking_->process(std::move(frame.observation));
    timing_.frame.filter_ms += tracking_->cpu_ms();
    timing_.frame.landmarks = tracking_->landmarks();
    timing_.frame.answered = tracking_->has_answered();
  }
  if (shown) observer_.tracked(*shown, tracking_ ? &*tracking_ : nullptr);
  if (read_.scenario.walk.steering.by == walking::SteeredBy::truth)
    steering_->add(t, {t, frame.X_WC, slam::Matrix6d::Zero()}, true);
  add_steering_poses();
  timing_.all.frames.push_back(std::exchange(timing_.frame, {}));
}

// Decides a due footstep or corrects a commanded velocity. Uses exactly the frames that the decision may
// depend on, so that drawing images in parallel makes no difference.
void Run::steer() {
  if (robot_->is_ok() && read_.scenario.walk.steering.by == walking::SteeredBy::legs)
    return robot_->steer(robot_.legs());
  const auto tick = static_cast<std::size_t>(robot_->world().time() / walking::kTick);
  if (!steering_ || !robot_->is_ok() || !robot_->controller().steers(tick)) return;
  const slam::Stamp until = steering_->usable_until(robot_->world().time());
  while (!frames_.empty() && frames_.next_stamp() <= until) deliver_frame();
  if (tracking_) {
    tracking_->advance(until);
    timing_.frame.filter_ms += tracking_->cpu_ms();
    add_steering_poses();
  }
  const result::StageClock clock(timing_.frame.plan_and_physics_ms);
  robot_->controller().steer(tick, steering_->newest(until));
}

// If estimates steer the walk, adds the estimator's answers with the times when they take effect.
void Run::add_steering_poses() {
  if (!tracking_ || read_.scenario.walk.steering.by != walking::SteeredBy::estimate) return;
  const std::vector<tracking::TrackedFrame>& answers = tracking_->answers();
  for (; steering_answers_ < answers.size(); ++steering_answers_) {
    const auto& [pose, report, took, effect] = answers[steering_answers_];
    if (pose)
      steering_->add(effect, {pose->t, pose->X_WC, pose->covariance.value_or(slam::Matrix6d::Zero())},
                     report.health == slam::Health::ok);
  }
}

result::RunRecord Run::record(const std::filesystem::path& folder) {
  frames_.close_cameras();
  if (const auto corrections = robot_->controller().corrections()) writer_.add(recorded(*corrections));
  const std::optional<std::string> complaint = check_.complaint();
  writer_.add("self_check.json", check_.json());
  if (const std::string answers = robot_->controller().answers(); !answers.empty())
    writer_.add("controller.json", answers);
  timing_.all.controller_ms = robot_->controller().took_ms();
  writer_.finish();
  const physics::Status& status = robot_->world().status();
  scenario::Ended ended{ending(status.condition), status.cause};
  if (const auto cause = robot_->controller().stopped(); cause && ended.ending == scenario::Ending::completed)
    ended = {scenario::Ending::stopped, *cause};
  std::string log;
  try {
    if (const auto& failure = robot_->failure()) throw *failure;
    log = robot_->controller().finish();
  } catch (const programs::ProgramFailed& failure) {
    ended = {scenario::Ending::walker_failed, failure.what()};
    log = failure.log;
  }
  if (!log.empty()) files::write_text(folder.parent_path() / "controller.log", log);
  if (ended.ending != scenario::Ending::failed && complaint) ended = {scenario::Ending::failed, *complaint};
  result::RunRecord left{read_, ended, setup_, recording::read_truth(folder), std::nullopt, ""};
  if (tracking_) left.tracked = tracking_->finish();
  left.recording_hash = recording::RecordingReader(folder).hash();
  return left;
}

}  // namespace

std::optional<walking::PatternGenerator> check(const scenario::ReadScenario& read,
                                               const std::filesystem::path& models) {
  const Start start(read, models);
  if (!start.plan) {
    start.controller(read)->finish();
    return std::nullopt;
  }
  SensingRobot robot(read.scenario, start.controller(read), start.models);
  const recording::RecordingSetup setup = robot.setup(read.scenario, start.models.robot);
  if (read.scenario.slam && read.scenario.estimator.source == programs::Source::program)
    programs::require_program(read.scenario.estimator, "estimator");
  else if (read.scenario.slam)
    tracking::Tracking(read.scenario, setup.calibration, setup.X_WC_start, setup.camera_rate_hz, setup.rig,
                       setup.joints);
  return start.plan;
}

result::Outcome run(const scenario::ReadScenario& scenario, const result::ResultPlace& place,
                    const result::Progress& progress, int threads, const RunObserver& observer) {
  const Start start(scenario, place.models);
  const RunObserver unobserved;
  return result::make_sessions(
      scenario, place, progress,
      [&](const scenario::ReadScenario& read, const estimators::Session& before,
          const result::ResultPlace& to, const std::filesystem::path& into, const result::Progress& part) {
        const bool is_last = &read == &scenario;
        const std::optional<Start> other =
            is_last ? std::nullopt : std::optional<Start>(std::in_place, read, place.models);
        const std::filesystem::path recording = into / "recording";
        Run live(read, before, other ? *other : start, recording, threads, is_last ? observer : unobserved);
        live.walk(part);
        result::RunRecord record = live.record(recording);
        return result::write_result(into, record, to, live.timing(), live.time_s());
      });
}

}  // namespace sim::live
