#include "sim/live/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "sim/live/checked_recording.h"
#include "sim/live/frame_pipeline.h"
#include "sim/live/planned_camera.h"
#include "sim/live/plant_variation.h"
#include "sim/live/recorded.h"
#include "sim/live/room_check.h"
#include "sim/live/steering_pose_buffer.h"
#include "sim/physics/nominal_body.h"
#include "sim/physics/walking_robot.h"
#include "sim/sensor_errors/random.h"
#include "walking/steering.h"

namespace sim::live {
namespace {

/// Noise of the readings that the stabiliser is given.
class ReadingNoise {
 public:
  ReadingNoise(std::uint64_t seed, const walking::StabilizerOptions& options)
      : options_(options), gyro_(seed, "felt gyro noise"), accelerometer_(seed, "felt accelerometer noise") {}

  void add_to(walking::SensorReadings& readings) {
    readings.gyro += normal(gyro_, options_.gyro_sigma_rad_s);
    readings.accelerometer += normal(accelerometer_, options_.accelerometer_sigma_m_s2);
  }

 private:
  static Eigen::Vector3d normal(sensor_errors::Random& random, double sigma) {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    return sigma * Eigen::Vector3d(x, y, z);
  }

  const walking::StabilizerOptions& options_;
  sensor_errors::Random gyro_, accelerometer_;
};

physics::WalkingRobot robot(const scenario::Scenario& scenario, const std::filesystem::path& models) {
  walking::PatternGenerator plan(scenario.walk, physics::nominal_body(scenario.world.robot, models));
  return {std::move(plan), scenario.stabilizer, scenario.world,
          plant_variation(scenario.seed, scenario.world), models};
}

/// One run. walk() and the functions it calls are in the order of a simulated tick.
class Run {
 public:
  Run(const scenario::ReadScenario& read, const std::filesystem::path& folder,
      const std::filesystem::path& models, int threads, const RunObserver& observer);

  void walk(const result::Progress& progress);
  result::RunRecord record();
  const result::Timing& timing() const { return timing_; }
  /// As recordings have always had it: a quotient by 1e9 differs in the last bit.
  double time_s() const { return 1e-9 * static_cast<double>(robot_.world().time().count()); }

 private:
  void command();
  void step_until(slam::Stamp end);
  void take_frames();
  void stamp_frame();
  void read_imu();
  void deliver_frame();
  void track(slam::Observation observation);
  void note_place(slam::Stamp frame, const Eigen::Isometry3d& X_WC_true);
  void steer();
  scenario::Ended walk_ending() const;

