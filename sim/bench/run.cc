#include "sim/bench/run.h"

#include <cmath>
#include <deque>
#include <optional>
#include <utility>

#include "sim/bench/draw.h"
#include "sim/bench/evidence.h"
#include "sim/bench/planned_camera.h"
#include "sim/bench/self_check.h"
#include "sim/stream/random.h"
#include "sim/world/head_camera.h"
#include "sim/world/nominal_body.h"
#include "sim/world/shutter.h"
#include "sim/world/surfaces.h"
#include "sim/world/world.h"
#include "walking/inverse_kinematics.h"
#include "walking/pattern_generator.h"
#include "walking/stabilizer.h"

namespace sim::bench {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
constexpr milliseconds kTick{5};
/// White noise of 200 Hz readings as the stabiliser is given them, rad/s and m/s², whatever errors.* says of
/// those that the filter is given: one walk serves replays with any of them.
constexpr double kFeltGyroSigma = 0.01, kFeltAccelerometerSigma = 0.05;

double seconds(nanoseconds t) { return 1e-9 * static_cast<double>(t.count()); }

// Frame k is taken at the millisecond of the physics nearest to k / rate.
nanoseconds frame_time(int k, double rate_hz) { return milliseconds(std::llround(1e3 * k / rate_hz)); }

Eigen::Vector3d normal(stream::Random& random, double sigma) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return sigma * Eigen::Vector3d(x, y, z);
}

// How camera and chest IMU sit on the robot in its planned posture, by the nominal model.
struct Mounting {
  Eigen::Isometry3d X_BC, X_CG;
};

Mounting mounting(const Scenario& scenario, const walking::JointVector& q, const Eigen::Isometry3d& X_WB,
                  const std::filesystem::path& models) {
  world::WorldOptions bare = scenario.world;
  bare.room = "floor";
  const world::World nominal(bare, {}, q, X_WB, models);
  return {nominal.X_WB().inverse() * nominal.X_WC(), nominal.X_WC().inverse() * nominal.X_WG()};
}

walking::JointVector joints(const walking::Reference& reference) {
  return walking::inverse_kinematics(walking::posture_of(reference)).q;
}

slam::CameraIntrinsics intrinsics(const world::CameraModel& lens) {
  return {lens.width_px,
          lens.height_px,
          lens.fu_px,
          lens.fv_px,
          lens.u0_px,
          lens.v0_px,
          slam::OneParameterRadial{lens.k1_px2}};
}

std::string kind(world::RoomPrimitive::Kind kind) {
  using enum world::RoomPrimitive::Kind;
  switch (kind) {
    case plane:
      return "plane";
    case box:
      return "box";
    case sphere:
      return "sphere";
    case cylinder:
      return "cylinder";
    case ellipsoid:
      return "ellipsoid";
    case capsule:
      return "capsule";
  }
  return "";
}

stream::RecordedSurface recorded(const world::RoomPrimitive& surface) {
  using enum world::RoomPrimitive::Kind;
  const bool round_about_z = surface.kind == cylinder || surface.kind == capsule;
  const Eigen::Vector3d& s = surface.size;
  return {kind(surface.kind), surface.X_WS, round_about_z ? Eigen::Vector3d(s.x(), s.z(), 0) : s};
}

stream::BodyReading::Wrench recorded(const walking::Wrench& wrench) { return {wrench.force, wrench.torque}; }

std::string ending(world::Condition condition) {
  switch (condition) {
    case world::Condition::fell:
      return "fell";
    case world::Condition::feet_touched:
      return "collided";
    case world::Condition::physics_failed:
      return "failed";
    case world::Condition::ok:
      break;
  }
  return "completed";
}

Eigen::Vector3d on_ground(const Eigen::Isometry3d& X) {
  return {X.translation().x(), X.translation().y(), std::atan2(X.linear()(1, 0), X.linear()(0, 0))};
}

stream::TrueFoot true_foot(const Eigen::Isometry3d& X_WS, const Eigen::Isometry3d& X_PS, bool planned_down,
                           const world::SoleContact& felt) {
  return {on_ground(X_WS), on_ground(X_PS), planned_down, felt.load,
          Eigen::Vector3d(felt.creep.x(), felt.creep.y(), felt.creep_yaw)};
}

// A frame whose image is not complete, and the camera's true pose at its stamp.
struct ComingFrame {
  slam::Observation observation;
  Eigen::Isometry3d X_WC;
};

// One run. Every member is used in the order of a simulated millisecond: tick, step, frame.
class Run {
 public:
  Run(const ReadScenario& read, const std::filesystem::path& folder, const std::filesystem::path& models);

