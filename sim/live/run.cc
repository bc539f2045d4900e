#include "sim/live/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "sim/live/frame_pipeline.h"
#include "sim/live/recorded.h"
#include "sim/live/self_check.h"
#include "sim/live/steering_pose_buffer.h"
#include "sim/physics/walking_robot.h"
#include "sim/sensor_errors/random.h"
#include "walking/leg_odometry.h"
#include "walking/steering.h"

namespace sim::live {
namespace {

/// The walking robot, its own sensors and what it computes from them: readings with noise for the stabilizer,
/// and leg odometry.
class SensingRobot {
 public:
  SensingRobot(const scenario::Scenario& scenario, walking::PatternGenerator plan,
               const physics::Models& models)
      : options_(scenario.stabilizer),
        gyro_(scenario.seed, "felt gyro noise"),
        accelerometer_(scenario.seed, "felt accelerometer noise"),
        robot_(std::move(plan), scenario.stabilizer, scenario.world,
               plant_variation(scenario.seed, scenario.world), models),
        legs_(robot_.reference().X_PB) {
    legs_.add(robot_.world().leg_readings());
  }

  physics::WalkingRobot* operator->() { return &robot_; }
  const physics::WalkingRobot* operator->() const { return &robot_; }
  const walking::LegOdometry& legs() const { return legs_; }

  /// Commands the servos of this tick. Returns the readings without noise.
  walking::SensorReadings command() {
    const walking::SensorReadings ideal = robot_.world().sensor_readings();
    legs_.add(ideal);
    walking::SensorReadings noisy = ideal;
    noisy.gyro += normal(gyro_, options_.gyro_sigma_rad_s);
    noisy.accelerometer += normal(accelerometer_, options_.accelerometer_sigma_m_s2);
    robot_.command(noisy);
    return ideal;
  }

 private:
  static Eigen::Vector3d normal(sensor_errors::Random& random, double sigma) {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    return sigma * Eigen::Vector3d(x, y, z);
  }

  const walking::StabilizerOptions& options_;
  sensor_errors::Random gyro_, accelerometer_;
  physics::WalkingRobot robot_;
  walking::LegOdometry legs_;
};

/// One run. walk() and the functions it calls are in the order of a simulated tick.
class Run {
 public:
  /// folder: of the recording.
  Run(const scenario::ReadScenario& read, walking::PatternGenerator plan, const physics::Models& models,
      const std::filesystem::path& folder, int threads, const RunObserver& observer);

  void walk(const result::Progress& progress);
  result::RunRecord record(const std::filesystem::path& folder);
  const result::Timing& timing() const { return timing_.all; }
  /// A quotient by 1e9 would differ in the last bit from what recordings contain.
  double time_s() const { return 1e-9 * static_cast<double>(robot_->world().time().count()); }

 private:
  void command();
  void step_until(slam::Stamp end);
  void process_frames();
  void stamp_frame();
  void read_imu();
  void deliver_frame();
  void add_steering_poses();
  void steer();