  const scenario::ReadScenario& read_;
  const RunObserver& observer_;
  std::filesystem::path folder_;
  physics::WalkingRobot robot_;
  ReadingNoise noise_{read_.scenario.seed, read_.scenario.stabilizer};
  Mounting mounting_;
  recording::RecordingSetup setup_;
  walking::LegOdometry legs_{robot_.reference().X_PB};
  FramePipeline frames_;
  CheckedRecording recording_;
  std::optional<tracking::Tracking> tracking_;
  std::optional<walking::Steering> steering_;
  std::optional<SteeringPoseBuffer> places_;  // with steering_
  slam::Observation next_;                    // the IMU readings since the last frame
  walking::Wrench left_, right_;              // of the ground on the feet, of the last tick
  recording::TrueFeet feet_;                  // at its end
  result::Timing timing_;
  result::FrameTiming frame_timing_;
};

Run::Run(const scenario::ReadScenario& read, const std::filesystem::path& folder,
         const std::filesystem::path& models, int threads, const RunObserver& observer)
    : read_(read),
      observer_(observer),
      folder_(folder / "recording"),
      robot_(robot(read.scenario, models)),
      mounting_(mounting(read.scenario, robot_.reference(), models)),
      setup_(recording_setup(read.scenario, mounting_, robot_.reference().X_PB)),
      frames_(read.scenario, models, threads > 1),
      recording_(folder_, setup_, true_motion(robot_.world()), frames_.surfaces()) {
  legs_.take(robot_.world().leg_readings());
  if (observer_.begins) observer_.begins(setup_);
  if (read.scenario.slam) tracking_.emplace(read.scenario, setup_.calibration, setup_.X_WC_start);
  const walking::SteeringOptions& steering = read.scenario.walk.steering;
  if (steering.by == walking::SteeredBy::plan) return;
  steering_.emplace(steering, robot_.plan());
  places_.emplace(steering, read.scenario.errors.faults, frames_.lead());
}

void Run::walk(const result::Progress& progress) {
  frames_.add_positions(robot_.world());
  take_frames();
  while (robot_.walks()) {
    command();
    for (const slam::Stamp end = robot_.world().time() + walking::kTick;
         robot_.is_ok() && robot_.world().time() < end;) {
      step_until(std::min(end, frames_.next_event()));
      take_frames();
    }
    read_imu();
    feet_ = true_feet(robot_.world(), robot_.reference());
    recording_.add(feet_);
    steer();
    robot_.advance();
    progress(robot_.progress());
    if (observer_.ticked) observer_.ticked(robot_.world().time());
  }
  frames_.draw_all();
  while (!frames_.empty()) deliver_frame();
}

// Every 5 ms.
void Run::command() {
  const result::StageClock clock(frame_timing_.plan_and_physics_ms);
  walking::SensorReadings readings = robot_.world().sensor_readings();
  recording_.add(recorded(robot_.world().time(), readings));
  left_ = readings.left, right_ = readings.right;
  legs_.take(readings);
  noise_.add_to(readings);
  robot_.command(readings);
}

// In steps of a millisecond.
void Run::step_until(slam::Stamp end) {
  const result::StageClock clock(frame_timing_.plan_and_physics_ms);
  do {
    robot_.world().step();
    frames_.add_positions(robot_.world());
  } while (robot_.is_ok() && robot_.world().time() < end);
}

void Run::take_frames() {
  const slam::Stamp now = robot_.world().time();
  if (now >= frames_.next_due()) stamp_frame();
  frames_.draw_complete(now);
  while (frames_.is_full()) deliver_frame();
}

void Run::stamp_frame() {
  const physics::World& world = robot_.world();
  const walking::Reference &from = robot_.reference(), &to = robot_.following();
  read_imu();
  next_.t = world.time();
  next_.plan = planned_motion(from, to, time_s(), mounting_.X_BC);
  next_.plan->legs = leg_motion(legs_, world.leg_readings().q, mounting_.X_BC);
  if (places_) places_->add(next_.t, *next_.plan);
  if (observer_.stamped) observer_.stamped({next_.t, world, from, next_.plan->X_PC, feet_, left_, right_});
  frames_.push({std::exchange(next_, {}), world.X_WC()});
  recording_.add(
      recording::TruePoses{world.time(), world.X_WC(), world.X_WB(), planned_waist(from, to, time_s())});
}

// At the end of each tick, and where a frame is stamped within it.
void Run::read_imu() {
  const physics::ImuReading reading = robot_.world().imu_since_last();
  if (reading.begin == reading.end) return;
  next_.gyro.push_back({reading.begin, reading.end, reading.gyro});
  next_.accelerometer.push_back({reading.begin, reading.end, reading.specific_force});
  recording_.add(next_.gyro.back(), next_.accelerometer.back(), true_motion(robot_.world()));
}

// To the recording and, when the scenario has one, to the filter.
void Run::deliver_frame() {
  Frame frame = frames_.pop();
  const slam::Stamp t = frame.observation.t;
  frame_timing_.t = t;
  frame_timing_.render_ms = frame.render_ms;
  frame_timing_.encode_ms = frame.encode_ms;
  {
    const result::StageClock clock(frame_timing_.record_ms);
    recording_.add(frame);
  }
  tracking::process_observed(std::move(frame.observation), tracking_ ? &*tracking_ : nullptr,
                             observer_.tracking,
                             [this](slam::Observation observation) { track(std::move(observation)); });
  if (places_) note_place(t, frame.X_WC);
  timing_.frames.push_back(std::exchange(frame_timing_, {}));
}

void Run::track(slam::Observation observation) {
  if (!tracking_) return;
  const result::StageClock clock(frame_timing_.filter_ms);
  tracking_->process(std::move(observation));
  frame_timing_.filter_ms += tracking_->external_cpu_ms();
  frame_timing_.landmarks = tracking_->landmarks();
}

// The estimate after a frame; where the truth is to steer, the truth as if it were one.
void Run::note_place(slam::Stamp frame, const Eigen::Isometry3d& X_WC_true) {
  if (read_.scenario.walk.steering.by == walking::SteeredBy::truth) {
    places_->add(frame, {frame, X_WC_true, slam::Matrix6d::Zero()}, true);
  } else if (const tracking::TrackedFrame* const newest = tracking_->newest()) {
    const estimators::PoseEstimate& pose = newest->estimate;
    places_->add(frame, {pose.t, pose.X_WC, pose.covariance.value_or(slam::Matrix6d::Zero())},
                 newest->report.health == slam::Health::ok && !tracking_->failed());
  }
}

// Where a footstep is due, with all frames that it may depend on and no others: whether images are drawn
// beside the walk makes no difference.
void Run::steer() {
  const auto tick = static_cast<std::size_t>(robot_.world().time() / walking::kTick);
  if (!steering_ || !robot_.is_ok() || !steering_->is_due(robot_.plan(), tick)) return;
  const slam::Stamp until = places_->usable_until(robot_.world().time());
  while (!frames_.empty() && frames_.next_stamp() <= until) deliver_frame();
  const result::StageClock clock(frame_timing_.plan_and_physics_ms);
  steering_->decide(robot_.plan(), tick, places_->newest(until));
}

scenario::Ended Run::walk_ending() const {
  const physics::Status& status = robot_.world().status();
  if (status.condition == physics::Condition::ok && steering_ && steering_->stopped_s())
    return {scenario::Ending::stopped,
            fmt::format("steering had no estimate for {} s at t = {:.2f} s: the robot stopped on both feet",
                        read_.scenario.walk.steering.lost_s, *steering_->stopped_s())};
  return {ending(status.condition), status.cause};
}

result::RunRecord Run::record() {
  frames_.close_camera();
  if (steering_) recording_.add(recorded(steering_->corrections()));
  const std::string complaint = recording_.finish();
  result::RunRecord left{read_, walk_ending(), setup_, recording::read_truth(folder_), std::nullopt, ""};
  if (left.walk.ending != scenario::Ending::failed && !complaint.empty())
    left.walk = {scenario::Ending::failed, complaint};
  if (tracking_) left.tracked = tracking_->finish();
  left.recording_hash = recording::RecordingReader(folder_).hash();
  return left;
}

}  // namespace

result::Outcome run(const scenario::ReadScenario& scenario, const result::ResultPlace& place,
                    const result::Progress& progress, int threads, const RunObserver& observer) {
  require_clear_walk(scenario, place.models);
  files::DurableFolder folder(place.folder, place.existing);
  Run live(scenario, folder.path(), place.models, threads, observer);
  live.walk(progress);
  const result::Outcome outcome =
      result::write_result(folder.path(), live.record(), place, live.timing(), live.time_s());
  folder.commit();
  return outcome;
}

}  // namespace sim::live