  void walk(const Progress& progress);
  Remains remains();
  const Timing& timing() const { return timing_; }
  nanoseconds time() const { return world_.time(); }

 private:
  bool on_its_feet() const { return world_.status().condition == world::Condition::ok; }
  void tick();
  walking::Felt felt();
  void read_imu();
  void record_feet();
  void take_frame_if_due();
  void take_coming_frame();
  nanoseconds lead() const { return camera_ ? camera_->lead() : nanoseconds(0); }
  slam::Observation observe();
  void record_truth(const Eigen::Isometry3d& X_PB);

  const ReadScenario& read_;
  const Scenario& scenario_ = read_.scenario;
  std::filesystem::path folder_;
  Timing timing_;
  FrameTiming frame_timing_;

  walking::PatternGenerator generator_;
  std::size_t ticks_ = generator_.ticks();
  walking::Reference reference_ = generator_.next(), following_ = generator_.next();
  walking::Stabilizer stabilizer_;
  walking::JointVector q_ = joints(reference_);
  Mounting mounting_;
  world::World world_;
  std::optional<world::HeadCamera> camera_;
  world::RecentMotion motion_;
  stream::Random felt_gyro_noise_, felt_accelerometer_noise_;

  stream::RecordingSetup setup_;
  stream::RecordingWriter recording_;
  SelfCheck self_check_{InertialCheck({world_.time(), world_.X_WG(), world_.v_WG()}), {}};
  std::optional<Tracking> tracking_;
  std::vector<slam::InertialSample> gyro_, accelerometer_;  // since the last frame
  std::deque<ComingFrame> coming_;                          // whose shutter is still open
  int frame_ = 0;
};

stream::RecordingSetup setup(const Scenario& scenario, const Mounting& mounting,
                             const Eigen::Isometry3d& X_PB) {
  const world::CameraOptions camera = scenario.camera.value_or(world::CameraOptions{});
  stream::RecordingSetup setup;
  setup.calibration = {intrinsics(world::camera_model(camera)), mounting.X_CG};
  setup.X_WC_start = X_PB * mounting.X_BC;
  setup.camera_rate_hz = camera.rate_hz;
  setup.joints = world::joint_names();
  return setup;
}

Run::Run(const ReadScenario& read, const std::filesystem::path& folder, const std::filesystem::path& models)
    : read_(read),
      folder_(folder),
      generator_(scenario_.walk, world::nominal_body(scenario_.world.robot, models)),
      stabilizer_(scenario_.stabilizer),
      mounting_(mounting(scenario_, q_, reference_.X_PB, models)),
      world_(scenario_.world, draw(scenario_.seed, scenario_.world), q_, reference_.X_PB, models),
      motion_(2 * world::Shutter(scenario_.camera.value_or(world::CameraOptions{})).lead()),
      felt_gyro_noise_(scenario_.seed, "felt gyro noise"),
      felt_accelerometer_noise_(scenario_.seed, "felt accelerometer noise"),
      setup_(setup(scenario_, mounting_, reference_.X_PB)),
      recording_(folder / "recording", setup_) {
  if (scenario_.camera) {
    const world::WorldOptions& w = scenario_.world;
    camera_.emplace(world::load_model(w.robot, w.room, models), *scenario_.camera, w.seed);
    std::vector<score::Surface> surfaces;
    for (const world::RoomPrimitive& primitive : world::room_primitives(camera_->model())) {
      recording_.add(recorded(primitive));
      surfaces.push_back(surface(recorded(primitive)));
    }
    self_check_.view.emplace(setup_.calibration.camera, surfaces);
  }
  if (scenario_.slam) tracking_.emplace(scenario_, setup_.calibration, setup_.X_WC_start);
}

void Run::walk(const Progress& progress) {
  take_frame_if_due();
  for (std::size_t k = 0; k < ticks_ && on_its_feet(); ++k) {
    tick();
    for (nanoseconds t = world_.time(); on_its_feet() && world_.time() < t + kTick;) {
      {
        const StageClock clock(frame_timing_.plan_and_physics_ms);
        world_.step();
      }
      take_frame_if_due();
    }
    read_imu();
    record_feet();
    reference_ = std::exchange(following_, generator_.next());
    progress(static_cast<double>(k + 1) / static_cast<double>(ticks_));
  }
  while (!coming_.empty()) take_coming_frame();
}

// Every 5 ms: plan -> stabiliser -> inverse kinematics -> servos.
void Run::tick() {
  const StageClock clock(frame_timing_.plan_and_physics_ms);
  const walking::Posture posture = stabilizer_.step(reference_, felt());
  const walking::JointVector q = walking::inverse_kinematics(posture).q;
  world_.command(q, (q - q_) / walking::kPeriod);
  q_ = q;
}