  const scenario::ReadScenario& read_;
  const RunObserver& observer_;
  SensingRobot robot_;
  Mounting mounting_;
  recording::RecordingSetup setup_;
  RigImus imus_;
  FramePipeline frames_;
  recording::RecordingWriter writer_;
  SelfCheck check_;
  std::optional<tracking::Tracking> tracking_;
  std::optional<walking::Steering> steering_;
  std::optional<SteeringPoseBuffer> poses_;  // on their way to steering
  std::size_t poses_added_ = 0;              // answers of the estimator among them
  slam::Observation next_;                   // readings of IMUs, encoders and forces since the last frame
  struct {
    walking::Wrench left, right;  // of the ground on the feet
    recording::TrueFeet feet;     // at its end
  } last_tick_;
  struct {
    result::Timing all;
    result::FrameTiming frame;  // of the next frame
  } timing_;
};

Run::Run(const scenario::ReadScenario& read, walking::PatternGenerator plan, const physics::Models& models,
         const std::filesystem::path& folder, int threads, const RunObserver& observer)
    : read_(read),
      observer_(observer),
      robot_(read.scenario, std::move(plan), models),
      mounting_(mounting(read.scenario, robot_->reference(), models)),
      setup_(recording_setup(read.scenario, mounting_, robot_->reference().X_PB)),
      imus_(read.scenario.rig, places(read.scenario.rig, *models.on_floor), robot_->world()),
      frames_(read.scenario, models, threads > 1),
      writer_(folder, setup_),
      check_{InertialCheck(true_motion(robot_->world())), {}} {
  for (const score::Surface& surface : frames_.surfaces()) writer_.add(surface);
  if (!frames_.surfaces().empty()) check_.view.emplace(setup_.calibration.camera, frames_.surfaces());
  if (observer_.begins) observer_.begins(setup_);
  if (read.scenario.slam) {
    tracking_.emplace(read.scenario, setup_.calibration, setup_.X_WC_start, setup_.camera_rate_hz, setup_.rig,
                      setup_.joints);
  }
  const walking::SteeringOptions& steering = read.scenario.walk.steering;
  if (steering.by == walking::SteeredBy::plan) return;
  steering_.emplace(steering, robot_->plan());
  poses_.emplace(steering, read.scenario.errors.faults, frames_.lead());
}

void Run::walk(const result::Progress& progress) {
  frames_.add_positions(robot_->world());
  process_frames();
  while (robot_->walks()) {
    command();
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

// Every 5 ms.
void Run::command() {
  const result::StageClock clock(timing_.frame.plan_and_physics_ms);
  const slam::Stamp now = robot_->world().time();
  const walking::SensorReadings readings = robot_.command();
  next_.body.push_back(recorded(now, readings));
  writer_.add(next_.body.back());
  last_tick_.left = readings.left, last_tick_.right = readings.right;
}

// In steps of a millisecond.
void Run::step_until(slam::Stamp end) {
  const result::StageClock clock(timing_.frame.plan_and_physics_ms);
  do {
    robot_->world().step();
    frames_.add_positions(robot_->world());
    imus_.read(robot_->world(), next_.rig);
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
  const walking::Reference &from = robot_->reference(), &to = robot_->following();
  read_imu();
  next_.t = world.time();
  next_.plan = planned_motion(from, to, time_s(), mounting_.X_BC);
  const auto [X_OB, p_OS] = robot_.legs().motion(world.leg_readings().q);
  const Eigen::Isometry3d X_OC = X_OB * mounting_.X_BC;
  next_.plan->legs = {X_OC, X_OC.inverse() * p_OS};
  if (poses_) poses_->add(next_.t, *next_.plan);
  if (observer_.stamped)
    observer_.stamped(
        {next_.t, world, from, next_.plan->X_PC, last_tick_.feet, last_tick_.left, last_tick_.right});
  frames_.push({std::exchange(next_, {}), world.X_WC()});
  writer_.add(
      recording::TruePoses{world.time(), world.X_WC(), world.X_WB(), planned_waist(from, to, time_s())});
}

// At the end of each tick, and at each frame's stamp within it.
void Run::read_imu() {
  const physics::ImuReading reading = robot_->world().imu_since_last();
  if (reading.begin == reading.end) return;
  next_.gyro.push_back({reading.begin, reading.end, reading.gyro});
  next_.accelerometer.push_back({reading.begin, reading.end, reading.specific_force});
  const recording::TrueMotion motion = true_motion(robot_->world());
  writer_.add(motion);
  check_.inertial.add(next_.gyro.back(), next_.accelerometer.back(), motion);
}

// To the recording and, when the scenario has one, to the filter.
void Run::deliver_frame() {
  Frame frame = frames_.pop();
  const slam::Stamp t = frame.observation.t;
  timing_.frame.t = t;
  timing_.frame.render_ms = frame.render_ms;
  timing_.frame.encode_ms = frame.encode_ms;
  {
    const result::StageClock clock(timing_.frame.record_ms);
    writer_.add(frame.observation, frame.png, frame.rig_pngs);
    if (check_.view) check_.view->add(frame.observation.image, t, frame.X_WC);
  }
  const auto track = [this](slam::Observation observation) {
    if (!tracking_) return;
    const result::StageClock clock(timing_.frame.filter_ms);
    tracking_->process(std::move(observation));
    timing_.frame.filter_ms += tracking_->external_cpu_ms();
    timing_.frame.landmarks = tracking_->landmarks();
    timing_.frame.answered = tracking_->has_answered();
  };
  tracking::process_observed(std::move(frame.observation), tracking_ ? &*tracking_ : nullptr,
                             observer_.tracking, track);
  if (poses_ && read_.scenario.walk.steering.by == walking::SteeredBy::truth)
    poses_->add(t, {t, frame.X_WC, slam::Matrix6d::Zero()}, true);
  add_steering_poses();
  timing_.all.frames.push_back(std::exchange(timing_.frame, {}));
}

// The answers of the estimator with the times when they take effect.
void Run::add_steering_poses() {
  if (read_.scenario.walk.steering.by != walking::SteeredBy::estimate) return;
  for (const auto& answers = tracking_->answers(); poses_added_ < answers.size(); ++poses_added_) {
    const auto& [pose, report, has_pose, took, effect] = answers[poses_added_];
    poses_->add(effect, {pose.t, pose.X_WC, pose.covariance.value_or(slam::Matrix6d::Zero())},
                report.health == slam::Health::ok);
  }
}

// Decides a due footstep with exactly the frames that it may depend on, so that drawing images beside the
// walk makes no difference.
void Run::steer() {
  const auto tick = static_cast<std::size_t>(robot_->world().time() / walking::kTick);
  if (!steering_ || !robot_->is_ok() || !steering_->is_due(robot_->plan(), tick)) return;
  const slam::Stamp until = poses_->usable_until(robot_->world().time());
  while (!frames_.empty() && frames_.next_stamp() <= until) deliver_frame();
  if (tracking_) {
    const result::StageClock clock(timing_.frame.filter_ms);
    tracking_->advance(until);
  }
  add_steering_poses();
  const result::StageClock clock(timing_.frame.plan_and_physics_ms);
  steering_->decide(robot_->plan(), tick, poses_->newest(until));
}

result::RunRecord Run::record(const std::filesystem::path& folder) {
  frames_.close_cameras();
  if (steering_) writer_.add(recorded(steering_->corrections()));
  const std::string complaint = check_.complaint();
  writer_.add("self_check.json", check_.json());
  writer_.finish();
  const physics::Status& status = robot_->world().status();
  scenario::Ended ended{ending(status.condition), status.cause};
  if (ended.ending == scenario::Ending::completed && steering_ && steering_->stopped_s())
    ended = {scenario::Ending::stopped,
             fmt::format("steering had no estimate for {} s at t = {:.2f} s: the robot stopped on both feet",
                         read_.scenario.walk.steering.lost_s, *steering_->stopped_s())};
  if (ended.ending != scenario::Ending::failed && !complaint.empty())
    ended = {scenario::Ending::failed, complaint};
  result::RunRecord left{read_, ended, setup_, recording::read_truth(folder), std::nullopt, ""};
  if (tracking_) left.tracked = tracking_->finish();
  left.recording_hash = recording::RecordingReader(folder).hash();
  return left;
}

}  // namespace

result::Outcome run(const scenario::ReadScenario& scenario, const result::ResultPlace& place,
                    const result::Progress& progress, int threads, const RunObserver& observer) {
  const physics::WorldOptions& world = scenario.scenario.world;
  physics::Models models(world.robot, world.room, place.models);
  walking::PatternGenerator plan = clear_plan(scenario, models);
  mount_sensors(scenario, models);
  files::AtomicFolder folder(place.folder, place.existing);
  const std::filesystem::path recording = folder.path() / "recording";
  Run live(scenario, std::move(plan), models, recording, threads, observer);
  live.walk(progress);
  const result::Outcome outcome =
      result::write_result(folder.path(), live.record(recording), place, live.timing(), live.time_s());
  folder.commit();
  return outcome;
}

}  // namespace sim::live