// What the stabiliser is given: the robot's own sensors, with the noise that the scenario says they have.
walking::Felt Run::felt() {
  walking::Felt felt = world_.felt();
  recording_.add(stream::BodyReading{world_.time(), felt.q, recorded(felt.left), recorded(felt.right)});
  felt.gyro += normal(felt_gyro_noise_, kFeltGyroSigma);
  felt.accelerometer += normal(felt_accelerometer_noise_, kFeltAccelerometerSigma);
  return felt;
}

void Run::read_imu() {
  const world::ImuReading reading = world_.imu_since_last();
  if (reading.begin == reading.end) return;
  gyro_.push_back({reading.begin, reading.end, reading.gyro});
  accelerometer_.push_back({reading.begin, reading.end, reading.specific_force});
  const stream::TrueMotion motion{reading.end, world_.X_WG(), world_.v_WG()};
  recording_.add(motion);
  self_check_.inertial.take(gyro_.back(), accelerometer_.back(), motion);
}

void Run::record_feet() {
  const auto [left, right] = world_.sole_contacts_since_last();
  const walking::Reference& plan = reference_;
  recording_.add(stream::TrueFeet{
      world_.time(), true_foot(world_.X_WL(), plan.X_PL, plan.support != walking::Support::right, left),
      true_foot(world_.X_WR(), plan.X_PR, plan.support != walking::Support::left, right)});
}

void Run::take_frame_if_due() {
  if (camera_) motion_.see(world_.time(), *world_.model(), *world_.data());
  if (world_.time() == frame_time(frame_, setup_.camera_rate_hz)) {
    ++frame_;
    read_imu();
    coming_.push_back({observe(), world_.X_WC()});
    record_truth(planned_waist(reference_, following_, seconds(world_.time())));
  }
  while (!coming_.empty() && world_.time() >= coming_.front().observation.t + lead()) take_coming_frame();
}

// The image is complete when the shutter has closed, later than its stamp.
void Run::take_coming_frame() {
  auto [observation, X_WC] = std::move(coming_.front());
  coming_.pop_front();
  frame_timing_.t = observation.t;
  if (camera_) {
    const StageClock clock(frame_timing_.render_ms);
    observation.image = camera_->render(motion_, observation.t, scenario_.world.lights_off);
  }
  {
    const StageClock clock(frame_timing_.record_ms);
    recording_.add(observation);
    if (self_check_.view) self_check_.view->take(observation.image, observation.t, X_WC);
  }
  if (tracking_) {
    const StageClock clock(frame_timing_.filter_ms);
    tracking_->take(std::move(observation));
    frame_timing_.landmarks = tracking_->landmarks();
  }
  timing_.frames.push_back(std::exchange(frame_timing_, {}));
}

slam::Observation Run::observe() {
  slam::Observation observation;
  observation.t = world_.time();
  observation.gyro = std::exchange(gyro_, {});
  observation.accelerometer = std::exchange(accelerometer_, {});
  observation.plan = planned_motion(reference_, following_, seconds(world_.time()), mounting_.X_BC);
  return observation;
}

void Run::record_truth(const Eigen::Isometry3d& X_PB) {
  recording_.add(stream::TruePoses{world_.time(), world_.X_WC(), world_.X_WB(), X_PB});
}

Remains Run::remains() {
  camera_.reset();  // the room's textures: more than truth and estimates of a long walk take
  recording_.add("self_check.json", self_check_.json());
  recording_.finish();
  const world::Status& status = world_.status();
  const std::filesystem::path recorded = folder_ / "recording";
  Remains left{
      read_, ending(status.condition), status.cause, setup_, stream::read_truth(recorded), std::nullopt, ""};
  if (const std::string complaint = self_check_.complaint(); left.ending != "failed" && !complaint.empty())
    left.ending = "failed", left.cause = complaint;
  if (tracking_) left.tracked = tracking_->finish();
  left.recording_hash = stream::RecordingReader(recorded).hash();
  return left;
}

}  // namespace

Outcome run(const ReadScenario& scenario, const ResultPlace& place, const Progress& progress) {
  stream::DurableFolder folder(place.folder, place.existing);
  Run live(scenario, folder.path(), place.models);
  live.walk(progress);
  const Outcome outcome =
      write_result(folder.path(), live.remains(), place, live.timing(), seconds(live.time()));
  folder.commit();
  return outcome;
}

}  // namespace sim::bench
